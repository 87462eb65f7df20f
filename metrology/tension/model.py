"""Measurement model of a tension test: from slopes, scales and lengths to stiffness, modulus, set-up and strength."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np

from metrology.gum.distributions import Normal, Rectangular
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Component, Ensemble, Input
from metrology.tension.lines import End, Lines, rounding
from metrology.tension.slope import Slope
from metrology.tension.test import TensionTest

UNITS = {
    "EA": "N", "k": "N/m", "E": "Pa", "C": "m/N", "F_max": "N", "R_m": "Pa", "eps_b": "1", "tenacity": "N·m/kg",
}  # fmt: skip
"""Every result with its SI unit, each after those from which it follows."""
EQUATIONS = {
    "EA": "EA = (dF/dε)·(1 + δ_F)/(1 + δ_ε)", "k": "k = EA/L", "E": "E = EA/A", "C": "C = dx/dF − L/EA",
    "F_max": "F_max = largest force", "R_m": "R_m = F_max/A", "eps_b": "ε_b = strain at break",
    "tenacity": "f = F_max/λ",
}  # fmt: skip
BY_CROSSHEAD = "EA = L/(dx/dF − C)"
BY_LENGTHS = "dx/dF = C + L/EA, over specimens of several lengths"
LENGTHS = 3
"""Different lengths from which on the set-up's compliance follows from them: two would leave no scatter."""


