"""Digital calibration certificates in: what they say is used as if the campaign file said it."""

# ruff: noqa: E501 - messages and XML stand in one piece

from __future__ import annotations

from datetime import date
from pathlib import Path

import pytest
from certificates import HEAD, LISTED, REAL, TAIL, WHOLE, listed

from metrology import chain
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources
from metrology.errors import MetrologyError
from metrology.units.vocabularies import dsi, from_dsi

STATED = """\
    certificate:
      number: C-123
      laboratory: Calibration House
      date: 2026-03-01
      due: 2027-03-01
      expanded_uncertainty: 4 um
      k: 2
"""


@pytest.fixture
def campaign(folder: Path):
    """Load the good campaign, undiagnosed, with a certificate of the indicator as a file."""
    whole = (folder / "campaign.yaml").read_text(encoding="utf-8")
    (folder / "campaign.yaml").write_text(
        whole + "diagnosis: {off: true}\nmonte_carlo: {digits: 1, max_trials: 10000}\n", encoding="utf-8"
    )

    def made(xml: str, entry: str = "{dcc: k.xml, due: 2027-03-01}"):
        (folder / "k.xml").write_text(xml, encoding="utf-8")
        path = folder / "campaign.yaml"
        text = path.read_text(encoding="utf-8")
        assert STATED in text
        path.write_text(text.replace(STATED, f"    certificate: {entry}\n"), encoding="utf-8")
        return load("campaign.yaml")

    return made


@pytest.mark.long
@pytest.mark.parametrize("version", LISTED)
def test_twice_a_certificate_as_a_file_is_the_certificate_as_stated(version: str, campaign, folder: Path) -> None:
    """Dates, U, k: the results are those of the campaign that states them; the greatest U of the points counts."""
    stated = {one.name: one.u for one in chain.evaluate(load("campaign.yaml")).results}
    found = campaign(listed(version))
    certificate = found.instruments["indicator"].certificate
    assert (certificate.number, certificate.laboratory, certificate.date) == (
        "K-4711",
        "Calibration House",
        date(2026, 3, 1),
    )
    assert (certificate.u, certificate.conditions) == (2e-6, "temperature 20.0 °C")
    assert [end.si for end in certificate.valid] == [0.0, 0.025]
    assert {one.name: one.u for one in chain.evaluate(found).results} == stated
    assert found.files[-1].path == "k.xml"
    assert read_sources(found)["k.xml"] == (folder / "k.xml").read_bytes()


def test_limit_one_quantity_of_several_is_stated(campaign) -> None:
    both = HEAD.format(version="3.2.1") + REAL.format(name="zero") + REAL.format(name="span") + TAIL
    found = campaign(both, "{dcc: k.xml, quantity: span, k: 2}")
    assert found.instruments["indicator"].certificate.expanded_uncertainty.value == "4.0 µm"


