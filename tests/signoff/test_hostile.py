"""Hostile strings in every text field of one campaign: they appear as text, nothing is fetched, nothing is embedded."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Any

import pytest
import yaml
from good_campaign import CAMPAIGN, FILES
from pypdf import PdfReader

from metrology import chain, report
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources

PAYLOADS = (
    "<script>alert(1)</script>",
    "<img src='http://host.invalid/x.png' onerror=alert(1)>",
    "<link rel=attachment href='file:///etc/passwd'>",
    "<a rel=attachment href='file:///etc/hostname'>x</a>",
    "</style></title><style>@import url(http://host.invalid/x.css)</style>",
    "{{ 7 * 191 }}{% include 'x' %}{{ cycler.__init__.__globals__ }}",
    "file:///etc/passwd http://host.invalid/ url(http://host.invalid) plot:0",
    "\u202etxet\u202c \u2066x\u2069 \u200f \x85 \ufeff",
    "--> ]]> %PDF-1.7 (\\) endobj /JS (app.alert)",
)
FURTHER = {
    "purpose": "p",
    "place": "p",
    "sampling": "s",
    "assumptions": ["a"],
    "provided": [{"what": "w", "by": "b", "role": "customer"}],
    "opinions": [{"text": "t", "by": "b", "basis": "b"}],
    "documents": [{"number": "n", "title": "t", "edition": "e", "role": "reference"}],
}
TEXTS = {
    *("title", "reconstructed", "authorised_by", "remarks", "name", "address", "contact", "function", "kind"),
    *("manufacturer", "model", "serial", "class", "laboratory", "number", "material", "batch", "condition", "operator"),
    *("reason", "source", "text", "deviations", "purpose", "place", "sampling", "assumptions", "what", "by", "basis"),
    *("edition", "figure"),
}
NAMES = {("predict", "name")}
"""Keys that are texts elsewhere, and names here."""


class Poison:
    """Appends the payloads, one after the other, to every text of a campaign."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, value: Any, key: str = "", parent: str = "") -> Any:
        if isinstance(value, dict):
            return {name: self(entry, name, key) for name, entry in value.items()}
        if isinstance(value, list):
            return [self(entry, key, key if isinstance(entry, dict) else parent) for entry in value]
        if key not in TEXTS or (parent, key) in NAMES:
            return value
        self.count += 1
        return f"{value} {PAYLOADS[self.count % len(PAYLOADS)]} text{self.count}."


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[int, dict[str, bytes]]:
    folder = tmp_path_factory.mktemp("hostile")
    data = yaml.load(CAMPAIGN, yaml.BaseLoader) | FURTHER
    data["report"]["remarks"] = "r"
    data["report"]["signatures"] = {"author": {"name": "a", "function": "f"}}
    data["monte_carlo"] = {"digits": "1", "max_trials": "10000"}
    poison = Poison()
    text = yaml.safe_dump(poison(data), allow_unicode=False, sort_keys=False, default_style='"')
    (folder / "campaign.yaml").write_text(text, encoding="utf-8")
    for name, content in FILES.items():
        (folder / name).write_text(content, encoding="utf-8")
    loaded = load(folder / "campaign.yaml")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket.socket, "connect", _refuse)
        files = report.make(chain.evaluate(loaded), sources=read_sources(loaded))
    return poison.count, files


def _refuse(*_: object) -> None:
    raise AssertionError("something was to be fetched")


def test_refusal_html_shows_the_texts_as_texts(made):
    count, files = made
    text = files["report.html"].decode()
    assert count > 45
    missing = [i for i in range(1, count + 1) if f"text{i}." not in text]
    assert len(missing) <= count // 5, missing  # some texts of a campaign are not printed
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in text
    assert "{{ 7 * 191 }}" in text
    assert "1337" not in text.split("<body")[1].split("</header>")[0]
    assert not [c for c in text if 0x202A <= ord(c) <= 0x202E or 0x2066 <= ord(c) <= 0x2069]
    assert not {tag for tag in ("<link", "<iframe", "<img", "<object", "onerror=alert(1)>") if tag in text}


@pytest.mark.long
def test_refusal_pdf_embeds_nothing_and_links_nowhere(made, tmp_path: Path):
    _, files = made
    (tmp_path / "report.pdf").write_bytes(files["report.pdf"])
    reader = PdfReader(tmp_path / "report.pdf")
    ours = {"campaign.yaml", *FILES, "results.json", "results.csv", "ro-crate-metadata.json"}
    assert set(reader.attachments) == ours
    annotations = [entry.get_object() for page in reader.pages for entry in page.get("/Annots", [])]
    assert {entry["/Subtype"] for entry in annotations} == {"/Link"}
    assert not [entry for entry in annotations if "/A" in entry]
    assert not {"/OpenAction", "/AA", "/JavaScript"} & reader.trailer["/Root"].keys()
    words = "".join(page.extract_text() for page in reader.pages)
    assert "alert(1)" in words
    assert "root:" not in words
