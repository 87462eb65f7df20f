"""Measurement model of a tension test: from slopes, scales and lengths to stiffness, modulus, set-up and strength."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from metrology.gum.bounded import Rectangular
from metrology.gum.distributions import Normal
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Component, Ensemble, Input
from metrology.message import said
from metrology.tension.lengths import by_lengths
from metrology.tension.lines import End, Lines, rounding
from metrology.tension.means import means
from metrology.tension.results import BROKEN_BY_CROSSHEAD, BY_CROSSHEAD, EQUATIONS, UNITS, Facts
from metrology.tension.secant import Local
from metrology.tension.slope import Slope
from metrology.tension.test import TensionTest

SLOPE = {"strain": "strain by force, {specimen}", "crosshead": "crosshead by force, {specimen}"}
LOCAL = {
    ("secant", "strain"): "secant of strain by force, {specimen}",
    ("secant", "crosshead"): "secant of crosshead by force, {specimen}",
    ("tangent", "strain"): "tangent of strain by force, {specimen}",
    ("tangent", "crosshead"): "tangent of crosshead by force, {specimen}",
}
"""What a slope is of, by what was read."""


@dataclass(frozen=True)
class Built:
    """Inputs, measurands and ensembles of a test, and the estimates of every specimen by result."""

    inputs: tuple[Input, ...]
    measurands: tuple[Measurand, ...]
    ensembles: tuple[Ensemble, ...]
    values: Mapping[str, Mapping[str, float]]
    within: Mapping[str, Mapping[str, float]]


class Builder:
    """Puts a test together, specimen by specimen."""

    def __init__(self, test: TensionTest, drawn: tuple[Lines, ...], ends: tuple[End, ...], facts: Facts) -> None:
        self.test, self.drawn, self.ends, self.facts = test, drawn, ends, facts
        self.inputs: dict[str, Input] = {}
        self.measurands: list[Measurand] = []

    def built(self, namespace: Mapping[str, float]) -> Built:
        """Return everything; `namespace` holds what the model knew before."""
        scales = (self.test.force_scale, self.test.strain_scale, self.test.crosshead_scale)
        for known in (*scales, self.test.gauge, self.test.setup):
            self.know(known)
        together = by_lengths(self, namespace) if self.facts.by_lengths else ()
        each = [name for name in self.facts.results if name not in together]
        for one, reached in zip(self.drawn, self.ends, strict=True):
            for name in each:
                if (function := self._specimen(one, reached, name)) is not None:
                    by_crosshead = {"EA": BY_CROSSHEAD, "eps_b": BROKEN_BY_CROSSHEAD} if one.strain is None else {}
                    equation = by_crosshead.get(name, EQUATIONS[name])
                    self.add(self.name(one, name), function, name, equation)
        values = self._evaluated(namespace, each)
        within = {
            one.mounting.name: self._within(one, reached, values)
            for one, reached in zip(self.drawn, self.ends, strict=True)
        }
        ensembles = tuple(means(self, values, within)) if len(self.drawn) > 1 else ()
        return Built(tuple(self.inputs.values()), tuple(self.measurands), ensembles, values, within)

    def name(self, one: Lines, result: str) -> str:
        """Full name of a result of a specimen; of a single specimen it is that of the test."""
        return f"{self.test.name}.{one.mounting.name}.{result}" if len(self.drawn) > 1 else f"{self.test.name}.{result}"

    # ---- one specimen -------------------------------------------------------------------------------------------
    def _specimen(self, one: Lines, reached: End, result: str) -> Callable[[Mapping[str, Any]], Any] | None:
        of = f"{self.test.name}.{one.mounting.name}"
        match result:
            case "EA":
                return self._rigidity(one, of)
            case "EA_sec" | "EA_tan":
                return self._local(one, of, result)
            case "k" | "k_sec" | "k_tan":
                length = self.know(one.mounting.length)
                return lambda n: n[self.name(one, f"EA{result[1:]}")] / n[length]
            case "E" | "E_sec" | "E_tan":
                return lambda n: n[self.name(one, f"EA{result[1:]}")] / n[one.mounting.area]
            case "C":
                return self._compliance(one, of)
            case "F_max" if reached.reached:
                what = said("largest force on {specimen}", specimen=one.mounting.name)
                most = self.know(Input(f"{of}.force", reached.most, _scatter(reached.most_u), "N", what))
                return lambda n: n[most] * (1 + self._scale(n, self.test.force_scale))
            case "R_m" if reached.reached:
                return lambda n: n[self.name(one, "F_max")] / n[one.mounting.area]
            case "tenacity" if reached.reached:
                return lambda n: n[self.name(one, "F_max")] / n[self.test.linear_density]
            case "eps_b" if isfinite(reached.strain):
                return self._broken(one, reached, of)
        return None

    def _broken(self, one: Lines, reached: End, of: str) -> Callable[[Mapping[str, Any]], Any]:
        """Strain at break: by the extensometer, else by the crosshead less what the set-up gave way."""
        what = said("strain of {specimen} at break", specimen=one.mounting.name)
        strain = self.know(Input(f"{of}.break", reached.strain, _scatter(reached.strain_u), "1", what))
        if one.strain is not None:
            return lambda n: n[strain] * (1 + self._scale(n, self.test.strain_scale)) / self._gauged(n)
        setup = self.test.setup
        assert one.mounting.length is not None
        length, shown = self.know(one.mounting.length), one.mounting.length.value
        compliance = f"{self.test.name}.C" if self.facts.by_lengths else "" if setup is None else setup.name

        def broken(n: Mapping[str, Any]) -> Any:
            force = reached.force * (1 + self._scale(n, self.test.force_scale))
            moved = n[strain] * shown * (1 + self._scale(n, self.test.crosshead_scale))
            return (moved - (n[compliance] * force if compliance else 0.0)) / n[length]

        return broken

    def _rigidity(self, one: Lines, of: str) -> Callable[[Mapping[str, Any]], Any]:
        """Force by strain: by the extensometer, else by the crosshead less the set-up."""
        if one.strain is not None:
            return self._by_strain(self._slope(f"{of}.strain slope", one.strain, one, "strain"))
        return self._by_crosshead(one, self.moved(one, of))

    def _local(self, one: Lines, of: str, result: str) -> Callable[[Mapping[str, Any]], Any]:
        """Force by strain between two points, or at one, as by a line."""
        part, what = (one.secant, "secant") if result.endswith("_sec") else (one.tangent, "tangent")
        assert part is not None
        column, unit = ("strain", "1/N") if one.strain is not None else ("crosshead", "m/N")
        described = said(LOCAL[what, column], specimen=one.mounting.name)
        slope = self.know(Input(f"{of}.{what} slope", part.value, _components(part), unit, described))
        if one.strain is not None:
            return self._by_strain(slope)
        return self._by_crosshead(one, lambda n: self._read(n, slope))

    def _by_strain(self, slope: str) -> Callable[[Mapping[str, Any]], Any]:
        def by_strain(n: Mapping[str, Any]) -> Any:
            return self._gauged(n) * (1 + self._scale(n, self.test.force_scale)) / (
                n[slope] * (1 + self._scale(n, self.test.strain_scale)))  # fmt: skip

        return by_strain

    def _by_crosshead(
        self, one: Lines, moved: Callable[[Mapping[str, Any]], Any]
    ) -> Callable[[Mapping[str, Any]], Any]:
        length, setup = self.know(one.mounting.length), self.test.setup
        return lambda n: n[length] / (moved(n) - (0.0 if setup is None else n[setup.name]))

    def moved(self, one: Lines, of: str) -> Callable[[Mapping[str, Any]], Any]:
        """Displacement of the crosshead by force."""
        assert one.crosshead is not None
        slope = self._slope(f"{of}.crosshead slope", one.crosshead, one, "crosshead")
        return lambda n: self._read(n, slope)

    def _read(self, n: Mapping[str, Any], slope: str) -> Any:
        """Displacement of the crosshead by force, from the slope of what was read."""
        return n[slope] * (1 + self._scale(n, self.test.crosshead_scale)) / (1 + self._scale(n, self.test.force_scale))

    def _compliance(self, one: Lines, of: str) -> Callable[[Mapping[str, Any]], Any]:
        """What the crosshead moves beyond the stretch of the specimen, by force."""
        assert one.setup is not None
        assert one.strain is not None
        assert one.mounting.length is not None
        rest = self._slope(f"{of}.setup slope", one.setup, one, "crosshead")
        strain, length, shown = f"{of}.strain slope", self.know(one.mounting.length), one.mounting.length.value

        def beyond(n: Mapping[str, Any]) -> Any:
            moved = (n[rest] + shown * n[strain]) * (1 + self._scale(n, self.test.crosshead_scale))
            return moved / (1 + self._scale(n, self.test.force_scale)) - n[length] / n[self.name(one, "EA")]

        return beyond

    def _slope(self, name: str, line: Slope, one: Lines, column: str) -> str:
        """A slope as an input: by the scatter of its record, and by rounding."""
        source = said("generalised least squares over {count} readings, noise with its memory", count=line.count)
        scatter = Component(said("scatter of the record"), Normal(line.u), line.dof, "A", source)
        force = one.passage.force[1] - one.passage.force[0]
        rounded = rounding(line, force, self.test.division.get(column, 0.0))
        division = Component(said("resolution"), Normal(rounded), source=said("division of the instrument"))
        unit = "1/N" if name.endswith("strain slope") else "m/N"
        components = (scatter, division) if rounded > 0 else (scatter,)
        return self.know(Input(name, line.value, components, unit, said(SLOPE[column], specimen=one.mounting.name)))

    def know(self, one: Input | None) -> str:
        """Take an input into the model, and return its name."""
        if one is None:
            return ""
        self.inputs.setdefault(one.name, one)
        return one.name

    def add(self, name: str, function: Callable[[Mapping[str, Any]], Any], result: str, equation: str) -> None:
        """Take a measurand into the model."""
        self.measurands.append(Measurand(name, function, UNITS[result], equation))

    def _gauged(self, n: Mapping[str, Any]) -> Any:
        """Gauge length over that by which extensions became strains; 1 where the strain was read."""
        gauge = self.test.gauge
        return 1.0 if gauge is None else n[gauge.name] / gauge.value

    @staticmethod
    def _scale(n: Mapping[str, Any], scale: Input | None) -> Any:
        return 0.0 if scale is None else n[scale.name]

    # ---- all specimens ------------------------------------------------------------------------------------------
    def _evaluated(self, namespace: Mapping[str, float], each: Sequence[str]) -> dict[str, dict[str, float]]:
        """Estimates of every specimen by result."""
        known = {**namespace, **{name: one.value for name, one in self.inputs.items()}}
        for one in self.measurands:
            known[one.name] = float(one.function(known))
        return {
            one.mounting.name: {name: known[full] for name in each if (full := self.name(one, name)) in known}
            for one in self.drawn
        }

    def _within(self, one: Lines, reached: End, values: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
        """Standard uncertainty of each result of a specimen that no other shares: its record, its own section."""
        of, found = one.mounting, {}
        section = of.area_u / of.area_value if of.area_u else 0.0
        slopes = {"": one.main, "_sec": one.secant, "_tan": one.tangent}
        force = reached.most_u / reached.most
        relative = {"F_max": force, "R_m": float(np.hypot(force, section)), "tenacity": force}
        for end, slope in slopes.items():
            part = slope.u / abs(slope.value) if slope is not None else 0.0
            own = {"EA": part, "k": part, "E": float(np.hypot(part, section))}
            relative |= {f"{name}{end}": share for name, share in own.items()}
        for name, value in values[of.name].items():
            found[name] = abs(value) * relative.get(name, 0.0)
        if "C" in found and one.setup is not None:
            found["C"] = one.setup.u
        if "eps_b" in found:
            found["eps_b"] = reached.strain_u
        return found


def class_scale(name: str, cls: str, standard: str, limit: float) -> Input:
    """Relative correction of an instrument of a class, whose indications are within a limit of the true values."""
    source = said("limit of error of class {name}, {standard}", name=cls, standard=standard)
    component = Component(said("class {name}", name=cls), Rectangular(limit), source=source)
    return Input(name, 0.0, (component,), "1", said("relative correction"))


def _scatter(u: float) -> tuple[Component, ...]:
    """What a single reading is uncertain by, as far as the readings before it tell."""
    source = said("second differences of the readings before it")
    return (Component(said("scatter of the record"), Normal(u), kind="A", source=source),) if u > 0 else ()


def _components(part: Local) -> tuple[Component, ...]:
    """What a secant or a tangent is uncertain by."""
    source = said("cubic of the force through {count} readings, noise with its memory", count=part.count)
    scatter = Component(said("scatter of the record"), Normal(part.u), part.dof, "A", source)
    terms = said("a polynomial with two terms more")
    form = Component(said("form of the curve"), Rectangular(part.form), source=terms)
    return (scatter, form) if part.form > 0 else (scatter,)
