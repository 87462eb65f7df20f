"""The line of a simulation out of findings: k, c and length of a sample, with u, and what must be known of them."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, count
from math import isfinite, pi

from uncertainties import UFloat, ufloat

from metrology import __version__
from metrology.errors import Fault, MetrologyError
from metrology.findings import Findings, Result, SampleItem
from metrology.gum.rounding import significant
from metrology.language.catalogue import english
from metrology.language.notices import brief
from metrology.sample import section
from metrology.units import parse

_SI = {"k": "N/m", "c": "N·s/m"}


@dataclass(frozen=True)
class Line:
    """A sample as a line of a simulation, in SI.

    Parameters
    ----------
    name : str
        The sample, by its name in the campaign file.
    k, c : Result
        Stiffness / (N/m) and damping coefficient / (N·s/m), of the whole length.
    length : UFloat
        Between the clamps, unloaded / m.
    correlation : float
        Correlation coefficient of k and c.
    sample : SampleItem
        Where `mass_per_length` and `diameter` are read.
    """

    name: str
    k: Result
    c: Result
    length: UFloat
    correlation: float
    sample: SampleItem

    @property
    def axial_stiffness(self) -> UFloat:
        """EA = k·L / N, of a line that stretches alike over its length."""
        return _number(self.k.value, self.k.u) * self.length

    @property
    def axial_damping(self) -> UFloat:
        """BA = c·L / (N·s), of a line whose damping is alike over its length."""
        return _number(self.c.value, self.c.u) * self.length

    @property
    def mass_per_length(self) -> UFloat:
        """Mass per length / (kg/m)."""
        return _stated(self.sample.linear_density, "kg/m", f"linear_density of sample '{self.name}'")

    @property
    def diameter(self) -> UFloat:
        """Diameter of the circle with the area of the section / m: d = √(4·A/π)."""
        shape, *stated = self.sample.section.split(", ")
        where = f"section of sample '{self.name}'"
        if not shape:
            raise MetrologyError(_missing(where, "{shape: round, diameter: 0.500(2) mm}"))
        kind = section(shape)
        sizes = dict(one.split(" ", 1) for one in stated)
        unit = "m²" if shape == "area" else "m"
        area: UFloat = kind.area(*(_stated(sizes[name], unit, where) for name in kind.dimensions))
        return (4 / pi * area) ** 0.5


def lines(findings: Findings, use: Sequence[str] = ()) -> tuple[Line, ...]:
    """Every sample of which stiffness and damping are known.

    Parameters
    ----------
    findings : Findings
    use : sequence of str
        Full names of results, for a quantity that several tests give.

    Raises
    ------
    MetrologyError
        Where nothing is a line; and for every sample with k that lacks c or a length, or of which several results
        give one of them and `use` names none.
    """
    unknown = [name for name in use if name not in {one.name for one in findings.results}]
    faults = [Fault("--use", f"'{name}'", _one_of(findings.results)) for name in unknown]
    found: list[Line] = []
    for sample in findings.samples:
        if not any(_candidates(findings, sample.id, "k")):
            continue
        try:
            k, c = (_chosen(findings, sample.id, quantity, use) for quantity in ("k", "c"))
            length = _stated(sample.length, "m", f"length of sample '{sample.id}'")
        except MetrologyError as error:
            faults += error.faults
            continue
        found.append(Line(sample.id, k, c, length, _correlation(findings, k.name, c.name), sample))
    if not found and not faults:
        faults.append(Fault(findings.campaign.id, "no result k of a sample", "a test that gives a stiffness in N/m"))
    if faults:
        raise MetrologyError(*faults)
    return tuple(found)


def _candidates(findings: Findings, sample: str, quantity: str) -> Iterator[Result]:
    for one in findings.results:
        if one.sample == sample and one.quantity == quantity and one.headline and isfinite(one.value + one.u):
            yield one


def _chosen(findings: Findings, sample: str, quantity: str, use: Sequence[str]) -> Result:
    """The only result of a quantity of a sample, or the one that is named."""
    found = list(_candidates(findings, sample, quantity))
    named = [one for one in found if one.name in use]
    where = f"{quantity} of sample '{sample}'"
    if not found:
        expected = f"a test that gives it, in {_SI[quantity]}"
        raise MetrologyError(Fault(where, "no result", expected, "a free decay or a response test gives k and c"))
    if len(named or found) > 1:
        got, fix = f"{len(named or found)} results", "say which: --use NAME (in Python use=['NAME'])"
        raise MetrologyError(Fault(where, got, _one_of(named or found), fix))
    (chosen,) = named or found
    if chosen.unit != _SI[quantity]:
        expected = f"{_SI[quantity]}, of a line that is stretched"
        raise MetrologyError(Fault(where, f"'{chosen.name}' in {chosen.unit}", expected))
    return chosen


def _one_of(results: Sequence[Result]) -> str:
    return f"one of {', '.join(one.name for one in results)}"


def _correlation(findings: Findings, a: str, b: str) -> float:
    return next((one.coefficient for one in findings.correlations if {one.a, one.b} == {a, b}), 0.0)


def _stated(text: str, unit: str, where: str) -> UFloat:
    """A property of a sample as `results.json` has it, in SI."""
    if not text:
        raise MetrologyError(_missing(where, f"a quantity in {unit}"))
    found = parse(text, expected=unit)
    return _number(found.value, found.u or 0.0)


def _number(value: float, u: float) -> UFloat:
    """A variable with its standard uncertainty; that one may be exact is no reason for a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return ufloat(value, u)


