"""The digital calibration certificate: order and content of its elements, its quantities, and what it refuses."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import findings_sample
import pytest

from metrology.cli import main
from metrology.errors import MetrologyError
from metrology.export import dcc, validation
from metrology.findings import to_json
from metrology.identification import Signatory
from metrology.language.attention import attention

SPACES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}
SCHEMAS = Path(__file__).parent / "schemas"


def root(findings):
    return ET.fromstring(dcc.certificate(findings))


def test_law_identification_people_and_dates(findings):
    made = root(findings)
    core = "dcc:administrativeData/dcc:coreData/dcc:"
    assert made.findtext(f"{core}uniqueIdentifier", namespaces=SPACES) == "TR-2026-001"
    assert made.findtext(f"{core}beginPerformanceDate", namespaces=SPACES) == "2026-10-05"
    assert made.findtext(f"{core}issueDate", namespaces=SPACES) == "2026-11-20"
    assert made.findtext(f"{core}countryCodeISO3166_1", namespaces=SPACES) == "IT"
    assert [name.text for name in made.iterfind(".//dcc:item/dcc:name/dcc:content", SPACES)] == [
        sample.name for sample in findings.samples
    ]
    assert "The results relate only to the items tested." in [
        text.text for text in made.iterfind(".//dcc:content", SPACES)
    ]


def test_twice_quantities_are_the_results(findings):
    made = {
        quantity.findtext("dcc:name/dcc:content", namespaces=SPACES): quantity.find("si:real", SPACES)
        for quantity in root(findings).iterfind(".//dcc:quantity", SPACES)
    }
    reals = [made[f"{result.quantity} ({result.name})"] for result in findings.results]
    agreed = [entry for entry in findings.consensus if entry.consistent]
    assert len(made) == len(findings.results) + len(agreed)
    for entry in agreed:
        real = made[f"{entry.quantity} ({entry.sample}, consensus)"]
        names = ("value", "stdUncertainty", "intervalMin", "intervalMax", "coverageProbability")
        found = [float(real.findtext(f".//si:{name}", namespaces=SPACES)) for name in names]
        assert found == [entry.value, entry.u, entry.low, entry.high, entry.p]
    assert [float(real.findtext("si:value", namespaces=SPACES)) for real in reals] == [
        r.value for r in findings.results
    ]
    for real, result in zip(reals, findings.results, strict=True):
        expanded = real.find("si:expandedUnc", SPACES)
        interval = real.find("si:coverageInterval", SPACES)
        assert (expanded is not None) == result.monte_carlo.law_valid
        if expanded is not None:
            k = float(expanded.findtext("si:coverageFactor", namespaces=SPACES))
            assert float(expanded.findtext("si:uncertainty", namespaces=SPACES)) == pytest.approx(k * result.u)
        else:
            ends = [float(interval.findtext(f"si:interval{end}", namespaces=SPACES)) for end in ("Min", "Max")]
            assert tuple(ends) == result.interval
            assert float(interval.findtext("si:stdUncertainty", namespaces=SPACES)) == result.u
    assert reals[0].findtext("si:unit", namespaces=SPACES) == r"\newton\per\metre"


def test_law_every_verdict_is_stated_with_its_rule(findings):
    stated = [entry.text for entry in root(findings).iterfind(".//dcc:metaData/dcc:conformity", SPACES)]
    assert stated == ["pass", "conditionalPass"]


def test_law_a_certificate_tells_what_page_one_tells(findings):
    told = {text.text for text in root(findings).iterfind(".//dcc:statement/dcc:declaration/dcc:content", SPACES)}
    assert {f"{kind}: {sentence}" for kind, sentence in attention(findings)} <= told
    assert {"Instrument", "Excluded"} <= {text.partition(":")[0] for text in told}


def test_law_nobody_is_moved_to_the_country_of_the_laboratory(findings):
    assert findings.campaign.customer.country == ""
    codes = root(findings).findall("dcc:administrativeData/dcc:customer/dcc:location/dcc:countryCode", SPACES)
    assert codes == []


@pytest.mark.long
def test_law_a_certificate_obeys_our_short_schema(findings):
    schemas = validation.find(SCHEMAS)
    assert schemas.version == "3.3.0"
    assert validation.faults(dcc.certificate(findings), schemas, "dcc") == ()
    bare = replace(findings, tests=(), samples=(), conformity=())
    own = tuple(replace(result, test="") for result in bare.results)
    assert validation.faults(dcc.certificate(replace(bare, results=own)), schemas, "dcc") == ()


def test_law_schemas_are_found_in_folders_of_their_own(findings, tmp_path):
    for name, place in (("short_dcc.xsd", "dcc.xsd"), ("short_si.xsd", "si/v2.2.1/SI_Format.xsd")):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / place).write_bytes((SCHEMAS / name).read_bytes())
    schemas = validation.find(tmp_path)
    assert schemas.version == "3.3.0"
    assert validation.faults(dcc.certificate(findings), schemas, "dcc") == ()


def test_planted_a_departure_from_the_schema_is_told_with_its_place(findings):
    wrong = dcc.certificate(findings).replace(b"<dcc:uniqueIdentifier>TR-2026-001</dcc:uniqueIdentifier>", b"")
    (fault, *_) = validation.faults(wrong, validation.find(SCHEMAS), "dcc")
    assert "coreData" in fault.where
    assert "uniqueIdentifier" in fault.got


def test_refusal_everything_that_is_missing_at_once(findings):
    campaign = replace(
        findings.campaign, report_number="", laboratory=replace(findings.campaign.laboratory, country="")
    )
    with pytest.raises(MetrologyError) as caught:
        dcc.certificate(replace(findings, campaign=campaign))
    assert [fault.where for fault in caught.value.faults] == ["tapes report.number", "tapes laboratory.country"]


def test_refusal_hostile_text_is_text(findings):
    hostile = findings_sample.hostile(replace(findings, conformity=()), findings_sample.HOSTILE)
    kept = replace(hostile.campaign.laboratory, country="IT")
    hostile = replace(hostile, campaign=replace(hostile.campaign, laboratory=kept, issued="2026-11-20"))
    made = ET.fromstring(dcc.certificate(hostile))
    assert {element.tag.partition("}")[0] for element in made.iter()} == {"{https://ptb.de/dcc", "{https://ptb.de/si"}
    name = made.findtext(".//dcc:item/dcc:name/dcc:content", namespaces=SPACES)
    assert "<script>alert(1)</script>" in name
    assert not re.search("[\x00-\x08\u202a-\u202e]", name)


def test_limit_what_has_no_number_is_text(findings):
    nowhere = replace(findings.results[0], value=float("nan"), u=float("inf"))
    endless = replace(findings.results[1], u=float("inf"))
    made = root(replace(findings, results=(nowhere, endless)))
    first, second, *_ = made.iterfind(".//dcc:quantity", SPACES)
    assert first.find("dcc:noQuantity", SPACES) is not None
    assert second.find("si:real/si:value", SPACES) is not None
    assert len(second.find("si:real", SPACES)) == 2


def test_law_the_command_writes_what_the_function_gives(findings, tmp_path, capsysbinary):
    (tmp_path / "results.json").write_bytes(to_json(findings))
    assert main(["export", "dcc", str(tmp_path / "results.json"), "--schema", str(SCHEMAS)]) == 0
    assert capsysbinary.readouterr().out == dcc.certificate(findings)
    assert main(["export", "dcc", str(tmp_path / "results.json"), "--output", str(tmp_path / "dcc.xml")]) == 0
    assert (tmp_path / "dcc.xml").read_bytes() == dcc.certificate(findings)


@pytest.mark.parametrize(
    ("signing", "main_signer"),
    [
        ((), "J. Doe"),
        ((Signatory("author", "T. Tester", "test engineer"),), "J. Doe"),
        ((Signatory("author", "T. Tester", "test engineer"), Signatory("approver", "A. Head", "head")), "A. Head"),
        ((Signatory("author", "T. Tester", "test engineer"), Signatory("approver", "J. Doe", "head")), "J. Doe"),
    ],
)
def test_law_the_main_signer_is_who_releases_it(findings, signing, main_signer):
    made = root(replace(findings, campaign=replace(findings.campaign, signatures=signing)))
    people = made.findall("dcc:administrativeData/dcc:respPersons/dcc:respPerson", SPACES)
    name = "dcc:person/dcc:name/dcc:content"
    said = {p.findtext(name, "", SPACES): p.findtext("dcc:mainSigner", "", SPACES) for p in people}
    assert [person for person, flag in said.items() if flag == "true"] == [main_signer]
    assert said.keys() == {"J. Doe", *(person.name for person in signing)}


def test_law_the_folder_of_the_output_is_made_and_a_file_in_its_place_is_told(findings, tmp_path, capsys):
    (tmp_path / "results.json").write_bytes(to_json(findings))
    order = ["export", "dcc", str(tmp_path / "results.json"), "--output"]
    assert main([*order, str(tmp_path / "new" / "deep" / "dcc.xml")]) == 0
    assert (tmp_path / "new" / "deep" / "dcc.xml").read_bytes() == dcc.certificate(findings)
    (tmp_path / "file").touch()
    assert main([*order, str(tmp_path / "file" / "dcc.xml")]) == 2
    assert "file: got a file where a folder should be (" in capsys.readouterr().err


def test_refusal_a_folder_in_place_of_results(tmp_path, capsys):
    (tmp_path / "results.json").mkdir()
    assert main(["export", "dcc", str(tmp_path / "results.json")]) == 2
    assert "results.json: got no plain file; expected a results.json of this program" in capsys.readouterr().err


def test_refusal_a_folder_without_schemas_and_a_file_that_is_none(findings, tmp_path, capsys):
    (tmp_path / "results.json").write_bytes(to_json(findings))
    assert main(["export", "dcc", str(tmp_path / "results.json"), "--schema", str(tmp_path)]) == 2
    assert "no such schema" in capsys.readouterr().err
    (tmp_path / "other.json").write_text("{}")
    assert main(["export", "dcc", str(tmp_path / "other.json")]) == 2
    assert "a results.json of this program" in capsys.readouterr().err
