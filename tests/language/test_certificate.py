"""A report in another language: nothing of it stays English by oversight, and every number is the same."""

from __future__ import annotations

import re
import runpy
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path

import pytest
from babel.messages.catalog import Catalog
from babel.messages.pofile import read_po, write_po
from jinja2 import Environment, nodes
from pypdf import PdfReader

from metrology.cli import main
from metrology.findings import Findings, from_json
from metrology.language import catalogue
from metrology.message import counted, said
from metrology.report import make
from metrology.signoff import printed

ROOT = Path(__file__).parents[2]
CODES = ("de", "fr", "it", "es")
CAMPAIGN = """\
format: metrology-campaign/1
id: zz
title: Zztitle
report:
  number: Zz-1
  issued: 2026-11-20
  authorised_by: Zz
  signatures: {author: {name: Zz, function: Zz}, approver: {name: Zza, function: Zz}}
  checklists: [17025]
laboratory: {name: Zzlab, address: Zz, contact: Zz, country: ZZ}
customer: {name: Zz, address: Zz, contact: Zz}
reconstructed: Zz
seed: 5
deviations: [Zz]
anomalies: [{id: Zz-7, text: Zz, state: open}]
provided: [{what: Zz, by: Zz, role: customer}]
instruments:
  zz-dial:
    kind: Zz
    resolution: 0.01 mm
    certificate: {number: Zz, laboratory: Zz, date: 2024-03-02, due: 2025-03-02, expanded_uncertainty: 2 um, k: 2}
samples:
  zz-wire: {name: Zzwire, received: 2026-09-28, density: 7800 kg/m3,
            section: {shape: round, diameter: 0.500(1) mm}, length: 2.000(1) m,
            references: {E: {value: 150(2) GPa, source: Zz}}}
tests:
  zz-slow:
    method: elongation
    sample: zz-wire
    date: 2026-10-05
    operator: Zz
    instruments: {extension: zz-dial}
    gravity: {value: 9.81 m/s2, source: Zz}
    readings: zz.csv
    loads: {zz-a: {mass: 1 kg}, zz-b: {mass: 2.0000(1) kg}, zz-c: {mass: 3.0000(1) kg}, zz-d: {mass: 4.0000(1) kg}}
  zz-slow-2:
    method: elongation
    sample: zz-wire
    date: 2026-10-06
    operator: Zz
    instruments: {extension: zz-dial}
    gravity: {value: 9.81 m/s2, source: Zz}
    readings: zz-2.csv
    loads: {zz-a: {mass: 1 kg}, zz-b: {mass: 2.0000(1) kg}, zz-c: {mass: 3.0000(1) kg}, zz-d: {mass: 4.0000(1) kg}}
requirements:
  - {id: Zz-R1, text: Zz, quantity: zz-slow.k, limits: {lower: 10 kN/m}, decision: {rule: simple acceptance}}
  - {id: Zz-R2, text: Zz, quantity: zz-slow.E, limits: {lower: 199 GPa}, decision: {rule: guard band, factor: 1.0}}
  - {id: Zz-R3, text: Zz, quantity: zz-slow-2.k, limits: {lower: 10 kN/m}, decision: {rule: simple acceptance}}
"""


def readings(shift: float) -> str:
    """Up and down twice over four loads; one reading off by `shift` mm."""
    rows, at = ["load,repeat,direction,reading / mm"], 0
    for repeat in range(1, 4):
        for direction, loads in (("loading", "abcd"), ("unloading", "dcba")):
            for load in loads:
                at += 1
                noise = 0.01 * ((7 * at) % 5 - 2) * 0.3 + (shift if at == 6 else 0.0)
                rows.append(f"zz-{load},{repeat},{direction},{0.481 * ('abcd'.index(load) + 1) + noise:.2f}")
    return "\n".join(rows) + "\n"


def folder_of(place: Path) -> Path:
    (place / "zz.csv").write_text(readings(0.0), encoding="utf-8")
    (place / "zz-2.csv").write_text(readings(0.4), encoding="utf-8")
    (place / "campaign.yaml").write_text(CAMPAIGN, encoding="utf-8")
    return place


@pytest.fixture(scope="module")
def marked(tmp_path_factory: pytest.TempPathFactory) -> Findings:
    """Findings of a campaign all of whose own texts begin with Zz, with much to be noted."""
    place = folder_of(tmp_path_factory.mktemp("marked"))
    assert main(["report", str(place / "campaign.yaml"), "--output", str(place / "out")]) in (0, 1)
    return from_json(place / "out" / "zz" / "results.json")


WHOLE = ("certificate", "annex", "quality")


def spoken(findings: Findings, *codes: str, sign: str = "comma", parts: tuple[str, ...] = ("certificate",)) -> Findings:
    campaign = replace(findings.campaign, languages=codes, decimal_sign=sign, parts=parts)
    return replace(findings, campaign=campaign)


