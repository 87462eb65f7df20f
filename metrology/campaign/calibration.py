"""Digital calibration certificates (PTB's DCC 3.x): what they say of an instrument, as a campaign file says it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from metrology import units
from metrology.campaign.certified import DCC, SI, Stated, quantities, text_at
from metrology.campaign.readings import inside
from metrology.declaration.columns import SourceFile, source_file
from metrology.declaration.document import Document
from metrology.declaration.entry import Refusal
from metrology.errors import Fault, MetrologyError
from metrology.message import said
from metrology.readings.sheet import refused
from metrology.units.dimensions import TextError, quoted
from metrology.units.vocabularies import from_dsi

MAX_BYTES = 8 * 1024 * 1024
SUFFIX = ".xml"
ITEMS = f"{DCC}administrativeData/{DCC}items/{DCC}item"


def read_certificates(document: Document) -> tuple[list[Refusal], list[Fault], tuple[SourceFile, ...], list[str]]:
    """Enter what digital certificates say into the data of a campaign file, where it names one under ``dcc``.

    Returns
    -------
    refusals : list
        What is wrong with the entry in the campaign file.
    faults : list
        What is wrong with the certificates.
    files : tuple
        The certificates that were read.
    notices : list
        Errors of indication beyond their U that nothing corrects (JCGM 100:2008, 3.2.4).
    """
    refusals: list[Refusal] = []
    faults: list[Fault] = []
    files: dict[str, SourceFile] = {}
    notices: list[str] = []
    for name, entry in _entries(document.data):
        place = ("instruments", name, "certificate")
        try:
            path = inside(folder_of(document), str(entry["dcc"]), (SUFFIX,))
            if not path.is_file():
                raise ValueError("there is no such file")
        except ValueError as error:
            got = quoted(str(entry["dcc"]))
            refusals.append(Refusal((*place, "dcc"), got, "a certificate, .xml, in the campaign's folder", str(error)))
            _stand_in(entry)
            continue
        try:
            raw = _content(path)
            root = _root(path, raw)
            found, off = _said(path, root, str(entry.get("quantity", "")))
        except MetrologyError as error:
            faults += error.faults
            _stand_in(entry)
            continue
        files[str(entry["dcc"])] = source_file(str(entry["dcc"]), raw)
        refusals += _contradictions(place, entry, found)
        refusals += _of_another(name, str(document.data["instruments"][name].get("serial", "")), root)
        entry.update({key: value for key, value in found.items() if key not in entry})
        if off and not document.data["instruments"][name].get("correction"):
            text = (
                "The certificate of {name} states {off}, and nothing corrects it. Declare 'correction' of the "
                "instrument; 0 where the readings are corrected already."
            )
            notices.append(said(text, name=name, off=off))
    return refusals, faults, tuple(files.values()), notices


def _entries(data: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    instruments = data.get("instruments") if isinstance(data, dict) else None
    for name, instrument in (instruments if isinstance(instruments, dict) else {}).items():
        entry = instrument.get("certificate") if isinstance(instrument, dict) else None
        if isinstance(entry, dict) and isinstance(entry.get("dcc"), str):
            yield name, entry


def _stand_in(entry: dict[str, Any]) -> None:
    """Enter what is required of a certificate that could not be read, so that this is told once."""
    entry.setdefault("number", "unread")
    entry.setdefault("date", "1900-01-01")


def folder_of(document: Document) -> Path:
    """Folder in which the files of a campaign lie."""
    extends = document.data.get("extends")
    return (document.path.parent / extends).parent if isinstance(extends, str) else document.path.parent


def _contradictions(place: tuple[str, ...], entry: Mapping[str, Any], found: Mapping[str, Any]) -> Iterator[Refusal]:
    """What is stated in the campaign file and otherwise in the certificate."""
    for key, value in found.items():
        if key not in entry or key == "dof" or isinstance(value, list) or entry[key] == value:
            continue
        try:
            same = units.parse(str(entry[key])).value == units.parse(value).value
        except TextError:
            same = False
        if not same:
            yield Refusal((*place, key), quoted(entry[key]), f"'{value}', as the certificate has it", "leave it out")


def _of_another(name: str, serial: str, root: ET.Element) -> Iterator[Refusal]:
    """The certificate of another instrument: what its manufacturer calls it is not the serial number that is stated."""
    given = root.iterfind(f"{ITEMS}/{DCC}identifications/{DCC}identification")
    known = [text_at(one, f"{DCC}value") for one in given if text_at(one, f"{DCC}issuer") == "manufacturer"]
    if serial and any(known) and serial.casefold() not in map(str.casefold, known):
        expected = f"{' or '.join(map(repr, filter(None, known)))}, as the certificate has it"
        fix = "name the certificate of this instrument, or correct its serial number"
        yield Refusal(("instruments", name, "serial"), quoted(serial), expected, fix)


def _content(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise refused(path, f"a file that cannot be read ({error.strerror})", "a certificate") from None
    if len(raw) > MAX_BYTES:
        raise refused(path, "a file that is too large", f"a certificate of at most {MAX_BYTES >> 20} MiB")
    return raw


def _root(path: Path, raw: bytes) -> ET.Element:
    """A certificate's XML."""
    if b"<!DOCTYPE" in raw or b"<!ENTITY" in raw:
        raise refused(path, "a document type, which a certificate does not have", "XML without it")
    try:
        root = ET.fromstring(raw)  # noqa: S314 - bounded, and without a document type no entity is declared
    except (ET.ParseError, LookupError, ValueError) as error:  # an encoding that is none is one of the latter
        raise refused(path, f"no XML ({error})", "a digital calibration certificate") from None
    version = root.get("schemaVersion", "")
    if root.tag != f"{DCC}digitalCalibrationCertificate" or not version.startswith("3."):
        got = f"<{root.tag.rpartition('}')[2]}>{f' of version {version}' if version else ''}"
        raise refused(path, got, "a digitalCalibrationCertificate of version 3")
    return root


