"""Digital calibration certificates (PTB's DCC 3.x): what they say of an instrument, as a campaign file says it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import Any

from metrology import units
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
DCC, SI = "{https://ptb.de/dcc}", "{https://ptb.de/si}"
ITEMS = f"{DCC}administrativeData/{DCC}items/{DCC}item"
_READ, _TRUE = ("basic_indicatedValue", "basic_measuredValue"), "basic_referenceValue"
_POINTS = (*_READ, _TRUE, "basic_nominalValue", "basic_arithmeticMean")
"""`refType` of the quantity beside an uncertainty that says at which readings it was found (PTB, DCC good practice)."""
_ERROR = re.compile("error|correction|messabweichung|korrektion", re.IGNORECASE)
"""What the name of a quantity holds whose values are errors of indication, or corrections: `basic_measurementError`."""


@dataclass(frozen=True)
class Stated:
    """A quantity of a certificate: how it is called, its values, expanded uncertainties and factors, and its unit.

    `points`: the readings at which it was found; `errors`: what the instrument was found to be off there.
    """

    names: tuple[str, ...]
    values: tuple[str, ...]
    uncertainties: tuple[str, ...]
    factors: tuple[str, ...]
    unit: str
    points: tuple[str, ...] = ()
    errors: tuple[Decimal, ...] = ()
    probability: str = ""

    def off(self) -> str:
        """The largest error that is beyond its U, in words; empty where none is."""
        spread = [Decimal(one) for one in self.uncertainties] * (1 if len(self.uncertainties) > 1 else len(self.errors))
        beyond = [at for at, error in enumerate(self.errors) if abs(error) > spread[at]]
        if not beyond:
            return ""
        most = max(beyond, key=lambda at: abs(self.errors[at]))
        known = {"error": str(self.errors[most]), "most": str(spread[most]), "unit": self.unit}
        if not self.points:
            return said("an error of {error:figures} {unit}, beyond its U = {most:figures} {unit}", **known)
        text = "an error of {error:figures} {unit} at {point:figures} {unit}, beyond its U = {most:figures} {unit}"
        return said(text, point=self.points[most], **known)


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
    known = [_text(one, f"{DCC}value") for one in given if _text(one, f"{DCC}issuer") == "manufacturer"]
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
        "number": _text(root, f"{core}uniqueIdentifier"),
        "date": _text(root, f"{core}endPerformanceDate")[:10] or _text(root, f"{core}beginPerformanceDate")[:10],
        "laboratory": _text(
            root, f"{DCC}administrativeData/{DCC}calibrationLaboratory/{DCC}contact/{DCC}name/{DCC}content"
        ),
        "conditions": _conditions(root),
    }
    stated = _chosen(path, list(_quantities(root)), wanted)
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


def _text(root: ET.Element, path: str) -> str:
    return " ".join((root.findtext(path) or "").split())


def _conditions(root: ET.Element) -> str:
    """Conditions in words, each with its value where it has one."""
    texts = []
    for one in root.iter(f"{DCC}influenceCondition"):
        name = _text(one, f"{DCC}name/{DCC}content")
        real = next(one.iter(f"{SI}real"), None)
        value = _text(one, f".//{DCC}text/{DCC}content")
        if real is not None:
            value = f"{_text(real, f'{SI}value')} {from_dsi(_text(real, f'{SI}unit'))}"
        texts.append(f"{name} {value}".strip() if not value.startswith(name) else value)
    return "; ".join(dict.fromkeys(filter(None, texts)))


def _quantities(root: ET.Element) -> Iterator[Stated]:
    """Every quantity of the results with an expanded uncertainty; in a list, with the points beside it."""
    for data in root.iterfind(f".//{DCC}measurementResults//{DCC}data"):
        for group in (data, *data.iter(f"{DCC}list")):
            members = group.findall(f"{DCC}quantity")
            for one in members:
                if (stated := _stated(one)) is not None:
                    yield _with_points(stated, one, members)


def _with_points(stated: Stated, one: ET.Element, members: Sequence[ET.Element]) -> Stated:
    """The quantity with the readings at which it was found, and the errors there: its own, or of one beside it."""
    beside: dict[str, tuple[str, ...]] = {}
    errors: tuple[str, ...] = ()
    for other in (one, *members):
        real = _real(other)
        values = _list(real, "value") if real is not None else ()
        if real is None or from_dsi(_unit(real)) != stated.unit or len(values) != len(stated.values):
            continue
        if any(map(_ERROR.search, _names(other))):
            errors = errors or values
        for name in other.get("refType", "").split():
            beside.setdefault(name, values)
    points = next((beside[name] for name in _POINTS if name in beside), ())
    read = next((beside[name] for name in _READ if name in beside), ())
    off = zip(read, beside.get(_TRUE, ()), strict=False)
    found = tuple(map(Decimal, errors)) or tuple(Decimal(one) - Decimal(true) for one, true in off)
    return replace(stated, points=points, errors=found)


def _names(one: ET.Element) -> tuple[str, ...]:
    """How a quantity is called: name, id and types."""
    names = (_text(one, f"{DCC}name/{DCC}content"), one.get("id", ""), *one.get("refType", "").split())
    return tuple(filter(None, names))


def _real(one: ET.Element) -> ET.Element | None:
    return next((real for name in ("real", "realListXMLList") for real in one.iter(f"{SI}{name}")), None)


def _unit(real: ET.Element) -> str:
    return (_text(real, f"{SI}unit") or _text(real, f"{SI}unitXMLList")).partition(" ")[0]


def _list(real: ET.Element, *names: str) -> tuple[str, ...]:
    """Numbers of an element by one of its names, alone or as a list; all of them decimal numbers, else none."""
    for element in real.iter():
        if element.tag.removeprefix(SI).removesuffix("XMLList") in names:
            words = tuple((element.text or "").split())
            try:
                return words if all(abs(float(word)) < 1e75 for word in words) else ()
            except ValueError:
                return ()
    return ()


def _stated(one: ET.Element) -> Stated | None:
    real = _real(one)
    if real is None:
        return None
    values, factors = _list(real, "value"), _list(real, "coverageFactor")
    uncertainties = _list(real, "uncertainty", "valueExpandedMU")
    unit = from_dsi(_unit(real))
    if not (values and uncertainties and factors and unit) or len(uncertainties) not in (1, len(values)):
        return None
    probability = next(iter(_list(real, "coverageProbability")), "")
    return Stated(_names(one), values, uncertainties, factors, unit, probability=probability)


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
