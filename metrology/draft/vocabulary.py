"""Headings that laboratories write, in several languages, and what such columns hold."""

from __future__ import annotations

import re
import unicodedata

from metrology import units
from metrology.units.dimensions import TextError

ROLES: dict[str, tuple[str, ...]] = {
    "time": ("time", "t", "zeit", "prüfzeit", "messzeit", "testzeit", "timestamp", "elapsed time", "running time",
             "total time", "temps", "tempo", "tiempo", "x_value", "time (seconds)"),
    "repeat": ("repeat", "repetition", "cycle", "wiederholung", "wdh", "wiederh", "rep", "durchgang", "zyklus",
               "messreihe", "reihe", "répétition", "cycle no", "ripetizione", "ciclo", "repetición"),
    "direction": ("direction", "richtung", "belastungsrichtung", "sens", "direzione", "dirección", "sentido"),
    "mass": ("mass", "masse", "gewicht", "weight", "massa", "peso", "masa", "poids", "masses", "massen", "gewichte",
             "weights", "pesi", "pesos", "masas"),
    "load": ("load", "load step", "last", "laststufe", "belastungsstufe", "stufe", "charge", "carico", "carga"),
    "reading": ("reading", "ablesung", "anzeige", "messwert", "messuhr", "lecture", "lettura", "lectura", "indication"),
    "force": ("force", "kraft", "standardkraft", "prüfkraft", "axial force", "load cell", "forza", "fuerza", "zugkraft",
              "kraftaufnehmer", "tension", "effort", "zugversuchskraft"),
    "thrust": ("thrust", "schub", "schubkraft", "poussée", "spinta", "empuje", "drive"),
    "velocity": ("velocity", "speed", "geschwindigkeit", "schnelle", "vitesse", "velocità", "velocidad", "gyroscope",
                 "gyro", "winkelgeschwindigkeit", "drehrate"),
    "acceleration": ("acceleration", "accelerometer", "beschleunigung", "accélération", "accelerazione", "aceleración"),
    "angle": ("angle", "winkel", "drehwinkel", "verdrehung", "angolo", "ángulo", "theta", "phi", "θ", "φ"),
    "strain": ("strain", "dehnung", "nominelle dehnung", "déformation", "deformazione", "deformación", "axial strain",
               "tensile strain", "exx", "eyy", "epsilon", "ε"),
    "stress": ("stress", "tensile stress", "engineering stress", "nominal stress", "zugspannung", "contrainte"),
    "displacement": ("displacement", "extension", "elongation", "deformation", "position", "crosshead", "stroke", "weg",
                     "deflection", "pos",
                     "standardweg", "traversenweg", "traverse", "verschiebung", "auslenkung", "verlängerung", "laser",
                     "x", "verformung", "feindehnung", "extensometer", "längenänderung", "lvdt",
                     "déplacement", "allongement", "course", "corsa", "carrera", "spostamento",
                     "allungamento", "alargamiento", "elongación", "élongation", "posizione", "posición",
                     "desplazamiento", "axial displacement"),
}  # fmt: skip
"""What a column holds → its headings, in lower case; the first that fits is taken."""
DIMENSIONS = {"time": "s", "mass": "kg", "reading": "m", "force": "N", "displacement": "m", "velocity": "m/s",
              "acceleration": "m/s^2"}  # fmt: skip
"""Unit of the dimension that a column of a role has where it has a unit."""
_COMPOUNDED = ("kraft", "weg", "zeit", "dehnung", "winkel", "verschiebung", "geschwindigkeit", "beschleunigung")
_ON_SPECIMEN = ("extensometer", "dehnung", "aufnehmer", "längenänderung", "verformung", "clip", "video", "lvdt")
_ON_MACHINE = ("crosshead", "travers", "machine", "actuator", "stroke", "kolben", "vérin", "travesaño", "pistone")
LOADING = (
    "loading",
    "load",
    "up",
    "belastung",
    "belasten",
    "aufwärts",
    "auf",
    "charge",
    "carico",
    "carga",
    "subida",
    "+",
)
UNLOADING = (
    "unloading", "unload", "down", "entlastung", "entlasten", "abwärts", "ab", "décharge", "scarico", "descarga",
    "bajada",
    "-",
)  # fmt: skip