CORRECTION = "    correction: {fit: indicator-line}\n"
OFF = {
    "errors as listed": (listed("3.3.0").replace("0.001 -.002 0.000", "0.001 -.005 0.004"), "-0.005 mm at 25 mm", "0.004 mm"),
    "one error": (WHOLE.replace("span", "error of indication"), "5.0 µm", "4.0 µm"),
    "indicated less reference": (
        listed("3.2.1").replace("e1", "r1").replace("basic_measurementError", "basic_referenceValue")
        .replace("error of indication", "length").replace("0.001 -.002 0.000", "-.003 25.0041 1.003"),
        "-0.0041 mm at 25 mm", "0.004 mm",
    ),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("case", OFF)
def test_planted_error_beyond_its_u_is_told_on_page_1_unless_it_is_corrected(case: str, campaign, folder: Path) -> None:
    """JCGM 100:2008, 3.2.4: a result is corrected for all recognized significant systematic effects."""
    xml, error, spread = OFF[case]
    told = f"The certificate of indicator states an error of {error}, beyond its U = {spread}, and nothing corrects it."
    assert not any(told in sentence for sentence in campaign(xml).notices)
    path = folder / "campaign.yaml"
    text = path.read_text(encoding="utf-8")
    assert CORRECTION in text
    path.write_text(text.replace(CORRECTION, ""), encoding="utf-8")
    findings = chain.evaluate(load("campaign.yaml"), coverage=False)
    assert any(sentence.startswith(told) for sentence in findings.warnings)
    assert ("Note", told.replace(" -", " −")) in [(one.kind, one.sentence) for one in findings.notices]


def test_planted_correction_that_the_method_does_not_take_is_noted(folder: Path) -> None:
    """The indicator of the elongation is corrected, the vibrometer of the free decay is not, and 0 is no correction."""
    path = folder / "campaign.yaml"
    text = path.read_text(encoding="utf-8")
    assert "0.0(1) um" in text
    assert not any("correction" in sentence for sentence in load(path).notices)
    path.write_text(text.replace("0.0(1) um", "2.0(1) um"), encoding="utf-8")
    (noted,) = (sentence for sentence in load(path).notices if "correction" in sentence)
    assert noted.startswith("instruments.vibrometer.correction: the readings of test '")


def test_limit_an_error_within_its_u_is_no_notice(campaign, folder: Path) -> None:
    """An error of 4 µm with U = 4 µm: a difference of decimal numbers is not rounded."""
    path = folder / "campaign.yaml"
    path.write_text(path.read_text(encoding="utf-8").replace(CORRECTION, ""), encoding="utf-8")
    found = campaign(listed("3.3.0").replace("0.001 -.002 0.000", "0.003 -.004 0.000"))
    assert not any("certificate" in sentence for sentence in found.notices)


def test_refusal_of_readings_outside_the_range_of_validity(campaign) -> None:
    with pytest.raises(MetrologyError) as caught:
        campaign(listed("3.2.1", high="1.1"))
    assert next(str(fault) for fault in caught.value.faults) == (
        "elongation.csv:7 reading: got '1.21 mm'; expected a reading within the range of validity of certificate K-4711, "
        "0 mm to 1.1 mm. Fix: exclude it with a reason, or correct the range"
    )


REFUSED = {
    "two quantities": (
        HEAD.format(version="3.2.1") + REAL.format(name="zero") + REAL.format(name="span") + TAIL,
        "{dcc: k.xml}",
        "k.xml: got 2 quantities with an expanded uncertainty; expected one of 'zero', 'span'. "
        "Fix: state it: 'certificate: {dcc: …, quantity: …}'",
    ),
    "contradiction": (
        WHOLE, "{dcc: k.xml, number: C-123}",
        "campaign.yaml:30:39 instruments.indicator.certificate.number: got 'C-123'; expected 'K-4711', as the certificate "
        "has it. Fix: leave it out",
    ),
    "no such file": (
        WHOLE, "{dcc: other.xml}",
        "campaign.yaml:30:24 instruments.indicator.certificate.dcc: got 'other.xml'; expected a certificate, .xml, in the "
        "campaign's folder. Fix: there is no such file",
    ),
    "outside": (
        WHOLE, "{dcc: ../k.xml}",
        "campaign.yaml:30:24 instruments.indicator.certificate.dcc: got '../k.xml'; expected a certificate, .xml, in the "
        "campaign's folder. Fix: '..' leaves the campaign's folder",
    ),
    "no certificate": ("<a/>", "{dcc: k.xml}", "k.xml: got <a>; expected a digitalCalibrationCertificate of version 3"),
    "version 2": (
        WHOLE.replace('"3.2.1"', '"2.4.0"'), "{dcc: k.xml}",
        "k.xml: got <digitalCalibrationCertificate> of version 2.4.0; expected a digitalCalibrationCertificate of version 3",
    ),
    "entities": (
        WHOLE.replace("?>", '?><!DOCTYPE a [<!ENTITY b "c">]>', 1), "{dcc: k.xml}",
        "k.xml: got a document type, which a certificate does not have; expected XML without it",
    ),
    "no XML": (
        WHOLE[:-5], "{dcc: k.xml}",
        "k.xml: got no XML (unclosed token: line 19, column 87); expected a digital calibration certificate",
    ),
    "unknown encoding": (
        WHOLE.replace("UTF-8", "UT-F8"), "{dcc: k.xml}",
        "k.xml: got no XML (unknown encoding: UT-F8); expected a digital calibration certificate",
    ),
    "unknown unit": (
        WHOLE.replace("\\metre", "\\cubit"), "{dcc: k.xml}",
        "k.xml: got 0 quantities with an expanded uncertainty; expected a result with an expanded uncertainty, its factor "
        "and a unit of D-SI",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refusal_of_certificates(case: str, campaign) -> None:
    xml, entry, message = REFUSED[case]
    with pytest.raises(MetrologyError) as caught:
        campaign(xml, entry)
    assert [str(fault) for fault in caught.value.faults] == [message]


@pytest.mark.parametrize(("k", "p", "dof"), [("2.65", "0.9545", 5), ("2.13", "0.9545", 20), ("2.00", "0.95", None)])
def test_reference_degrees_of_freedom_follow_from_k(k: str, p: str, dof: float | None, campaign) -> None:
    """JCGM 100:2008, table G.2: t_95.45 of 5 and of 20 degrees of freedom; 2 is what laboratories round to."""
    factor = f"<si:coverageFactor>{k}</si:coverageFactor><si:coverageProbability>{p}</si:coverageProbability>"
    xml = WHOLE.replace("<si:coverageFactor>2.0</si:coverageFactor>", factor)
    found = campaign(xml, "{dcc: k.xml}").instruments["indicator"].certificate
    assert found.dof == (None if dof is None else pytest.approx(dof, rel=0.05))


@pytest.mark.long
def test_twice_our_own_export_is_read_back(campaign, folder: Path) -> None:
    from metrology.export.dcc import certificate

    path = folder / "campaign.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("name: Tether Laboratory", "name: Tether Laboratory\n  country: IT"), encoding="utf-8")
    findings = chain.evaluate(load("campaign.yaml"))
    length = next(one for one in findings.results if one.name == "x_max")
    found = campaign(certificate(findings).decode(), "{dcc: k.xml, quantity: x_max}")
    read = found.instruments["indicator"].certificate
    assert (read.number, read.laboratory) == ("TR-2026-001", "Tether Laboratory")
    assert read.expanded_uncertainty.si == pytest.approx(length.coverage.k * length.u, rel=1e-12)
    assert read.u == pytest.approx(length.u, rel=1e-12)


@pytest.mark.parametrize("unit", ["mm", "N/m", "kg/m^3", "N·s/m", "1", "°C", "µV", "1/s"])
def test_twice_a_unit_of_d_si_reads_back(unit: str) -> None:
    from metrology import units

    assert units.unit(from_dsi(dsi(unit))) == units.unit(unit)


@pytest.mark.parametrize("text", [r"\cubit", r"\milli", r"\metre\per", "metre", r"\metre\tothe{x}"])
def test_refusal_of_words_that_are_no_unit(text: str) -> None:
    assert from_dsi(text) == ""


@pytest.mark.parametrize(("serial", "issuer", "same"), [
    ("OTHER-99", "manufacturer", False), ("0123", "manufacturer", True), ("OTHER-99", "customer", True),
])  # fmt: skip
def test_refusal_of_the_certificate_of_another_instrument(serial: str, issuer: str, same: bool, campaign) -> None:
    items = (
        f"<dcc:items><dcc:item><dcc:identifications><dcc:identification><dcc:issuer>{issuer}</dcc:issuer>"
        f"<dcc:value>{serial}</dcc:value></dcc:identification></dcc:identifications></dcc:item></dcc:items>"
    )
    xml = WHOLE.replace("</dcc:coreData>", f"</dcc:coreData>{items}")
    if same:
        assert campaign(xml).instruments["indicator"].certificate.number == "K-4711"
        return
    with pytest.raises(MetrologyError) as caught:
        campaign(xml)
    assert "instruments.indicator.serial: got '0123'; expected 'OTHER-99', as the certificate has it" in str(
        caught.value
    )
