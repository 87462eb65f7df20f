"""Units in the words of other programs: each says the same as our own."""

from __future__ import annotations

import re
from fractions import Fraction

import pytest

from metrology import units
from metrology.units import vocabularies
from metrology.units.symbols import symbols

WORDS = {word: symbol for symbol, word in vocabularies._WORDS.items()}
PREFIXES = {word: prefix for prefix, word in vocabularies._PREFIXES.items()}
WRITTEN = ("N/m", "N·s/m", "kg/m^3", "kN/mm", "W/(m·K)", "1/s", "m/s^2", "Pa·s", "1", "µm", "°C", "m^(1/2)", "daN·m")


def read(text: str) -> str:
    """A D-SI string in our own spelling: what follows the one ``\\per`` is below the line."""
    powers: dict[str, Fraction] = {}
    last = ""
    assert text.count(r"\per") - text.count(r"\percent") <= 1
    above, _, below = text.replace(r"\percent", r"\PERCENT").partition(r"\per")
    for part, sign in ((above, 1), (below, -1)):
        prefix = ""
        for word, exponent in re.findall(r"\\([A-Za-z]+)(?:\{([^}]*)\})?", part):
            if word == "tothe":
                powers[last] *= Fraction(exponent).limit_denominator(9)
            elif word in PREFIXES:
                prefix = PREFIXES[word]
            elif word != "one":
                last, prefix = prefix + WORDS[word.lower()], ""
                powers[last] = Fraction(sign)
    return "·".join(f"{symbol}^({power})" for symbol, power in powers.items()) or "1"


@pytest.mark.parametrize("text", WRITTEN)
def test_twice_a_d_si_string_reads_back_as_the_unit(text):
    ours, theirs = units.unit(text), units.unit(read(vocabularies.dsi(text)))
    assert (ours.factor, ours.dimension) == (theirs.factor, theirs.dimension)


def test_law_every_symbol_of_the_si_brochure_has_a_d_si_word():
    others = "in ft thou lb lbf kip kgf gf dyn gn psi ksi mmHg atm °F rpm den ‰ ppb"
    without = {symbol for symbol, _ in symbols().values() if not vocabularies.dsi(symbol) and "tex" not in symbol}
    assert without == set(others.split())
    assert vocabularies.dsi("‰·m") == ""


def test_law_qudt_names_coherent_si_units_and_each_once():
    table = vocabularies._QUDT
    assert all(units.si_unit(text) == text for text in table)
    assert len(set(table.values())) == len(table)
    assert vocabularies.qudt("kN/mm") == ""


@pytest.mark.parametrize(
    ("text", "name"),
    [("N/m", "N-PER-M"), ("N·s/m", "N-SEC-PER-M"), ("rad/s", "RAD-PER-SEC"), ("1", "UNITLESS"), ("Pa", "PA")],
)
def test_reference_units_of_the_contract_have_both(text, name):
    assert vocabularies.qudt(text) == f"http://qudt.org/vocab/unit/{name}"
    assert vocabularies.dsi(text).startswith("\\")