@pytest.mark.long
@pytest.mark.parametrize(("code", "expected"), [("de", "nach dem GUM-Verfahren"), ("es", "por el método de la GUM")])
def test_what_an_audited_figure_is_by_monte_carlo_is_said_in_the_language(code: str, expected: str):
    import metrology

    half = {"half_width": "4 N", "distribution": "rectangular"}
    stated = {
        "format": "metrology-campaign/1", "id": "audited", "title": "Zz",
        "quantities": {"p": "10 N", "q": {"value": "10 N", "uncertainty": [half]}},
        "derived": [{"quantity": "R", "expression": "p / q", "unit": "1"}],
        "audit": [{"figure": "Zz", "quantity": "R", "published": "1.00"}],
    }  # fmt: skip
    findings = metrology.run(stated, coverage=False).findings
    page = make(spoken(findings, code, parts=WHOLE))["report.html"].decode()
    assert expected in page
    assert "by the GUM framework, Monte" not in page


# ---- no English by oversight ----------------------------------------------------------------------------------------
class Texts(HTMLParser):
    """Texts that a reader of the page meets, one after another."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self._hidden = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._hidden += tag in ("style", "script")
        self.found += [value for name, value in attrs if name == "alt" and value]

    def handle_endtag(self, tag: str) -> None:
        self._hidden -= tag in ("style", "script")

    def handle_data(self, data: str) -> None:
        if not self._hidden:
            self.found.append(data)


def disguised(text: str) -> str:
    """A message whose own letters are all ä; what its values bring, and its markup, stay."""
    return "".join(
        piece if re.fullmatch(r"\{[^}]*\}|%\(\w+\)s|<[^>]*>|&\w+;", piece) else re.sub("[A-Za-z]", "ä", piece)
        for piece in re.split(r"(\{[^}]*\}|%\(\w+\)s|<[^>]*>|&\w+;)", text)
    )


@pytest.fixture
def in_disguise(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A catalogue for `de` in which every message has no letter but ä."""
    with (catalogue.LOCALE / "de" / "LC_MESSAGES" / "metrology.po").open("rb") as file:
        known = read_po(file, locale="de")
    made = Catalog(locale="de")
    for one in known:
        if one.id:
            string = tuple(map(disguised, one.id)) if isinstance(one.id, tuple) else disguised(one.id)
            made.add(one.id, string, context=one.context)
    place = tmp_path / "de" / "LC_MESSAGES" / "metrology.po"
    place.parent.mkdir(parents=True)
    with place.open("wb") as file:
        write_po(file, made)
    monkeypatch.setattr(catalogue, "LOCALE", tmp_path)
    catalogue.read.cache_clear()
    yield
    catalogue.read.cache_clear()


OWN = re.compile(r"[Zz]z\w*(-\w+)*|\b(csv|yaml|GPa|mm|kN|rad|kg|MC)\b")
"""Texts of the campaign, units, and the mark of the Monte Carlo method."""
NAMES = re.compile(
    r"\b[0-9a-f]{64}\b|(?:[A-Z]\. )+[A-Z][\w’]+,? .*|(?:JCGM|ISO|ILAC|ASTM|ASME|IEC)\b.*|Space tethers: .*"
    r"|[\w*]+(?:\.[\w*-]+)+|\w+ \d+\.\d+\.\d+|SHA-256|\b[A-Za-z]_\w+"
)
"""Of the annex: hashes, references, keys of files, versions, symbols with an index."""
KEYS = {"sampling", "provided", "opinions", "place", "laboratory", "customer", "requirements", "condition",
        "deviations", "error", "reading", "slope", "correction", "delta", "rho", "eff", "derived", "tests", "indicator",
        "diameter", "mm", "nm", "MPa", "ro", "crate", "weasyprint"}  # fmt: skip
"""Keys of the campaign, names of parameters as `extended.yaml` has them, units and products."""
WORD = re.compile(r"[A-Za-z]{2,}")


def english(findings: Findings) -> set[str]:
    """Words of a page in disguise that no catalogue holds."""
    page = Texts()
    page.feed(make(findings)["report.html"].decode("utf-8"))
    return {word[0] for text in page.found for word in WORD.finditer(OWN.sub("", NAMES.sub("", text)))}


@pytest.mark.usefixtures("in_disguise")
def test_no_word_of_the_certificate_bypasses_the_catalogue(marked: Findings):
    assert english(spoken(marked, "de")) == set()


@pytest.mark.long
@pytest.mark.usefixtures("in_disguise")
def test_no_word_of_a_whole_report_bypasses_the_catalogue(marked: Findings):
    assert english(spoken(marked, "de", parts=WHOLE)) <= KEYS