def _said(path: Path, root: ET.Element, wanted: str) -> tuple[dict[str, Any], str]:
    """Keys of a certificate's entry in a campaign file, as texts; and the error that it states beyond its U."""
    core = f"{DCC}administrativeData/{DCC}coreData/{DCC}"
    found: dict[str, Any] = {
        "number": text_at(root, f"{core}uniqueIdentifier"),
        "date": text_at(root, f"{core}endPerformanceDate")[:10] or text_at(root, f"{core}beginPerformanceDate")[:10],
        "laboratory": text_at(
            root, f"{DCC}administrativeData/{DCC}calibrationLaboratory/{DCC}contact/{DCC}name/{DCC}content"
        ),
        "conditions": _conditions(root),
    }
    stated = _chosen(path, list(quantities(root)), wanted)
    largest = max(range(len(stated.uncertainties)), key=lambda index: float(stated.uncertainties[index]))
    found["expanded_uncertainty"] = f"{_plain(stated.uncertainties[largest])} {stated.unit}".removesuffix(" 1")
    found["k"] = _plain(stated.factors[min(largest, len(stated.factors) - 1)])
    found["dof"] = _freedom(float(found["k"]), float(stated.probability)) if stated.probability else ""
    points = sorted(stated.points, key=float)
    if len(points) > 1 and float(points[0]) < float(points[-1]):
        found["valid"] = [f"{_plain(end)} {stated.unit}" for end in (points[0], points[-1])]
    return {key: value for key, value in found.items() if value}, stated.off()


def _freedom(k: float, probability: float) -> str:
    """Effective degrees of freedom by k = t_p(ν) (JCGM 100, G.3), as D-SI has no place for them; none where k is 2."""
    from scipy.optimize import brentq
    from scipy.special import stdtrit

    if not 0.5 < probability < 1 or k < 2.01:
        return ""

    def beyond(dof: float) -> float:
        return float(stdtrit(dof, (1 + probability) / 2)) - k

    return f"{brentq(beyond, 1, 999):.3g}" if beyond(1) > 0 > beyond(999) else ""


def _conditions(root: ET.Element) -> str:
    """Conditions in words, each with its value where it has one."""
    texts = []
    for one in root.iter(f"{DCC}influenceCondition"):
        name = text_at(one, f"{DCC}name/{DCC}content")
        real = next(one.iter(f"{SI}real"), None)
        value = text_at(one, f".//{DCC}text/{DCC}content")
        if real is not None:
            value = f"{text_at(real, f'{SI}value')} {from_dsi(text_at(real, f'{SI}unit'))}"
        texts.append(f"{name} {value}".strip() if not value.startswith(name) else value)
    return "; ".join(dict.fromkeys(filter(None, texts)))


def _chosen(path: Path, found: list[Stated], wanted: str) -> Stated:
    known = [one for one in found if not wanted or wanted in one.names]
    if len(known) == 1:
        return known[0]
    names = ", ".join(f"'{one.names[0]}'" for one in found[:12] if one.names)
    expected = f"one of {names}" if names else "a result with an expanded uncertainty, its factor and a unit of D-SI"
    got = f"no quantity '{wanted}'" if wanted and not known else f"{len(known)} quantities with an expanded uncertainty"
    raise refused(path, got, expected, "state it: 'certificate: {dcc: …, quantity: …}'" if names else "")


def _plain(number: str) -> str:
    """A number as the grammar of quantities has it: a digit before the point, no sign of plus."""
    text = number.removeprefix("+")
    text = f"0{text}" if text.startswith(".") else text.replace("-.", "-0.")
    return text.replace(".e", "e").replace(".E", "e").removesuffix(".")
