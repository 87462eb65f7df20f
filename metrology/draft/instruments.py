"""Header blocks of testing machines, vibrometers and motion-capture systems: whose they are, and what they say.

Facts of the formats from public documentation: Instron Bluehill (raw data export, units in parentheses below
the headings), ZwickRoell testXpert (ASCII and .TRA export), MTS 793 and TestSuite (``MTS793|MPT|…``), Polytec
VibSoft and PSV (ASCII export, units in square brackets), OptiTrack Motive (CSV 1.2x: pairs of key and value on
line 1), Vicon Nexus (CSV export: ``Trajectories``, the rate on line 2), LabVIEW (.lvm, .tdms), DIAdem (.tdms, CSV).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction

from metrology import units
from metrology.readings.headings import unit_text
from metrology.units.dimensions import TextError


@dataclass(frozen=True)
class Found:
    """What a header block says.

    Parameters
    ----------
    maker : str
        Whose file it is; nothing where nobody's was recognised.
    rate : float
        Samples in a second where it is stated, else 0.
    doubtful : str
        A rate as it stands there, where it is not plain what it is: ``10,000 Hz``.
    unit : str
        Unit of all lengths, where the block has one for all.
    line : int
        Line of the headings, where only the maker's rule finds it; else 0.
    facts : mapping of str to str
        Other keys that a campaign can use: ``date``, ``operator``, ``serial``, ``sample``, sizes of the specimen.
    """

    maker: str = ""
    rate: float = 0.0
    unit: str = ""
    line: int = 0
    facts: dict[str, str] = field(default_factory=dict)
    doubtful: str = ""


_SIGNS = (
    ("OptiTrack Motive", r"^Format Version,.*Take Name"),
    ("Vicon Nexus", r"^(Trajectories|Model Outputs|Devices|Objects)\b"),
    ("MTS", r"^MTS793|\bMTS ?(TestSuite|FlexTest)|^Data (Header|Acquisition):"),
    ("Instron Bluehill", r"Bluehill|\bInstron\b|^\"?(?:Results Table|Specimen properties : )"),
    ("ZwickRoell testXpert", r"testXpert|\bZwick|\bPrüfzeit\b.*\bStandard(?:kraft|weg)\b"),
    ("Polytec", r"\bPolytec\b|\bPSV\b|\bVibSoft\b|^Source File Name"),
    ("LabVIEW", r"^LabVIEW Measurement"),
    ("DIAdem", r"\bDIAdem\b|^DIAHEADER"),
)
_KEYS = {
    "operator": r"operator|prüfer|bediener|tester|opérateur|operateur|operatore|operador",
    "date": r"date|datum|prüfdatum|test date|start date|date/heure|data|fecha",
    "serial": r"serial(?: (?:number|no))?|seriennummer|serial nr|num[ée]ro (?:de|di) s[ée]rie|número de serie",
    "sample": r"specimen(?: (?:label|name|id))?|sample(?: (?:name|id))?|probe|probenname|probenbezeichnung|prüfling"
    r"|éprouvette|échantillon|provino|campione|probeta|muestra",
    "rate": r"sampl(?:e|ing) (?:rate|frequency)|abtastrate|messrate|messfrequenz|capture frame rate|data rate"
    r"|fréquence d'échantillonnage|frequenza di campionamento|frecuencia de muestreo",
}
_PAIR = re.compile(r"\s*\"?(?P<key>[^\";:=\t,|]{2,40}?)\"?\s*[:=;\t,|]+\s*\"?(?P<value>[^\";\t|]+?)\"?\s*[;\t,]*\s*")
_OF = r"(?: (?:de l'|del |della |de la )?(?:éprouvette|échantillon|provino|campione|probeta|muestra))?"
"""Whose a size is, in French, Italian and Spanish."""
_GROUP = re.compile(r"[^\";:=\t,|]+ : (?=\S)")
"""Of which group a key is: ``Specimen properties : Width,10,mm``."""
_SIZES = {
    "diameter": rf"(?:specimen |original )?diameter|(?:proben)?durchmesser|(?:diamètre|di[aá]metro){_OF}|d ?0",
    "width": rf"(?:specimen |original )?width|(?:proben)?breite|(?:largeur|larghezza|anchura|ancho){_OF}|b ?0",
    "thickness": rf"(?:specimen |original )?thickness|(?:proben)?dicke|(?:épaisseur|spessore|espesor){_OF}|a ?0",
    "gauge_length": r"(?:extensometer )?gauge length|original length|(?:anfangs)?messlänge"
    r"|longueur (?:initiale|de base)|lunghezza iniziale|tratto utile|longitud (?:inicial|calibrada)"
    r"|l ?0(?: - .+)?",
    "length": rf"(?:specimen |free )?length|grip(?: to grip)? separation.*|einspannlänge.*|probenlänge"
    rf"|(?:longueur|lunghezza|longitud)(?: libre| libera)?{_OF}",
}
_SIZE = re.compile(
    r"\s*\"?(?P<key>[^\";:=\t,|([]{2,40}?)\s*(?:[\[(](?P<above>[^\])]*)[\])])?\"?\s*[:=;\t,|]+\s*"
    r"\"?(?P<value>\d+(?:[.,]\d+)?)\"?[\s;\t,|]*\"?(?P<unit>[^\d\s\";,|][^\s\";,|]*)?\"?[\s;,|]*"
)
"""Sizes of the specimen: a key, a number, and its unit behind the one or the other."""
_RATES = {word: f"{prefix}Hz" for prefix, words in {
    "": ("hz", "s/s", "sa/s", "sps", "samples/s", "samples/sec", "samples per second", "fps", "pts/s", "werte/s"),
    "k": ("khz", "ks/s", "ksa/s", "ksps"), "M": ("ms/s", "msa/s", "msps")}.items() for word in words}  # fmt: skip
"""Units of a rate as data loggers write them; S/s are samples and no siemens."""
_UNITS = {"meters": "m", "millimeters": "mm", "centimeters": "cm", "inches": "in"}


def recognise(lines: Sequence[str]) -> Found:
    """What the first lines of a text say of the instrument that wrote it.

    Examples
    --------
    >>> recognise(['"Instron Bluehill 3"', 'Operator;A. Smith']).facts
    {'operator': 'A. Smith'}
    """
    text = "\n".join(lines)
    maker = next((name for name, sign in _SIGNS if re.search(sign, text, re.MULTILINE)), "")
    facts = _facts(lines)
    stated = facts.pop("rate", "")
    rate = _rate(stated)
    if maker == "OptiTrack Motive":
        cells = lines[0].split(",")
        pairs = dict(zip(cells[::2], cells[1::2], strict=False))
        rate = _number(pairs.get("Export Frame Rate", pairs.get("Capture Frame Rate", "")))
        unit = _UNITS.get(pairs.get("Length Units", "").casefold(), "")
        return Found(maker, rate, unit, _line(lines, r"^Frame,Time"), facts)
    if maker == "Vicon Nexus":
        return Found(maker, _number(lines[1]) if len(lines) > 1 else 0.0, "", _line(lines, r"^Frame,Sub Frame"), facts)
    return Found(maker, rate, "", 0, facts, "" if rate or not re.search(r"\d", stated) else stated)


def _facts(lines: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for line in (part for whole in lines for part in dict.fromkeys((whole, _GROUP.sub("", whole, count=1)))):
        if match := _PAIR.fullmatch(line):
            for name, words in _KEYS.items():
                if re.fullmatch(words, match["key"].strip().casefold()):
                    found.setdefault(name, match["value"].strip())
        if match := _SIZE.fullmatch(line):
            found |= {name: text for name, text in _size(match) if name not in found}
    if "date" in found:
        found["date"] = _day(found["date"])
    return {name: value for name, value in found.items() if value}


def _size(match: re.Match[str]) -> Iterator[tuple[str, str]]:
    """A size of the specimen with its unit; nothing where the line has no unit of length."""
    unit = unit_text(match["unit"] or match["above"] or "")
    if name := size_of(match["key"]):
        with suppress(TextError):
            if units.dimension(unit) == units.dimension("m"):
                yield name, f"{match['value'].replace(',', '.')} {unit}"


def size_of(key: str) -> str:
    """Which size of a specimen a text names, with or without its symbol; nothing where none.

    Examples
    --------
    >>> size_of("Probenbreite b0"), size_of("Width"), size_of("d0"), size_of("breit")
    ('width', 'width', 'diameter', '')
    """
    text = re.sub(r"(?<=\w) [abdl] ?0?$", "", key.strip().casefold())
    return next((name for name, words in _SIZES.items() if re.fullmatch(words, text)), "")


def _day(text: str) -> str:
    """A day as year-month-day; nothing where the order of its parts is not plain."""
    if match := re.search(r"(\d{4})[-/.](\d\d)[-/.](\d\d)", text):
        return "-".join(match.groups())
    if match := re.search(r"\b(\d\d?)\.(\d\d?)\.(\d{4})\b", text):
        return f"{match[3]}-{int(match[2]):02d}-{int(match[1]):02d}"
    return ""


def _number(text: str) -> float:
    match = re.match(r"\s*(\d+(?:[.,]\d+)?)", text)
    return float(match[1].replace(",", ".")) if match else 0.0


def _rate(text: str) -> float:
    """Samples in a second; 0 where the unit is none of a rate, or where a mark may group the digits: ``10,000``."""
    match = re.fullmatch(r"(\d+(?:[.,]\d+)?)\s*([^\d\s.,]\S*)?", text.strip())
    if not match or re.fullmatch(r"[1-9]\d{0,2}[.,]\d{3}", match[1]):
        return 0.0
    word = _RATES.get((match[2] or "Hz").casefold(), match[2] or "Hz")
    with suppress(TextError):
        unit = units.unit(word)
        if unit.dimension == units.dimension("Hz"):
            return float(Fraction(match[1].replace(",", ".")) * unit.factor)
    return 0.0


def _line(lines: Sequence[str], pattern: str) -> int:
    return next((at for at, line in enumerate(lines, start=1) if re.search(pattern, line)), 0)