@pytest.mark.usefixtures("in_disguise")
def test_a_sentence_that_bypasses_the_catalogue_is_found(marked: Findings):
    assert english(replace(spoken(marked, "de"), warnings=("A sentence of nobody.",))) >= {"sentence", "nobody"}


# ---- templates ------------------------------------------------------------------------------------------------------
TEMPLATES = runpy.run_path(str(ROOT / "scripts" / "catalogue.py"))["TEMPLATES"]
SYMBOLS = {
    "N", "m", "mm", "rad", "s", "kg", "GPa", "kN", "nm", "MC", "RMS", "NRMS", "ln", "SHA", "E", "M", "P", "R", "r", "u",
    "σ", "metrology", "verify", "extended.yaml",
}  # fmt: skip
"""Symbols, units and abbreviations that are the same in each language, and names of files and commands."""
LETTERS = re.compile(r"[^\W\d_²]+(?:\.yaml)?")
WORDS = re.compile(r"[A-Za-z]{2,} [a-z]{2,}")
"""Two words of a sentence, where a text is no class or key."""
SAID = {"word", "said", "spoken"}


class Shown(Texts):
    """Texts of a template between its tags, without what is set as a symbol."""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        super().handle_starttag(tag, attrs)
        self._hidden += tag in ("i", "sub", "sup", "code")

    def handle_endtag(self, tag: str) -> None:
        super().handle_endtag(tag)
        self._hidden -= tag in ("i", "sub", "sup", "code")


def printed_texts(node: nodes.Node) -> Iterator[str]:
    """Constants that an expression of a template can print as they are."""
    match node:
        case nodes.Const(value=str() as text):
            yield text
        case nodes.CondExpr():
            yield from (text for one in (node.expr1, node.expr2) if one is not None for text in printed_texts(one))
        case nodes.Or() | nodes.And():
            yield from (text for one in (node.left, node.right) for text in printed_texts(one))
        case nodes.Concat():
            yield from (text for one in node.nodes for text in printed_texts(one))
        case nodes.Filter() if node.name not in SAID and node.node is not None:
            yield from printed_texts(node.node)


def untranslated(name: str) -> set[str]:
    """Words that a template prints past the catalogue."""
    environment = Environment(extensions=["jinja2.ext.i18n"])
    tree = environment.parse((ROOT / "templates" / name).read_text(encoding="utf-8"))
    texts = [text for one in tree.find_all(nodes.Output) for part in one.nodes for text in printed_texts(part)
              if " " in text.strip() or text[:1].isupper()]  # fmt: skip
    given = [one.node for one in tree.find_all(nodes.Assign)]
    given += [argument for call in tree.find_all(nodes.Call) for argument in call.args if called(call) not in GIVEN]
    texts += [text for one in given for text in printed_texts(one) if WORDS.search(text)]
    page = Shown()
    page.feed("".join(one.data for one in tree.find_all(nodes.TemplateData)))
    page.feed("".join(f"<p>{text}</p>" for text in texts))
    page.close()
    return {word for text in page.found for word in LETTERS.findall(text)} - SYMBOLS


GIVEN = {"_", "gettext", "ngettext", "plain", "removeprefix"}
"""What takes a message, or an English text that it looks for."""


def called(call: nodes.Call) -> str:
    return getattr(call.node, "name", "") or getattr(call.node, "attr", "")


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_template_of_the_report_prints_no_word_past_the_catalogue(name: str):
    assert untranslated(name) == set()


# ---- the same numbers -----------------------------------------------------------------------------------------------
def numbers(findings: Findings) -> Counter[tuple[float, float]]:
    pages = printed.numbers(make(findings)["report.pdf"])
    return Counter((one.value, one.half) for page in pages for one in page)


@pytest.mark.long
def test_every_number_is_the_same_in_all_languages_and_with_a_decimal_comma(marked: Findings):
    english = numbers(spoken(marked, "en", sign="point"))
    assert sum(english.values()) > 60
    for code in CODES:
        assert numbers(spoken(marked, code)) == english, code


FIGURE = re.compile(r"(?<![\w.])\d+(?:\N{NO-BREAK SPACE}\d{3})*(?:\.\d+)?(?:×10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")


def figures(findings: Findings) -> Counter[str]:
    """Every number of a page, with a point: no page of a PDF, whose numbers and broken lines depend on the language."""
    page = Texts()
    page.feed(make(findings)["report.html"].decode("utf-8"))
    sign = r"(?<=\d),(?=\d)" if findings.campaign.decimal_sign == "comma" else r"(?!)"
    texts = (re.sub(sign, ".", OWN.sub("", text)) for text in page.found)
    return Counter(one[0].replace("\N{NO-BREAK SPACE}", "") for text in texts for one in FIGURE.finditer(text))


