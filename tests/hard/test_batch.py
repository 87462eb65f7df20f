"""`metrology batch`: what is made, what is left alone, what is told of the rest."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path

import pytest
from certificates import WHOLE

from metrology import audit_trail
from metrology.batch import bundle, find, index, outcome, stamp
from metrology.cli import main
from metrology.errors import MetrologyError
from metrology.watch import board

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.long
REFERENCE = ROOT / "tests" / "reference"
HOSTILE = '<script>alert(1)</script>" onload="x'
CAMPAIGN = """\
format: metrology-campaign/1
id: {id}
title: '{title}'
quantities:
  viscosity: {{value: 13.6 mm^2/s, uncertainty: [{{standard: 1.8 mm^2/s}}]}}
derived:
  - {{quantity: nu, expression: viscosity, unit: mm^2/s}}
requirements:
  - {{id: R1, quantity: nu, limits: {{lower: {lower} mm^2/s}}, decision: {{rule: simple acceptance}}}}
"""


def write(folder: Path, text: str) -> Path:
    folder.mkdir(parents=True)
    (folder / "campaign.yaml").write_text(text)
    return folder / "campaign.yaml"


def stated(**changes: str) -> str:
    return CAMPAIGN.format(**{"id": "oil", "title": "Oil", "lower": "12.5"} | changes)


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    """Five campaigns, three of which cannot be made or fail; made once."""
    place = tmp_path_factory.mktemp("batch")
    write(place / "lab" / "deep" / "er" / "oil", stated(title=HOSTILE))
    write(place / "lab" / "poor", stated(id="poor", lower="14.5"))
    write(place / "lab" / "broken", "format: metrology-campaign/1\nid: ../broken\ntitle: [\x09<b>\n")
    write(place / "lab" / "wrong", stated(id="wrong").replace("13.6 mm^2/s", "13.6 <b>"))
    write(place / "lab" / "zwin", stated())
    write(place / "lab" / ".hidden", stated(id="hidden"))
    (place / "reports" / "wrong").mkdir(parents=True)
    (place / "reports" / "wrong" / "report.html").write_text("an older one")
    return place


def run(batch: Path, *options: str) -> int:
    return main(["batch", str(batch / "lab"), "--output", str(batch / "reports"), "--workers", "1", *options])


@pytest.fixture(scope="module")
def ran(batch):
    os.environ["NO_COLOR"] = "1"
    command = [sys.executable, "-m", "metrology", "batch", "lab", "--output", "reports", "--workers", "2"]
    return subprocess.run(
        command, cwd=batch, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)}
    )


def test_law_a_campaign_that_fails_does_not_stop_the_others(ran, batch):
    assert (ran.returncode, ran.stderr) == (1, "")
    states = re.findall(r"^(made|up to date|not made) +lab/(\S+)/campaign.yaml *(.*)$", ran.stdout, re.MULTILINE)
    assert states == [
        ("not made", "broken", ""),
        ("made", "deep/er/oil", "1 pass"),
        ("made", "poor", "1 fail"),
        ("not made", "wrong", ""),
        ("not made", "zwin", ""),
    ]
    assert ran.stdout.splitlines()[-1] == ("5 campaigns: 2 made, 0 up to date, 3 not made; index: reports/index.html")
    assert sorted(path.name for path in (batch / "reports").iterdir()) == ["index.html", "oil", "poor", "wrong"]


def test_refusal_reasons_name_the_files_of_the_user(ran):
    assert re.search(r"lab/wrong/campaign.yaml:5:\d+ quantities.viscosity.value: got the unit '<b>'", ran.stdout)
    assert "lab/zwin/campaign.yaml id: got 'oil', the id of lab/deep/er/oil/campaign.yaml too" in ran.stdout
    assert "lab/broken/campaign.yaml:3" in ran.stdout
    assert "metrology-" not in ran.stdout.replace("metrology-campaign", "")


def test_twice_batch_writes_what_report_writes(ran, batch, tmp_path):
    assert main(["report", str(batch / "lab" / "poor"), "--output", str(tmp_path)]) == 1
    for file in (tmp_path / "poor").iterdir():
        if file.name == audit_trail.NAME:  # it states when, and by which command
            continue
        assert (batch / "reports" / "poor" / file.name).read_bytes() == file.read_bytes()


class Page(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text += data


def test_law_index_shows_hostile_text_as_text_and_links_what_is_there(ran, batch):
    page = Page((batch / "reports" / "index.html").read_text("utf-8"))
    assert not {tag for tag, _ in page.tags} & {"b", "img", "iframe"}
    assert [tag for tag, _ in page.tags].count("script") == len(index.SCRIPTS)
    assert HOSTILE in page.text
    assert "of an older run" in page.text
    policy = next(a["content"] for _, a in page.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'; ")
    assert "unsafe" not in policy
    links = [a["href"] for tag, a in page.tags if tag == "a" and not a["href"].startswith("#")]
    assert list(dict.fromkeys(link for link in links if link.endswith(".html"))) == [
        "oil/report.html", "poor/report.html", "wrong/report.html",
    ]  # fmt: skip


def test_law_nothing_is_made_twice(ran, batch, capsys):
    before = {path: path.stat().st_mtime_ns for path in (batch / "reports").glob("*/*")}
    assert run(batch, "--json") == 1
    found = {Path(one["path"]).parent.name: one for one in json.loads(capsys.readouterr().out)}
    states = {name: one["state"] for name, one in found.items()}
    assert states == {
        "broken": "not made", "oil": "up to date", "poor": "up to date", "wrong": "not made", "zwin": "not made",
    }  # fmt: skip
    assert found["poor"]["verdicts"] == {"fail": 1}
    assert {path: path.stat().st_mtime_ns for path in (batch / "reports").glob("*/*")} == before


EFFECT = """\
from pathlib import Path
from metrology.rig.own import OwnEffect, OwnParameter
Path({marker!r}).touch()
pointer = OwnEffect(
    "pointer", "Pointer that jumps", "x = … + a where F > 15 N",
    (OwnParameter("jump", "m", null=0.0, low=-1e-3, high=1e-3, scale=1e-5, meaning="size of the jump"),),
    "one step at a load", "k too small", "clean the rack", "gauge blocks",
    reading=lambda F, order, back: (F > 15).astype(float),
)
"""


def test_refusal_code_of_a_campaign_is_run_by_a_batch_only_where_that_is_asked(tmp_path, capsys):
    path = write(tmp_path / "lab", stated() + "diagnosis: {effects: [pointer.py]}\n")
    path.with_name("pointer.py").write_text(EFFECT.format(marker=str(tmp_path / "ran")), encoding="utf-8")
    assert run(tmp_path) == 1
    assert "Python code of the campaign's own (pointer.py)" in capsys.readouterr().out
    assert not (tmp_path / "ran").exists()
    assert run(tmp_path, "--allow-code") == 0
    assert (tmp_path / "ran").exists()
    assert "1 made" in capsys.readouterr().out


@pytest.fixture
def report(ran, batch, tmp_path):
    """One report with the key by which it is up to date."""
    folder = tmp_path / "reports" / "poor"
    shutil.copytree(batch / "reports" / "poor", folder)
    return folder, json.loads((folder / stamp.NAME).read_text())["key"]


def test_law_a_report_with_signatures_is_up_to_date(report):
    folder, key = report
    assert stamp.fresh(folder, key)
    with (folder / "report.pdf").open("ab") as file:
        file.write(b"a signature")
    assert stamp.fresh(folder, key)


@pytest.mark.parametrize("name", ["report.pdf", "report.html", "results.json", "results.csv", stamp.NAME])
@pytest.mark.parametrize("change", ["gone", "changed", "empty"])
def test_planted_output_that_is_not_what_was_made(report, name, change):
    folder, key = report
    content = (folder / name).read_bytes()
    (folder / name).unlink()
    if change != "gone":
        (folder / name).write_bytes(content[:30] + b"?" + content[31:] if change == "changed" else b"")
    assert not stamp.fresh(folder, key)


def test_planted_stamp_that_names_nothing(report):
    folder, key = report
    (folder / stamp.NAME).write_text(json.dumps({"schema": stamp.SCHEMA, "key": key, "files": {}}))
    assert not stamp.fresh(folder, key)


def test_law_key_follows_the_inputs_and_where_they_lie(tmp_path):
    home = shutil.copytree(REFERENCE / "gum-h2-resistance-reactance", tmp_path / "a" / "h2")
    (home / "note.txt").write_text("not read by the campaign")
    first = bundle.pack(home / "campaign.yaml", tmp_path / "reports")
    assert sorted(first.files) == ["a/h2/campaign.yaml", "a/h2/readings.csv"]
    moved = shutil.copytree(tmp_path / "a", tmp_path / "there" / "a")
    assert stamp.key(bundle.pack(moved / "h2" / "campaign.yaml", tmp_path / "there" / "reports")) == stamp.key(first)
    elsewhere = stamp.key(bundle.pack(home / "campaign.yaml", tmp_path / "other"))
    (home / "note.txt").write_text("changed")
    assert stamp.key(bundle.pack(home / "campaign.yaml", tmp_path / "reports")) == stamp.key(first)
    with (home / "readings.csv").open("a") as file:
        file.write("\n")
    changed = stamp.key(bundle.pack(home / "campaign.yaml", tmp_path / "reports"))
    assert len({stamp.key(first), elsewhere, changed}) == 3


@pytest.mark.parametrize("place", ["templates/cover.html", "metrology/gum/law.py"])
def test_law_code_follows_templates_and_modules(tmp_path, place):
    for name in ("metrology", "templates"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / place).open("a") as file:
        file.write("\n")
    command = [sys.executable, "-c", "from metrology.batch import stamp; print(stamp.code())"]
    changed = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.strip()
    assert len(changed) == len(stamp.code())
    assert changed != stamp.code()


def test_law_an_extending_campaign_brings_the_other_ones_readings(tmp_path):
    shutil.copytree(REFERENCE / "gum-h2-resistance-reactance", tmp_path / "first")
    text = (tmp_path / "first" / "campaign.yaml").read_text()
    (tmp_path / "secret.csv").write_text("not of this campaign")
    path = write(tmp_path / "second", text + "extends: ../first/campaign.yaml\nremark: ../secret.csv\n")
    packed = bundle.pack(path, tmp_path / "reports")
    assert sorted(packed.files) == ["first/campaign.yaml", "first/readings.csv", "second/campaign.yaml"]
    with bundle.unpacked(packed) as root:
        assert (root / "second" / ".." / "first" / "readings.csv").is_file()
    assert not root.exists()


def test_planted_certificates_and_results_of_other_campaigns_travel_and_are_inputs(ran, batch, tmp_path):
    results = (batch / "reports" / "poor" / "results.json").read_bytes()
    imported = f"from: cal.json, result: nu, sha256: {sha256(results).hexdigest()}"
    text = stated(id="use", lower="1").replace("value: 13.6 mm^2/s, uncertainty: [{standard: 1.8 mm^2/s}]", imported)
    path = write(tmp_path / "lab", f"{text}instruments: {{gauge: {{kind: gauge, certificate: {{dcc: k.xml}}}}}}\n")
    (tmp_path / "lab" / "cal.json").write_bytes(results)
    (tmp_path / "lab" / "k.xml").write_text(WHOLE)
    assert main(["batch", str(tmp_path / "lab"), "--output", str(tmp_path / "reports"), "--workers", "1"]) == 0
    assert sorted(bundle.pack(path, tmp_path).files) == ["lab/cal.json", "lab/campaign.yaml", "lab/k.xml"]
    states = []
    for name in ("cal.json", "k.xml"):
        states.append(board.content(path))
        with (tmp_path / "lab" / name).open("a") as file:
            file.write(" ")
    assert len({*states, board.content(path)}) == 3


@pytest.mark.parametrize("extends", ["/etc/passwd", "../../../../../../etc/passwd", "../secret.csv"])
def test_refusal_what_is_no_campaign_does_not_travel(tmp_path, extends):
    (tmp_path / "secret.csv").write_text("not of this campaign")
    packed = bundle.pack(write(tmp_path / "own", stated() + f"extends: {extends}\n"), tmp_path / "reports")
    assert len(packed.files) == 1


def test_refusal_folder_without_campaigns(tmp_path):
    with pytest.raises(MetrologyError, match=r"got no campaign.yaml at any depth"):
        find(tmp_path)
    with pytest.raises(MetrologyError, match=r"got no folder"):
        find(tmp_path / "nowhere")


def test_refusal_no_workers(batch, capsys):
    assert main(["batch", str(batch / "lab"), "--workers", "0"]) == 2
    assert "--workers: got 0; expected 1 at least" in capsys.readouterr().err


def test_limit_index_of_one_up_to_date(tmp_path):
    results = json.dumps({"campaign": {"id": "a", "title": "A"}, "conformity": [], "failures": []}).encode()
    text = index.page([outcome.done(Path("a/campaign.yaml"), "up to date", results)], tmp_path).decode()
    assert "1 campaign: 0 made, 1 up to date, 0 not made." in text
    assert "What failed" not in text