@dataclass(frozen=True)
class Facts:
    """What a test declares, by which it is known beforehand which results it gives."""

    strain: bool
    crosshead: bool
    lengths: int
    sample_length: bool
    area: bool
    linear_density: bool
    setup: bool
    to_break: bool

    @property
    def by_lengths(self) -> bool:
        """Whether specimens of several lengths tell the set-up's compliance."""
        return not self.strain and not self.setup and self.lengths >= LENGTHS

    @property
    def results(self) -> dict[str, str]:
        """Every result with its unit."""
        known = {
            "EA": self.strain or bool(self.lengths),
            "k": self.sample_length if self.by_lengths else bool(self.lengths),
            "E": self.area and (self.strain or bool(self.lengths)),
            "C": (self.strain and self.crosshead and bool(self.lengths)) or self.by_lengths,
            "F_max": self.to_break,
            "R_m": self.to_break and self.area,
            "eps_b": self.to_break and (self.strain or bool(self.lengths)),
            "tenacity": self.to_break and self.linear_density,
        }
        return {name: unit for name, unit in UNITS.items() if known[name]}


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
            self._know(known)
        together = self._by_lengths(namespace) if self.facts.by_lengths else ()
        each = [name for name in self.facts.results if name not in together]
        for one, reached in zip(self.drawn, self.ends, strict=True):
            for name in each:
                if (function := self._specimen(one, reached, name)) is not None:
                    equation = BY_CROSSHEAD if name == "EA" and one.strain is None else EQUATIONS[name]
                    self._add(self.name(one, name), function, name, equation)
        values = self._evaluated(namespace, each)
        within = {one.mounting.name: self._within(one, values) for one in self.drawn}
        ensembles = tuple(self._means(values, within)) if len(self.drawn) > 1 else ()
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
            case "k":
                length = self._know(one.mounting.length)
                return lambda n: n[self.name(one, "EA")] / n[length]
            case "E":
                return lambda n: n[self.name(one, "EA")] / n[one.mounting.area]
            case "C":
                return self._compliance(one, of)
            case "F_max" if reached.reached:
                most = self._know(Input(f"{of}.force", reached.most, (), "N", f"largest force on {one.mounting.name}"))
                return lambda n: n[most] * (1 + self._scale(n, self.test.force_scale))
            case "R_m" if reached.reached:
                return lambda n: n[self.name(one, "F_max")] / n[one.mounting.area]
            case "tenacity" if reached.reached:
                return lambda n: n[self.name(one, "F_max")] / n[self.test.linear_density]
            case "eps_b" if reached.reached and isfinite(reached.strain):
                what = f"strain of {one.mounting.name} at break"
                strain = self._know(Input(f"{of}.break", reached.strain, (), "1", what))
                scale = self.test.strain_scale if one.strain else self.test.crosshead_scale
                return lambda n: n[strain] * (1 + self._scale(n, scale))
        return None

    def _rigidity(self, one: Lines, of: str) -> Callable[[Mapping[str, Any]], Any]:
        """Force by strain: by the extensometer, else by the crosshead less the set-up."""
        if one.strain is not None:
            slope, gauge = self._slope(f"{of}.strain slope", one.strain, one, "strain"), self.test.gauge
            shown = 1.0 if gauge is None else gauge.value

            def by_strain(n: Mapping[str, Any]) -> Any:
                gauged = 1.0 if gauge is None else n[gauge.name] / shown
                return gauged * (1 + self._scale(n, self.test.force_scale)) / (
                    n[slope] * (1 + self._scale(n, self.test.strain_scale)))  # fmt: skip

            return by_strain
        moved = self._moved(one, of)
        length, setup = self._know(one.mounting.length), self.test.setup
        return lambda n: n[length] / (moved(n) - (0.0 if setup is None else n[setup.name]))

    def _moved(self, one: Lines, of: str) -> Callable[[Mapping[str, Any]], Any]:
        """Displacement of the crosshead by force."""
        assert one.crosshead is not None
        slope = self._slope(f"{of}.crosshead slope", one.crosshead, one, "crosshead")
        return lambda n: n[slope] * (1 + self._scale(n, self.test.crosshead_scale)) / (
            1 + self._scale(n, self.test.force_scale))  # fmt: skip

    def _compliance(self, one: Lines, of: str) -> Callable[[Mapping[str, Any]], Any]:
        """What the crosshead moves beyond the stretch of the specimen, by force."""
        assert one.setup is not None
        assert one.strain is not None
        assert one.mounting.length is not None
        rest = self._slope(f"{of}.setup slope", one.setup, one, "crosshead")
        strain, length, shown = f"{of}.strain slope", self._know(one.mounting.length), one.mounting.length.value

        def beyond(n: Mapping[str, Any]) -> Any:
            moved = (n[rest] + shown * n[strain]) * (1 + self._scale(n, self.test.crosshead_scale))
            return moved / (1 + self._scale(n, self.test.force_scale)) - n[length] / n[self.name(one, "EA")]

        return beyond

    def _slope(self, name: str, line: Slope, one: Lines, column: str) -> str:
        """A slope as an input: by the scatter of its record, and by rounding."""
        scatter = Component("scatter of the record", Normal(line.u), line.dof, "A",
                            f"generalised least squares over {line.count} readings, noise with its memory")  # fmt: skip
        force = one.passage.force[1] - one.passage.force[0]
        rounded = rounding(line, force, self.test.division.get(column, 0.0))
        more = (Component("resolution", Normal(rounded), source="division of the instrument"),) if rounded > 0 else ()
        unit = "1/N" if name.endswith("strain slope") else "m/N"
        return self._know(Input(name, line.value, (scatter, *more), unit, f"{column} by force, {one.mounting.name}"))

    def _know(self, one: Input | None) -> str:
        if one is None:
            return ""
        self.inputs.setdefault(one.name, one)
        return one.name

    def _add(self, name: str, function: Callable[[Mapping[str, Any]], Any], result: str, equation: str) -> None:
        self.measurands.append(Measurand(name, function, UNITS[result], equation))

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

    def _within(self, one: Lines, values: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
        """Standard uncertainty of each result of a specimen that no other shares: its record, its own section."""
        of, found = one.mounting, {}
        line = one.main
        part = line.u / abs(line.value)
        section = of.area_u / of.area_value if of.area_u else 0.0
        for name, value in values[of.name].items():
            relative = {"E": float(np.hypot(part, section)), "R_m": section, "EA": part, "k": part}.get(name, 0.0)
            found[name] = one.setup.u if name == "C" and one.setup is not None else abs(value) * relative
        return found

    def _means(
        self, values: Mapping[str, Mapping[str, float]], within: Mapping[str, Mapping[str, float]]
    ) -> Iterator[Ensemble]:
        """Add the mean of every result over the specimens, and return the scatter between them.

        The scatter of the specimens holds that within them: what is left of s² beside it is the scatter between.
        """
        names = [name for name in self.facts.results if any(name in own for own in values.values())]
        held = {name: [one for one in self.drawn if name in values[one.mounting.name]] for name in names}
        scattered = []
        for name in names:
            members, scatter = held[name], f"{self.test.name}.scatter of {name}"
            s2 = float(np.var([values[one.mounting.name][name] for one in members], ddof=1)) if len(members) > 1 else 0
            own2 = float(np.mean([within[one.mounting.name][name] ** 2 for one in members]))
            part = max(0.0, 1.0 - own2 / s2) if s2 > 0 else 0.0
            if part > 0:
                what = f"relative scatter of {name} between the specimens"
                self._know(Input(scatter, 0.0, (), "1", what))
                scattered.append((name, part))
            full = [self.name(one, name) for one in members]
            added = scatter if part > 0 else ""
            size = float(np.sqrt(np.mean([values[one.mounting.name][name] ** 2 for one in members])))
            self._add(
                f"{self.test.name}.{name}", _mean(full, added, size), name, f"{name} = mean over {len(full)} specimens"
            )
        yield from self._scattered(values, scattered, held)

    def _scattered(
        self,
        values: Mapping[str, Mapping[str, float]],
        scattered: list[tuple[str, float]],
        held: Mapping[str, list[Lines]],
    ) -> Iterator[Ensemble]:
        """One ensemble of all results that every specimen has, and one for each other."""
        whole = [(name, part) for name, part in scattered if len(held[name]) == len(self.drawn)]
        rest = [[one] for one in scattered if one not in whole]
        for group in [whole, *rest]:
            if not group:
                continue
            members = held[group[0][0]]
            rows = np.array([[values[one.mounting.name][name] for one in members] for name, _ in group])
            rows = rows / np.sqrt(np.mean(rows**2, axis=1, keepdims=True))
            kept = np.sqrt([part for _, part in group])
            covariance = np.atleast_2d(np.cov(rows, ddof=1)) * np.outer(kept, kept) / len(members)
            names = tuple(f"{self.test.name}.scatter of {name}" for name, _ in group)
            source = f"standard deviation of the mean of {len(members)} specimens, less what each one's record explains"
            label = "scatter between specimens" + ("" if group is whole else f", {group[0][0]}")
            yield Ensemble(f"{label}, {self.test.name}", names, covariance, len(members) - 1.0, source)

    # ---- several lengths ----------------------------------------------------------------------------------------
    def _by_lengths(self, namespace: Mapping[str, float]) -> tuple[str, ...]:
        """dx/dF against free length: the intercept is the set-up, the slope 1/EA; scatter by mounting from the fit."""
        moved = [self._moved(one, f"{self.test.name}.{one.mounting.name}") for one in self.drawn]
        lengths = [self._know(one.mounting.length) for one in self.drawn]
        self._scatter_about(namespace, moved, [self.inputs[name].value for name in lengths])
        test, area = self.test.name, self.drawn[0].mounting.area

        def fitted(n: Mapping[str, Any]) -> tuple[Any, Any]:
            X, Y = [n[name] for name in lengths], [one(n) for one in moved]
            mean_x, mean_y = sum(X) / len(X), sum(Y) / len(Y)
            b = sum((p - mean_x) * (q - mean_y) for p, q in zip(X, Y, strict=True)) / sum((p - mean_x) ** 2 for p in X)
            return mean_y - b * mean_x, b

        functions: dict[str, Callable[[Mapping[str, Any]], Any]] = {
            "EA": lambda n: 1 / fitted(n)[1],
            "k": lambda n: n[f"{test}.EA"] / n[self.test.sample_length],
            "E": lambda n: n[f"{test}.EA"] / n[area],
            "C": lambda n: fitted(n)[0],
        }
        found = tuple(name for name in functions if name in self.facts.results)
        for name in found:
            self._add(f"{test}.{name}", functions[name], name, BY_LENGTHS if name in ("EA", "C") else EQUATIONS[name])
        return found

    def _scatter_about(
        self, namespace: Mapping[str, float], moved: Sequence[Callable[[Mapping[str, Any]], Any]], x: Sequence[float]
    ) -> None:
        """Add to each slope of the crosshead how the mountings scatter about the line over the free lengths."""
        known = {**namespace, **{name: one.value for name, one in self.inputs.items()}}
        c, X = np.array([float(one(known)) for one in moved]), np.column_stack([np.ones(len(x)), x])
        rest, dof = c - X @ np.linalg.lstsq(X, c, rcond=None)[0], len(x) - 2
        s2 = float(rest @ rest) / dof - float(np.mean([one.main.u**2 for one in self.drawn]))
        if s2 <= 0:
            return
        source = "scatter of the mountings about the line over the free lengths"
        scatter = Component("mounting", Normal(float(np.sqrt(s2))), float(dof), "A", source)
        for one in self.drawn:
            name = f"{self.test.name}.{one.mounting.name}.crosshead slope"
            self.inputs[name] = replace(self.inputs[name], components=(*self.inputs[name].components, scatter))


def _mean(names: list[str], scatter: str, size: float) -> Callable[[Mapping[str, Any]], Any]:
    """Mean of results, with the scatter between them over their size.

    The size, a root mean square, is a number and no result: a mean near zero, as of a compliance, leaves it large.
    """
    return lambda n: sum(n[name] for name in names) / len(names) + (size * n[scatter] if scatter else 0.0)


def class_scale(name: str, cls: str, standard: str, limit: float) -> Input:
    """Relative correction of an instrument of a class, whose indications are within a limit of the true values."""
    component = Component(f"class {cls}", Rectangular(limit), source=f"limit of error of class {cls}, {standard}")
    return Input(name, 0.0, (component,), "1", "relative correction")