def _within(words: tuple[str, ...]) -> re.Pattern[str]:
    """Any of some words, by itself or as the end of a German compound: `Axialkraft`."""
    free = r"(?<!\w)"
    found = (f"{'' if word in _COMPOUNDED else free}{re.escape(word)}" for word in words if len(word) > 2)
    return re.compile(rf"(?:{'|'.join(found)})(?!\w)")


WITHIN = {held: _within(words) for held, words in ROLES.items()}
"""What a column holds → any of its headings within a longer one."""


def plain(text: str) -> str:
    """A text in lower case with single spaces, without marks at its end."""
    return re.sub(r"[\s_]+", " ", unicodedata.normalize("NFKC", text).casefold()).strip(" .:")


def role(name: str, unit: str) -> str:
    """What a column holds by its heading and unit; nothing where neither says it.

    Examples
    --------
    >>> role("Standardkraft", "N"), role("Last", "kg"), role("Last", ""), role("Kanal 3", "mm"), role("Bemerkung", "")
    ('force', 'mass', 'load', 'displacement', '')
    """
    wanted = plain(name)
    dimension = dimension_of(unit)
    of_role = {one: units.dimension(due) for one, due in DIMENSIONS.items()}
    by_unit = next((one for one, due in of_role.items() if due == dimension), "")
    found = next((one for one, words in ROLES.items() if wanted in words), "")
    if not found:
        found = next((one for one, word in WITHIN.items() if word.search(wanted)), "")
    if found in ("load", "mass") and by_unit in ("force", "mass"):
        return by_unit
    if found == "strain" and by_unit == "reading":
        return "displacement"
    if found == "displacement" and dimension == units.dimension("1"):
        return "strain"
    # A load in cm is the reading at it: `Load increasing (cm)`.
    if (found == "load" or found in DIMENSIONS) and by_unit and of_role.get(found) != dimension:
        found = by_unit
    return found or {"reading": "displacement"}.get(by_unit, by_unit)


def by_suffix(name: str) -> tuple[str, str]:
    """Name and unit of a heading such as ``Force_N``, whose unit is one of what its name says; else without a unit.

    A name that says nothing has the unit all the same where nothing else is written like it, as ``gauge_mm``.

    Examples
    --------
    >>> by_suffix("Force_N"), by_suffix("theta_rad"), by_suffix("Time_S"), by_suffix("channel_3")
    (('Force', 'N'), ('theta', 'rad'), ('Time', ''), ('channel_3', ''))
    >>> by_suffix("spring_deflection_cm"), by_suffix("gauge_mm"), by_suffix("gauge_m")
    (('spring_deflection', 'cm'), ('gauge', 'mm'), ('gauge_m', ''))
    """
    stem, _, unit = name.rpartition("_")
    held = role(stem, "")
    if not held and stem and unit in PLAIN_UNITS:
        return stem, unit
    if not held or not unit.isalpha():
        return name, ""
    due = {"angle": "rad", "strain": "1"}.get(held, DIMENSIONS.get(held, ""))
    return stem, unit if due and dimension_of(unit) == units.dimension(due) else ""


PLAIN_UNITS = ("mm", "cm", "um", "µm", "nm", "N", "kN", "mN", "kg", "mg", "s", "ms", "us")
"""Units that are read behind an underscore whatever the name before it says."""


def reads_specimen(name: str) -> bool:
    """Whether a displacement by this heading is that of an extensometer on the specimen, not of the crosshead."""
    return any(word in plain(name) for word in _ON_SPECIMEN)


def reads_machine(name: str) -> bool:
    """Whether a displacement by this heading is that of the crosshead, or of a piston."""
    return any(word in plain(name) for word in _ON_MACHINE)


def dimension_of(unit: str) -> units.Dimension | None:
    """Dimension of a unit; none where there is no unit, or none that is known."""
    try:
        return units.dimension(unit) if unit not in ("", "-", "1") else None
    except TextError:
        return None


def direction(word: str) -> str:
    """``loading`` or ``unloading`` for a word of a column of directions; nothing for another."""
    text = plain(word)
    return "loading" if text in LOADING else "unloading" if text in UNLOADING else ""
