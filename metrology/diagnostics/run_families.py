"""Unlisted laws along the motions of runs on the rig: smooth forces, curved readings, slow errors, lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from metrology.coordinate import QUANTITIES
from metrology.diagnostics import flexible
from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.direction import Direction
from metrology.diagnostics.settling import Model
from metrology.diagnostics.spectrum import strongest
from metrology.diagnostics.subject import Fit
from metrology.diagnostics.wander import WANDER, wanders
from metrology.estimation.response import values_of


def families_of(model: Model, fit: Fit, spectral: Sequence[Candidate], lowest: float) -> list[Direction]:
    """Families of any form about a fit; `spectral`: candidates that are lines, sought from a frequency / Hz on."""
    values = [values_of(model.layout, at, fit.theta) for at in range(len(model.runs))]
    found = flexible.directions(model.rig, model.runs, values, fit)
    slow = wanders(model.runs, fit, QUANTITIES[model.rig.coordinate])
    return [*found, *slow, *_lines(model, fit, spectral, lowest)]


def smooth(families: Sequence[Direction]) -> list[Direction]:
    """Smooth forces and curved readings alone."""
    every = [one for one in families if not (one.is_line or one.neighbours)]
    alone = (flexible.ALONE, flexible.THRUST)
    return [one for one in every if not (one.effect.startswith(WANDER) or one.effect.endswith(alone))]


def _lines(model: Model, fit: Fit, spectral: Sequence[Candidate], lowest: float) -> list[Direction]:
    """Strongest line of every channel beside those that a fit carries: a model has one frequency for all."""
    words, found = QUANTITIES[model.rig.coordinate], []
    for one in spectral:
        for line in strongest(fit, model.runs, one, lowest):
            places = {f"{way}@0": 0.0 for way in line.ways}
            word = f"oscillation of {words[one.cause.spectral].word}"
            found.append(replace(line, effect=word, values=places, is_line=True))
    return found