def _missing(where: str, expected: str) -> Fault:
    fix = "state it under 'samples' in the campaign file, and evaluate it again"
    return Fault(where, "nothing", expected, fix)


def heading(findings: Findings, what: str) -> list[str]:
    """What stands at the head of a file, a text a line: what it is, and what must be known before a number is used."""
    campaign = findings.campaign
    written = [f"{what} of campaign {campaign.id}, by metrology {findings.software.get('metrology', __version__)}; SI"]
    written += [f"Reconstructed: {campaign.reconstructed}"] * bool(campaign.reconstructed)
    return [
        " ".join(one.split())
        for one in [*written, *(f"{kind}: {sentence}" for kind, sentence in brief(findings, english(findings)))]
    ]


def sources(line: Line) -> list[str]:
    """Where the numbers of a line come from, a text a line: each with u, and what the model as stated gives."""
    written = [f"{line.name}: length {_shown(line.length.n, line.length.s)} m"]
    for symbol, result in (("k", line.k), ("c", line.c)):
        stated = result.stated
        beside = f"; by the model as stated {_shown(stated.value, stated.u)}: {stated.why}" if stated else ""
        written.append(
            f"{line.name}: {symbol} = {_shown(result.value, result.u)} {result.unit} (± u), from {result.name}{beside}"
        )
    return [*written, f"{line.name}: correlation coefficient of k and c {line.correlation:.3f}"]


def _shown(value: float, u: float) -> str:
    return " ± ".join(significant(value, u)) if u > 0 else f"{value:g}"


def word(name: str) -> str:
    """A name as other programs take it: letters, digits, underscores, the first one a letter.

    Examples
    --------
    >>> word("al-1100"), word("2 mm line")
    ('al_1100', 'n2_mm_line')
    """
    plain = re.sub(r"\W+", "_", name, flags=re.ASCII)
    return plain if re.match(r"[A-Za-z]", plain) else f"n{plain}"


@dataclass
class Words:
    """Names of one export as other programs take them: of names that would be alike there, the later are numbered.

    Parameters
    ----------
    plain : callable
        Makes a word of the parts of a name.

    Examples
    --------
    >>> words = Words()
    >>> words("k", "a-b"), words("k", "a_b"), words("K", "a b"), words("k", "a-b")
    ('k_a_b', 'k_a_b_2', 'K_a_b_3', 'k_a_b')
    """

    plain: Callable[[Sequence[str]], str] = lambda parts: word("_".join(parts))
    _known: dict[tuple[str, ...], str] = field(default_factory=dict)

    def __call__(self, *parts: str) -> str:
        """Return the word of a name in parts, the same each time.

        Words that differ in the case of their letters alone are alike: as names of files they are, on some disks.
        """
        if parts not in self._known:
            plain, taken = self.plain(parts), {known.casefold() for known in self._known.values()}
            ends = chain([""], (f"_{number}" for number in count(2)))
            self._known[parts] = next(plain + end for end in ends if (plain + end).casefold() not in taken)
        return self._known[parts]
