"""Checks of the records against what the model of a linear viscoelastic specimen supposes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from metrology import specimens
from metrology.check import Check
from metrology.message import said
from metrology.relaxation.blocks import Array
from metrology.relaxation.checks.done import Bends, Done, Seen
from metrology.relaxation.checks.equilibrium import branches, duration, start, sweep
from metrology.relaxation.checks.levels import asked, levels, linear
from metrology.relaxation.checks.ramp import bent, ramp
from metrology.relaxation.checks.read import equilibrium, stiffness
from metrology.relaxation.checks.records import gaps, records, setup
from metrology.relaxation.checks.residuals import residuals
from metrology.relaxation.checks.rest import drift, rest
from metrology.relaxation.evidence import HALF, SURE, Supported
from metrology.relaxation.finding import Compared
from metrology.relaxation.model import Built
from metrology.relaxation.test import RelaxationTest

__all__ = ["Bends", "Done", "Seen", "bent", "notes", "run"]


def run(test: RelaxationTest, seen: Seen, found: Supported, built: Built, dma: Sequence[Compared]) -> tuple[Check, ...]:
    """All checks, in the order in which the report shows them: of the whole records, then of what is evaluated."""
    whole, done = seen.whole, seen.done
    names = [one.mounting.name for one in done]
    checks = [records(test, whole), gaps(whole), levels(test, whole), linear(test, whole), ramp(test, seen)]
    checks += [residuals(test, whole), drift(done, found), rest(test, whole), branches(test, found)]
    checks += [start(done, found), duration(done, found), equilibrium(test, done, found)]
    if test.at is not None:
        checks += [asked(test.at, done), stiffness(test, done)]
    checks.append(specimens.outlier(names, (built.values, built.within), _compared(built), test.significance))
    if not test.by_strain:
        checks.append(setup(test))
    if test.dma is not None:
        checks.append(sweep(dma))
    return tuple(checks)


def _compared(built: Built) -> list[str]:
    """The stiffness of every kind that all specimens have; the modulus where their sections are known."""
    kinds = set.intersection(*(set(one) for one in built.values.values()))
    moduli = sorted(kind for kind in kinds if kind.startswith("E_"))
    return moduli or sorted(kind for kind in kinds if kind.startswith("k_"))


def notes(done: Sequence[Done], found: Supported, ends: Array) -> Iterator[str]:
    """What is worth knowing of the evaluation."""
    memory = max(one.best.memory for one in done)
    yield said(
        "Consecutive readings are not taken as independent: models of the noise with every correlation time up to the "
        "duration of the record count by their probability given the record (mean correlation time up to {memory:.2g} "
        "s).",
        memory=float(memory),
    )
    yield said(
        "The ramp is in the model: the answer is Boltzmann's integral over the course of the input, straight pieces "
        "with the corners that its readings support."
    )
    text = "Moduli are predicted from {low:.2g} Hz (longest hold) to {high:.2g} Hz (longest ramp)."
    yield said(text, low=float(ends[0]), high=float(ends[1]))
    for one in done:
        for (_, fast, high), (low, slow, _) in pairwise(one.times.tolist()):
            if high > low:
                yield said(
                    "The 95 % intervals of two branches of {specimen} overlap ({fast:.2g} s and {slow:.2g} s): their "
                    "parts are known together, and hardly apart.",
                    specimen=one.mounting.name,
                    fast=fast,
                    slow=slow,
                )
    if 1 - SURE < found.power <= HALF:
        yield said(
            "A power law, which has no equilibrium, has a probability of {power:.2g}: instantaneous and equilibrium "
            "stiffness are those of the other forms.",
            power=float(found.power),
        )
    zeros = [_zero(one) for one in done if not one.levels.before]
    if zeros:
        yield said(
            "Nothing was read before the ramp: the zero of what answered is known to {part:.2g} % of its range, by the "
            "first reading and by the form that is fitted. This is in the uncertainty of every stiffness. Read for a "
            "while before the ramp.",
            part=100 * max(zeros),
        )


def _zero(one: Done) -> float:
    """Standard uncertainty of the zero of what answered by the most probable form, over the range of the answer."""
    return float(np.sqrt(one.best.covariance[0, 0]) / (np.ptp(one.scene.answer.of.y) or 1.0))