@pytest.mark.long
def test_every_number_of_a_whole_report_is_the_same_in_all_languages(marked: Findings):
    english = figures(spoken(marked, "en", sign="point", parts=WHOLE))
    assert sum(english.values()) > 500
    for code in CODES:
        found = figures(spoken(marked, code, parts=WHOLE))
        assert (english - found, found - english) == (Counter(), Counter()), code


@pytest.mark.long
def test_a_certificate_with_decimal_commas_is_read_back_and_a_changed_digit_is_seen(marked: Findings):
    content = make(spoken(marked, "de"))["report.pdf"]
    assert "," in "".join(page.extract_text() for page in PdfReader(BytesIO(content)).pages[:1])
    results = [{"name": one.name, "value": one.value, "u": one.u, "display_unit": one.display_unit, "headline": True}
               for one in marked.results if one.headline]  # fmt: skip
    assert printed.absent(results, printed.numbers(content)) == []
    results[0]["value"] *= 1.02
    assert printed.absent(results, printed.numbers(content)) == [results[0]["name"]]


@pytest.mark.long
def test_two_languages_stand_one_beneath_the_other(marked: Findings):
    page = make(spoken(marked, "de", "en"))["report.html"].decode("utf-8")
    assert '<html lang="de">' in page
    assert 'Prüfbericht<span class="second" lang="en">Test report</span>' in page


# ---- the catalogues -------------------------------------------------------------------------------------------------
PLACE = re.compile(r"\{\w+(?::[^}]*)?\}|%\(\w+\)s|</?\w+>")


@pytest.mark.parametrize("code", CODES)
def test_a_translation_has_the_values_and_the_markup_of_its_message(code: str):
    with (catalogue.LOCALE / code / "LC_MESSAGES" / "metrology.po").open("rb") as file:
        known = read_po(file, locale=code)
    for one in known:
        messages = one.id if isinstance(one.id, tuple) else (one.id,)
        strings = one.string if isinstance(one.string, tuple) else (one.string,)
        allowed = [Counter(PLACE.findall(message)) for message in messages]
        assert all(Counter(PLACE.findall(string)) in allowed for string in strings), one.id


def catalogues() -> dict[str, Catalog]:
    found = {}
    for code in CODES:
        with (catalogue.LOCALE / code / "LC_MESSAGES" / "metrology.po").open("rb") as file:
            found[code] = read_po(file, locale=code)
    return found


@pytest.mark.long
def test_the_catalogues_have_every_message_and_no_other():
    known, messages = catalogues(), runpy.run_path(str(ROOT / "scripts" / "catalogue.py"))["found"]()
    for message, context in messages:
        key = message[0] if isinstance(message, tuple) else message
        for code in CODES:
            entry = known[code].get(key, context or None)
            assert entry is not None, (code, key)
            strings = entry.string if isinstance(entry.string, tuple) else (entry.string,)
            assert all(strings), (code, key)
    assert {len(one) for one in known.values()} == {len(messages)}


def test_the_terms_that_the_documentation_states_are_those_of_the_catalogues():
    """By the beginning of each word, for these languages bend its end."""
    text = (ROOT / "docs" / "languages.md").read_text(encoding="utf-8")
    rows = [row.strip("|").split("|") for row in text.splitlines() if row.startswith("| ")][1:]
    said = {code: " ".join(str(one.string).lower() for one in known) for code, known in catalogues().items()}
    assert len(rows) >= 15
    for row in rows:
        for code, term in zip(CODES, row[1:], strict=True):
            for word in re.split(r"[ -]", term.strip().lower()):
                assert word[: max(4, len(word) - 2)] in said[code], (code, word)


def test_a_language_that_there_is_not_is_refused_with_those_that_there_are(tmp_path: Path, capsys):
    place = folder_of(tmp_path)
    text = CAMPAIGN.replace("  number: Zz-1", "  number: Zz-1\n  language: [de, nl]")
    (place / "campaign.yaml").write_text(text, encoding="utf-8")
    assert main(["check", str(place / "campaign.yaml")]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "campaign.yaml:6" in said
    assert all(code in said for code in ("nl", "'en'", "'de'", "'es'")), said


def test_law_values_are_stored_with_the_digits_that_their_sentence_prints():
    """Further digits differ between processors, and a report is verified to 1e-9."""
    values = {"part": 12.34567, "name": "k", "share": 0.6649, "n": 3, "lost": 0.1}
    one = said("{part:.2g} % of {name}, {share:.0%}, {n} readings", **values)
    assert catalogue._as_printed(one) == {"part": 12.0, "name": "k", "share": 0.66, "n": 3}
    again = said(one.message, **catalogue._as_printed(one))
    assert again == one == "12 % of k, 66%, 3 readings"
    assert catalogue._as_printed(counted("a run", "{count} runs", 1)) == {"count": 1}
