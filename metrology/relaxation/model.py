"""Measurement model of a relaxation or creep test: from what the record says, scales and lengths to k and E."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np

from metrology.gum.bounded import Rectangular
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Component, Ensemble, Input
from metrology.message import said
from metrology.relaxation.evidence import Said
from metrology.relaxation.test import Mounting, RelaxationTest

Function = Callable[[Mapping[str, Any]], Any]
UNITS = {
    "k_0": "N/m", "k_inf": "N/m", "k_t": "N/m", "E_0": "Pa", "E_inf": "Pa", "E_t": "Pa", "relaxed": "1", "alpha": "1",
}  # fmt: skip
"""Every result with its SI unit."""
DESCRIBED = {
    "r_0": "force by stretch at once, {specimen}",
    "r_inf": "force by stretch in equilibrium, {specimen}",
    "r_t": "force by stretch after {at:g} s, {specimen}",
    "fall": "fall of ln k with ln t, {specimen}",
}
SAID = ("r_0", "r_inf", "r_t", "fall")
"""What the record of a specimen may say, in the order of its joint covariance: force by stretch, and its fall."""


@dataclass(frozen=True)
class Facts:
    """What a test declares, by which it is known beforehand which results it gives."""

    by_strain: bool
    length: bool
    area: bool
    at: bool

    @property
    def results(self) -> dict[str, str]:
        """Every result with its unit, as far as the record supports it."""
        k, E = not self.by_strain or self.length, self.area and (self.by_strain or self.length)
        times = ["0", "inf", *(["t"] if self.at else [])]
        names = [f"k_{t}" for t in times if k] + [f"E_{t}" for t in times if E] + ["relaxed"]
        names += ["alpha"] if self.at else []
        return {name: UNITS[name] for name in UNITS if name in names}


@dataclass(frozen=True)
class Built:
    """Inputs, measurands and ensembles of a test; estimates of every specimen by result, and their own u."""

    inputs: tuple[Input, ...]
    measurands: tuple[Measurand, ...]
    ensembles: tuple[Ensemble, ...]
    values: Mapping[str, Mapping[str, float]]
    within: Mapping[str, Mapping[str, float]]


class Builder:
    """Puts a test together, specimen by specimen.

    `said` holds for each specimen the numbers of `SAID` that its record supports, by their names; `at_once` those that
    were not read before the ramp.
    """

    def __init__(
        self,
        test: RelaxationTest,
        facts: Facts,
        said: Mapping[str, tuple[tuple[str, ...], Said]],
        at_once: frozenset[str] = frozenset(),
    ) -> None:
        self.test, self.facts, self.said, self.at_once = test, facts, said, at_once
        self.inputs: dict[str, Input] = {}
        self.functions: dict[str, dict[str, Function]] = {one.name: {} for one in test.mountings}
        self.measurands: list[Measurand] = []
        self.ensembles: list[Ensemble] = []

    def built(
        self,
        namespace: Mapping[str, float],
        rounding: Mapping[str, float],
        steps: Mapping[str, float],
        instants: Mapping[str, Mapping[str, float]],
    ) -> Built:
        """Return everything; `namespace` holds what the model knew before.

        `rounding` and `steps` are half widths by specimen: of force by stretch, by the division of what answered; and
        relative, by that of what was imposed. `instants` those of its numbers by the unread instant of a step. One
        machine makes the steps of all specimens: what is not read of them is common to those that read alike.
        """
        for known in (self.test.force_scale, self.test.stretch_scale, self.test.gauge, self.test.setup):
            self._know(known)
        for one in self.test.mountings:
            self._record(one, rounding.get(one.name, 0.0), instants.get(one.name, {}))
            self._step(one, steps.get(one.name, 0.0))
            for name in self.facts.results:
                self._specimen(one, name)
        values = self._evaluated(namespace)
        within = {one.name: self._within(one, values[one.name]) for one in self.test.mountings}
        if len(self.test.mountings) > 1:
            self.ensembles += self._means(values, within)
        else:
            for name, function in self.functions[self.test.mountings[0].name].items():
                full = f"{self.test.name}.{name}"
                self.measurands.append(Measurand(full, function, UNITS[name], self._equation(name)))
        return Built(tuple(self.inputs.values()), tuple(self.measurands), tuple(self.ensembles), values, within)

    # ---- one specimen -------------------------------------------------------------------------------------------
    def _record(self, one: Mounting, rounding: float, instants: Mapping[str, float]) -> None:
        """What the record says as inputs with a joint covariance; rounding of readings that hardly scatter."""
        names, known = self.said[one.name]
        of = f"{self.test.name}.{one.name}"
        unit = "N" if self.test.by_strain else "N/m"
        for name, value in zip(names, known.values.tolist(), strict=True):
            source = said("division of the instrument")
            rounded = Component(said("resolution"), Rectangular(rounding), source=source)
            components: tuple[Component, ...] = (rounded,) if rounding > 0 and name != "fall" else ()
            if half := instants.get(name):
                cause = f"{self.test.name}, instant of the step"
                unread = said("the step lies between two readings")
                components += (Component(said("instant of the step"), Rectangular(half), source=unread, cause=cause),)
            what = said(DESCRIBED[name], specimen=one.name, at=0.0 if self.test.at is None else float(self.test.at))
            self._know(Input(f"{of}.{name}", value, components, "1" if name == "fall" else unit, what))
        source = said("all forms by their evidence, noise with its memory")
        if one.name in self.at_once:
            text = "all forms by their evidence, noise with its memory; the zero was not read before the ramp"
            source = said(text)
        members = tuple(f"{of}.{name}" for name in names)
        label = said("record of {specimen}, {test}", specimen=one.name, test=self.test.name)
        if members:  # of a power law nothing is left where no time is asked for
            self.ensembles.append(Ensemble(label, members, known.covariance, known.dof, source))

    def _step(self, one: Mounting, relative: float) -> None:
        """Division of what was imposed: one step, and one error, for all numbers of a record."""
        if relative > 0:
            source = said("division of the instrument, over the step")
            cause = f"{self.test.name}, rounding of a step, {relative:.6g}"
            rounded = Component(said("resolution"), Rectangular(relative), source=source, cause=cause)
            name = f"{self.test.name}.{one.name}.step"
            what = said("relative correction of the step, {specimen}", specimen=one.name)
            self._know(Input(name, 0.0, (rounded,), "1", what))

    def _specimen(self, one: Mounting, result: str) -> None:
        names, _ = self.said[one.name]
        of = f"{self.test.name}.{one.name}"
        step = f"{of}.step" if f"{of}.step" in self.inputs else ""
        if result == "alpha":
            if "fall" in names:
                self._add(one, result, self._fall(of, step) if "r_t" in names else lambda n: n[f"{of}.fall"])
            return
        if result == "relaxed":
            if {"r_0", "r_inf"} <= set(names):
                self._add(one, result, self._relaxed(of, step))
            return
        kind, time = result.split("_")
        if f"r_{time}" not in names:
            return
        base = self._base(f"{of}.r_{time}", step)
        length, area = self._know(one.length), one.area
        functions: dict[tuple[str, bool], Function] = {
            ("k", False): base,
            ("k", True): lambda n: base(n) / n[length],
            ("E", False): lambda n: base(n) * n[length] / n[area],
            ("E", True): lambda n: base(n) / n[area],
        }
        self._add(one, result, functions[kind, self.test.by_strain])

    def _relaxed(self, of: str, step: str) -> Function:
        """Part that relaxes: scales cancel, the compliance of a set-up does not."""
        if self.test.setup is None:
            return lambda n: 1 - n[f"{of}.r_inf"] / n[f"{of}.r_0"]
        at_once, at_last = self._base(f"{of}.r_0", step), self._base(f"{of}.r_inf", step)
        return lambda n: 1 - at_last(n) / at_once(n)

    def _fall(self, of: str, step: str) -> Function:
        """Fall of ln k with ln t: that of ln r, over 1 − (C − C_0)·r."""
        read = self._read(f"{of}.r_t", step)
        return lambda n: n[f"{of}.fall"] / (1 - self._beyond(n) * read(n))

    def _base(self, name: str, step: str) -> Function:
        """Force by stretch: step, scales, gauge length, and what the set-up was taken to give way."""
        read = self._read(name, step)
        if self.test.setup is None:
            return read
        return lambda n: 1 / (1 / read(n) - self._beyond(n))

    def _read(self, name: str, step: str) -> Function:
        """Force by stretch as it was read: step, scales, gauge length."""
        test = self.test

        def read(n: Mapping[str, Any]) -> Any:
            gauged = 1.0 if test.gauge is None else n[test.gauge.name] / test.gauge.value
            found = n[name] * (1 + n[step] if step else 1.0) * gauged
            return found * (1 + self._scale(n, test.force_scale)) / (1 + self._scale(n, test.stretch_scale))

        return read

    def _beyond(self, n: Mapping[str, Any]) -> Any:
        """By what the set-up gives way beyond what was taken from the crosshead."""
        setup = self.test.setup
        return 0.0 if setup is None else n[setup.name] - setup.value

    def _equation(self, result: str) -> str:
        kind, _, time = result.partition("_")
        if result == "alpha":
            return said("α = fall of ln k with ln t")
        if result == "relaxed":
            return "R = 1 − k_inf/k_0"
        stepped = any(f"{self.test.name}.{one.name}.step" in self.inputs for one in self.test.mountings)
        found = f"r_{time}{'·(1 + δ_u)' if stepped else ''}{'·(L_g/L_g0)' if self.test.gauge is not None else ''}"
        found = f"{found}·(1 + δ_F)/(1 + δ_x)"
        if self.test.setup is not None:
            found = f"1/((1 + δ_x)/(r_{time}{'·(1 + δ_u)' if stepped else ''}·(1 + δ_F)) − (C − C_0))"
        by = {("k", False): "", ("k", True): "/L", ("E", False): "·L/A", ("E", True): "/A"}
        return f"{result} = {found}{by[kind, self.test.by_strain]}"

    def _know(self, one: Input | None) -> str:
        if one is None:
            return ""
        self.inputs.setdefault(one.name, one)
        return one.name

    def _add(self, one: Mounting, result: str, function: Function) -> None:
        self.functions[one.name][result] = function

    @staticmethod
    def _scale(n: Mapping[str, Any], scale: Input | None) -> Any:
        return 0.0 if scale is None else n[scale.name]

    # ---- all specimens ------------------------------------------------------------------------------------------
    def _evaluated(self, namespace: Mapping[str, float]) -> dict[str, dict[str, float]]:
        known = {**namespace, **{name: one.value for name, one in self.inputs.items()}}
        return {
            one: {name: float(function(known)) for name, function in own.items()} for one, own in self.functions.items()
        }

    def _within(self, one: Mounting, values: Mapping[str, float]) -> dict[str, float]:
        """Standard uncertainty of each result of a specimen by its record alone."""
        names, known = self.said[one.name]
        at = {name: place for place, name in enumerate(names)}
        found: dict[str, float] = {}
        for name, value in values.items():
            if name == "alpha":
                found[name] = float(known.u[at["fall"]])
            elif name == "relaxed":
                a, b = known.values[at["r_0"]], known.values[at["r_inf"]]
                row = np.zeros(len(names))
                row[at["r_0"]], row[at["r_inf"]] = b / a**2, -1 / a
                found[name] = sqrt(max(float(row @ known.covariance @ row), 0.0))
            else:
                place = at[f"r_{name.split('_')[1]}"]
                found[name] = abs(value) * float(known.u[place] / abs(known.values[place]))
        return found

    def _means(
        self, values: Mapping[str, Mapping[str, float]], within: Mapping[str, Mapping[str, float]]
    ) -> Iterator[Ensemble]:
        """Add the mean of every result over the specimens, and the scatter between them (JCGM 100 4.2.3).

        What is left of s² beside the variance within the specimens is the scatter between them.
        """
        members = self.test.mountings
        scattered = []
        for name in [name for name in self.facts.results if all(name in own for own in values.values())]:
            rows = np.array([values[one.name][name] for one in members])
            s2, own2 = float(np.var(rows, ddof=1)), float(np.mean([within[one.name][name] ** 2 for one in members]))
            part: float = max(0.0, 1.0 - own2 / s2) if s2 > 0 else 0.0
            scatter = f"{self.test.name}.scatter of {name}"
            if part > 0:
                what = said("scatter of {name} between the specimens", name=name)
                self._know(Input(scatter, 0.0, (), UNITS[name], what))
                scattered.append((name, part, rows))
            each = tuple(self.functions[one.name][name] for one in members)
            over = said("with the mean over {count} specimens", count=len(each))
            equation = said("{equation}, {over}", equation=self._equation(name), over=over)
            mean = _mean(each, scatter if part > 0 else "")
            self.measurands.append(Measurand(f"{self.test.name}.{name}", mean, UNITS[name], equation))
        if scattered:
            names = tuple(f"{self.test.name}.scatter of {name}" for name, _, _ in scattered)
            # What each specimen does to every result. Of fewer specimens than results a root of their covariance would
            # draw from what rounding makes of its zeros.
            away = np.array([np.sqrt(part) * (rows - rows.mean()) for _, part, rows in scattered])
            columns = away / np.sqrt(len(members) * (len(members) - 1))
            text = "standard deviation of the mean of {count} specimens, less what each one's record explains"
            source, label = (
                said(text, count=len(members)),
                said("{what}, {test}", what=said("scatter between specimens"), test=self.test.name),
            )
            yield Ensemble(label, names, columns @ columns.T, len(members) - 1.0, source, columns)


def _mean(each: tuple[Function, ...], scatter: str) -> Function:
    return lambda n: sum(one(n) for one in each) / len(each) + (n[scatter] if scatter else 0.0)
