"""Laws of any form: a smooth force of position, speed or time, a pull of the line, a curved reading of the cell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from metrology.coordinate import QUANTITIES
from metrology.diagnostics.direction import STRAIGHT, Direction
from metrology.diagnostics.families import Powers, hats, splines
from metrology.diagnostics.force import thrust
from metrology.diagnostics.run_paths import Path, path_of, stepped
from metrology.diagnostics.subject import Array, Fit
from metrology.errors import MetrologyError
from metrology.estimation import MeasuredRun
from metrology.estimation.problem import Segment
from metrology.rig import Rig, pushed

KNOTS = {"x": 7, "v": 7, "t": 12, "e": 9, "r": 9}
"""Hats of which a smooth force is made, by what it depends on; a pull of the line, of as many cubic splines."""
IN_RUN = 17
"""Hats of a force over the time of one run by itself."""
ALONE = "in each run"
THRUST = "in proportion to the thrust"
"""What distinguishes such a force, and a part of the thrust, from a force of the time of all runs."""
POWERS = {"e": (0.5, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0), "r": (0.5, 1.5, 2.0, 2.5, 3.0)}
"""Exponents of |q|^p·sign q of which a pull of the line is a sum, too; the first power is k, or c."""
EVEN = {"e": (), "r": (0.5, 1.0, 1.5, 2.0, 3.0)}
"""Exponents of |q|^p besides: what acts while the line is drawn out alone is half of it even; a line pulls one way."""
LINE = {"e": {"k": 1.0}, "r": {"c": 1.0}}
"""What a pull of the line depends on, which the load cell reads, and what it is where it is straight; any other force
acts on the module past the cell."""
FINER = {"x": 25, "t": 34}
"""Hats more, evenly over all that was passed: for ripples, for what lasts a short time only."""
WORKERS = 2
"""Motions at a time."""
UNITS = {one.word: one.unit for words in QUANTITIES.values() for one in words.values()}
"""Unit of each word by which a family says what it is, and of what."""
CURVE = 5
"""Hats of a curved reading of the load cell."""
CURVED = "curve"
"""What such a family is, where others are a force."""


Basis = Callable[[Array], Array]
"""Parts of a law by the quantity that it is a law of, shape (n,) → (n, q)."""


def directions(rig: Rig, runs: Sequence[MeasuredRun], values: Sequence[dict[str, float]], fit: Fit) -> list[Direction]:
    """Families of small forces along the fitted motion, one hat or spline a column, and of curved tension readings.

    To first order a force f(x) acts as f at the places where the model is anyway; so each is added to the thrust
    as a function of time, and the motion followed again.
    """
    paths = [path_of(rig, run, own) for run, own in zip(runs, values, strict=True)]
    if any(path is None for path in paths):
        return []
    known = [path for path in paths if path is not None]
    model, sought = (rig, runs, values, fit), []
    for name in KNOTS:
        knots = _knots(name, known)
        if len(knots) > 2:
            sought += [
                _hats(name, knots, model, known),
                *(_powers(name, knots, model, known) if name in POWERS else []),
            ]
    sought += [*_of_thrust(model, known), _by_run(model, known)]
    curve = _curve(runs, fit, known, word=QUANTITIES[rig.coordinate]["T"].word)
    return [*_pushed(model, known, sought), *([] if curve is None else [curve])]


Model = tuple[Rig, Sequence[MeasuredRun], Sequence[dict[str, float]], Fit]


@dataclass(frozen=True)
class _Sought:
    """Small forces in the steps of every run, shape (steps, q) each, and the families that their rows make."""

    forces: Sequence[Array]
    made: Callable[[tuple[Array, ...]], list[Direction]]


def _hats(name: str, knots: Array, model: Model, paths: Sequence[Path]) -> _Sought:
    """Hats at these places, and finer ones where the quantity has them: a coarse hat is a sum of fine ones."""
    plainly = [1.0] * len(paths)
    if name not in FINER:
        return _family(name, knots, model, paths, plainly)
    close = np.union1d(knots, np.linspace(knots[0], knots[-1], FINER[name]))
    sums, values = hats(close, knots), {f"{name}@{at}": float(knot) for at, knot in enumerate(knots)}

    def both(found: list[Direction]) -> list[Direction]:
        (fine,) = found
        coarse = replace(fine, values=values, rows=tuple(part @ sums for part in fine.rows), ways=tuple(values))
        return [coarse, replace(fine, effect=f"fine {fine.effect}")]

    fine = _family(name, close, model, paths, plainly)
    return replace(fine, made=lambda rows: both(fine.made(rows)))


def _knots(name: str, paths: Sequence[Path]) -> Array:
    """Places of the hats: evenly over time, elsewhere where the module is equally often."""
    everything = np.concatenate([path.by[name] for path in paths])
    everything = everything[np.isfinite(everything)]
    if len(everything) < 20:
        return np.empty(0)
    if name == "t" or name in LINE:
        return np.linspace(0.0 if name == "t" else float(everything.min()), float(everything.max()), KNOTS[name])
    return np.unique(np.quantile(everything, np.linspace(0.0, 1.0, KNOTS[name])))


def _splines(by: Array, knots: Array) -> Array:
    """Cubic splines of a pull of the line, which beyond the last knots are as they are there."""
    return splines(np.clip(by, knots[0], knots[-1]), knots)


def _family(
    name: str, knots: Array, model: Model, paths: Sequence[Path], factors: Sequence[Array | float], of: str = ""
) -> _Sought:
    """Hats or splines of one quantity; `factors`: what they are multiplied by along each run."""
    values = {f"{name}@{at}": float(knot) for at, knot in enumerate(knots)}
    listed = (1,) if name in LINE else STRAIGHT
    known = Direction(_word(name, model[0]) + of, values, _amount(*model[:2]), (), ways=tuple(values), listed=listed,
                      straight=LINE.get(name, {}))  # fmt: skip
    parts = partial(_splines if name in LINE else hats, knots=knots)
    return _law(name, parts, model, paths, factors, lambda rows: replace(known, rows=rows))


def _powers(name: str, knots: Array, model: Model, paths: Sequence[Path]) -> list[_Sought]:
    """Sums of powers of a pull of the line."""
    most = float(np.abs(knots).max())
    if not most > 0.0:
        return []
    powers = Powers(most, POWERS[name], EVEN[name])
    word, amount = _word(name, model[0], "powers of "), _amount(*model[:2])
    return [_law(name, powers.columns, model, paths, [1.0] * len(paths),
                 lambda rows: powers.direction(word, amount, rows, KNOTS[name], LINE[name]))]  # fmt: skip


def _word(name: str, rig: Rig, of: str = "") -> str:
    """What a family is, and of what."""
    words = QUANTITIES[rig.coordinate]
    return f"{words['T' if name in LINE else 'F'].word} of {of}{words[name].word}"


def _law(
    name: str,
    basis: Basis,
    model: Model,
    paths: Sequence[Path],
    factors: Sequence[Array | float],
    made: Callable[[tuple[Array, ...]], Direction],
) -> _Sought:
    """Small forces of each part of a law; a pull of the line is read by the cell as well."""
    way = -1.0 if name in LINE else 1.0
    forces = [stepped(path, _where(basis, path.by[name]) * np.reshape(way * factor, (-1, 1)))
              for path, factor in zip(paths, factors, strict=True)]  # fmt: skip

    def with_cell(rows: tuple[Array, ...]) -> list[Direction]:
        return [made(_read_by_cell(name, basis, model, paths, rows) if name in LINE else rows)]

    return _Sought(forces, with_cell)


def _read_by_cell(
    name: str, basis: Basis, model: Model, paths: Sequence[Path], rows: tuple[Array, ...]
) -> tuple[Array, ...]:
    """Rows of a pull of the line with what the cell reads of it."""
    rig, runs, _, fit = model
    for number, (row, run, path) in enumerate(zip(rows, runs, paths, strict=True)):
        cell = _cell(fit, number)
        if cell is not None:
            seen = _where(basis, path.read[name])
            own = slice(cell.first, cell.last)
            marks = (run.weights * fit.used[number])[own, None]
            row[own] -= path.cell * _amount(rig, runs) * seen * marks
    return rows


def _pushed(model: Model, paths: Sequence[Path], sought: Sequence[_Sought]) -> list[Direction]:
    """Families by what small forces, of unit size in the steps of the paths, do to the residuals of every run.

    All together, since the motion under them is the same; none where it cannot be followed.
    """
    rig, runs, values, fit = model
    amount = _amount(rig, runs)

    def block(number: int) -> Array | None:
        run, path = runs[number], paths[number]
        steps = amount * np.hstack([one.forces[number] for one in sought])
        try:
            found = pushed(rig.with_values(values[number]), run.run, path.edges, steps)
        except MetrologyError:
            return None
        if not found.valid:
            return None
        rows = np.concatenate([getattr(found, channel) for channel in run.channels])
        return np.asarray(-rows * (run.weights * fit.used[number])[:, None])

    with ThreadPoolExecutor(WORKERS) as pool:
        made = list(pool.map(block, range(len(runs))))
    rows = [one for one in made if one is not None]
    if len(rows) < len(made):
        return []
    ends = np.cumsum([one.forces[0].shape[1] for one in sought])[:-1]
    parts = zip(*(np.split(one, ends, axis=1) for one in rows), strict=True)
    return [found for one, part in zip(sought, parts, strict=True)
            for found in one.made(tuple(map(np.ascontiguousarray, part)))]  # fmt: skip


def _where(basis: Basis, by: Array) -> Array:
    """Parts of a law where its quantity is known, and nothing elsewhere, shape (n, q)."""
    known = np.isfinite(by)
    found = basis(np.where(known, by, 0.0))
    found[~known] = 0.0
    return found


def _of_thrust(model: Model, paths: Sequence[Path]) -> list[_Sought]:
    """Part of the thrust that changes with the time of a run, alike in all: it fades, or comes up slowly."""
    runs = model[1]
    if any(run.run.force is None for run in runs):
        return []
    factors = [thrust(run.run, path.by["t"] + run.run.t0) for run, path in zip(runs, paths, strict=True)]
    most = max(float(np.abs(one).max()) for one in factors)
    if not most > 0.0:
        return []
    knots = np.linspace(0.0, max(float(path.by["t"].max()) for path in paths), IN_RUN)
    found = _family("t", knots, model, paths, [one / most for one in factors], f" {THRUST}")
    return [replace(found, made=lambda rows: [replace(one, listed=(0,)) for one in found.made(rows)])]


def _by_run(model: Model, paths: Sequence[Path]) -> _Sought:
    """Force of the time of each run by itself: of what moves along with the module, or of what changes its thrust."""
    rig, runs, _, _ = model
    places = [np.linspace(0.0, float(np.max(path.by["t"])), IN_RUN) for path in paths]
    names = {f"t {number}@{at}": float(t) for number, knots in enumerate(places) for at, t in enumerate(knots)}
    words = QUANTITIES[rig.coordinate]
    effect = f"{words['F'].word} of {words['t'].word} {ALONE}"

    def made(own: tuple[Array, ...]) -> list[Direction]:
        rows = tuple(np.zeros((len(part), len(names))) for part in own)
        for number, part in enumerate(own):
            rows[number][:, number * IN_RUN : (number + 1) * IN_RUN] = part
        return [Direction(effect, names, _amount(rig, runs), rows, ways=tuple(names), listed=STRAIGHT)]

    forces = [stepped(path, hats(path.by["t"], knots)) for path, knots in zip(paths, places, strict=True)]
    return _Sought(forces, made)


def _cell(fit: Fit, at: int) -> Segment | None:
    """Where the readings of tension stand among those of a run; None where there are none."""
    return next((one for one in fit.problem.blocks[at].segments if one.name == "T"), None)


def _amount(rig: Rig, runs: Sequence[MeasuredRun]) -> float:
    """Force that cannot do much in these runs: it moves the free module by a reading's noise or so."""
    longest = max(run.run.end - run.run.t0 for run in runs)
    noise = min((run.noise["x"] for run in runs if "x" in run.channels), default=1e-4)
    return 0.2 * rig.m * noise / longest


def _curve(runs: Sequence[MeasuredRun], fit: Fit, paths: Sequence[Path], *, word: str) -> Direction | None:
    """Tension readings that are a curve of the tension."""
    parts = []
    for at, run in enumerate(runs):
        segment = _cell(fit, at)
        if segment is None:
            return None
        parts.append((at, run, segment, paths[at].readings[segment.first : segment.last]))
    pulling = np.concatenate([tension[tension > 0] for _, _, _, tension in parts])
    if len(pulling) < 20:
        return None
    knots = np.unique(np.quantile(pulling, np.linspace(0.0, 1.0, CURVE)))
    rows = []
    for at, _, segment, tension in parts:
        row = np.zeros((len(fit.residuals[at]), len(knots)))
        row[segment.first : segment.last] = -0.1 * hats(tension, knots) * (tension > 0)[:, None]
        rows.append(row * fit.used[at][:, None])
    amount = 0.1 * parts[0][1].noise["T"]
    names = {f"T@{at}": float(knot) for at, knot in enumerate(knots)}
    return Direction(f"{CURVED} of {word}", names, amount, tuple(rows), ways=tuple(names), listed=STRAIGHT)
