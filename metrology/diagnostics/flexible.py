"""Laws of any form: a smooth force of position, speed or time, a pull of the line, a curved reading of the cell."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from metrology.coordinate import QUANTITIES
from metrology.diagnosis import Missing
from metrology.diagnostics.force import thrust
from metrology.diagnostics.laws import Powers, hats, splines
from metrology.diagnostics.likelihood import orthonormal, spread_out
from metrology.diagnostics.subject import STRAIGHT, Array, Direction, Fit
from metrology.errors import MetrologyError
from metrology.estimation import MeasuredRun
from metrology.estimation.problem import Segment
from metrology.estimation.response import motion
from metrology.message import said
from metrology.rig import UNREAD, Rig, Run, pushed

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
FINE = 40
"""Steps of force in one natural period."""
WITHIN = 8
"""Places of the motion within each, over which a force is averaged: a line comes taut in the midst of a step."""
SEEN = 1e-5
"""Share of a combination of hats that the other unknowns have to leave, else it counts for nothing."""


Basis = Callable[[Array], Array]
"""Parts of a law by the quantity that it is a law of, shape (n,) → (n, q)."""


@dataclass(frozen=True)
class Path:
    """Where one run goes by the model: short steps of force, and what it may depend on at places within each.

    `edges`: when each step begins. `read`: what a pull of the line depends on at each reading of tension; `cell`: what
    the cell makes of a newton. NaN where the line is slack.
    """

    edges: Array
    by: Mapping[str, Array]
    readings: Array
    read: Mapping[str, Array]
    cell: float


def directions(rig: Rig, runs: Sequence[MeasuredRun], values: Sequence[dict[str, float]], fit: Fit) -> list[Direction]:
    """Families of small forces along the fitted motion, one hat or spline a column, and of curved tension readings.

    To first order a force f(x) acts as f at the places where the model is anyway; so each is added to the thrust
    as a function of time, and the motion followed again.
    """
    paths = [_path(rig, run, own) for run, own in zip(runs, values, strict=True)]
    if any(path is None for path in paths):
        return []
    known = [path for path in paths if path is not None]
    found = []
    for name in KNOTS:
        knots = _knots(name, known)
        if len(knots) > 2:
            found += _families(name, knots, (rig, runs, values, fit), known)
            powers = _powers(name, knots, (rig, runs, values, fit), known) if name in POWERS else None
            found += [] if powers is None else [powers]
    words = QUANTITIES[rig.coordinate]
    model = (rig, runs, values, fit)
    others = (_of_thrust(model, known), _by_run(model, known), _curve(runs, fit, known, word=words["T"].word))
    return [*found, *(one for one in others if one is not None)]


def _families(
    name: str,
    knots: Array,
    model: tuple[Rig, Sequence[MeasuredRun], Sequence[dict[str, float]], Fit],
    paths: Sequence[Path],
) -> list[Direction]:
    """Hats at these places, and finer ones where the quantity has them: a coarse hat is a sum of fine ones."""
    plainly = [1.0] * len(paths)
    if name not in FINER:
        plain = _family(name, knots, model, paths, plainly)
        return [] if plain is None else [plain]
    close = np.union1d(knots, np.linspace(knots[0], knots[-1], FINER[name]))
    fine = _family(name, close, model, paths, plainly)
    if fine is None:
        return []
    sums = hats(close, knots)
    values = {f"{name}@{at}": float(knot) for at, knot in enumerate(knots)}
    coarse = replace(fine, values=values, rows=tuple(part @ sums for part in fine.rows), ways=tuple(values))
    return [coarse, replace(fine, effect=f"fine {fine.effect}")]


def _path(rig: Rig, measured: MeasuredRun, values: dict[str, float]) -> Path | None:
    run, here = measured.run, rig.with_values(values)
    step = 2 * math.pi * math.sqrt(here.m / max(here.k, 1e-12)) / FINE
    begun = run.t0 if run.held_until is None else run.held_until
    count = int(np.clip((run.end - begun) / step, 50, 4000))
    edges = np.linspace(begun, run.end, count + 1)[:-1]
    within = (edges[1] - edges[0]) * (np.arange(WITHIN) + 0.5) / WITHIN
    places = (edges[:, None] + within).ravel()
    unread = {name: null for name, null in UNREAD.items() if name in values or name in rig.effects}
    whole = motion(rig, run, values)
    moved = _followed(rig, run, {**values, **unread}, places)
    if moved is None or whole is None:
        return None
    stamps = np.empty(0) if run.t_T is None else np.maximum(run.t_T - here.value("clock.T"), run.t0)
    read = _followed(rig, run, {**values, **unread}, stamps) if len(stamps) else {}
    if read is None:
        return None
    readings = np.concatenate([getattr(whole, name) for name in measured.channels])
    return Path(edges, {**moved, "t": places - run.t0}, readings, read, here.value("cell.gain") or 1.0)


def _followed(rig: Rig, run: Run, values: dict[str, float], t: Array) -> dict[str, Array] | None:
    """Position and velocity of the module, elongation and its rate at some times; these where the line is taut."""
    # Stamps before the start of a run stand at it, several of them where a clock is late.
    stamps, places = np.unique(t, return_inverse=True)
    moved = motion(rig, replace(run, t_x=stamps, t_v=stamps, t_T=stamps), values)
    if moved is None or moved.x is None or moved.v is None or moved.T is None:
        return None
    elongation = moved.x - rig.taut - values.get("free_length.shift", rig.value("free_length.shift"))
    taut = moved.T > 0 if rig.attachment == "tether" else np.ones(len(stamps), dtype=bool)
    e, r = (np.where(taut, one, np.nan) for one in (elongation, moved.v))
    return {name: one[places] for name, one in (("x", moved.x), ("v", moved.v), ("e", e), ("r", r))}


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
    name: str,
    knots: Array,
    model: tuple[Rig, Sequence[MeasuredRun], Sequence[dict[str, float]], Fit],
    paths: Sequence[Path],
    factors: Sequence[Array | float],
) -> Direction | None:
    """Hats or splines of one quantity; `factors`: what they are multiplied by along each run."""
    parts = _splines if name in LINE else hats
    rows = _columns(name, partial(parts, knots=knots), model, paths, factors)
    if rows is None:
        return None
    values = {f"{name}@{at}": float(knot) for at, knot in enumerate(knots)}
    return Direction(_word(name, model[0]), values, _amount(model[0], model[1]), rows, ways=tuple(values),
                     listed=(1,) if name in LINE else STRAIGHT, straight=LINE.get(name, {}))  # fmt: skip


def _powers(
    name: str,
    knots: Array,
    model: tuple[Rig, Sequence[MeasuredRun], Sequence[dict[str, float]], Fit],
    paths: Sequence[Path],
) -> Direction | None:
    """Sums of powers of a pull of the line."""
    most = float(np.abs(knots).max())
    if not most > 0.0:
        return None
    powers = Powers(most, POWERS[name], EVEN[name])
    rows = _columns(name, powers.columns, model, paths, [1.0] * len(paths))
    if rows is None:
        return None
    return powers.direction(_word(name, model[0], "powers of "), _amount(*model[:2]), rows, KNOTS[name], LINE[name])


def _word(name: str, rig: Rig, of: str = "") -> str:
    """What a family is, and of what."""
    words = QUANTITIES[rig.coordinate]
    return f"{words['T' if name in LINE else 'F'].word} of {of}{words[name].word}"


def _columns(
    name: str,
    basis: Basis,
    model: tuple[Rig, Sequence[MeasuredRun], Sequence[dict[str, float]], Fit],
    paths: Sequence[Path],
    factors: Sequence[Array | float],
) -> tuple[Array, ...] | None:
    """What a small force of each part of a law does to the residuals of every run; none where no motion follows."""
    way = -1.0 if name in LINE else 1.0

    def pulled(number: int, path: Path) -> Array:
        return np.asarray(_where(basis, path.by[name]) * np.reshape(way * factors[number], (-1, 1)))

    rows = _pushed(model, paths, [pulled(number, path) for number, path in enumerate(paths)])
    if rows is None or name not in LINE:
        return rows
    rig, runs, _, fit = model
    for number, (row, run, path) in enumerate(zip(rows, runs, paths, strict=True)):
        cell = _cell(fit, number)
        if cell is not None:
            seen = _where(basis, path.read[name])
            own = slice(cell.first, cell.last)
            marks = (run.weights * fit.used[number])[own, None]
            row[own] -= path.cell * _amount(rig, runs) * seen * marks
    return rows


def _pushed(
    model: tuple[Rig, Sequence[MeasuredRun], Sequence[dict[str, float]], Fit],
    paths: Sequence[Path],
    forces: Sequence[Array],
) -> tuple[Array, ...] | None:
    """What small forces, of unit size at the places of the paths, do to the residuals of every run, shape (n, q)."""
    rig, runs, values, fit = model
    amount = _amount(rig, runs)

    def block(number: int) -> Array | None:
        run, path = runs[number], paths[number]
        steps = amount * forces[number].reshape(len(path.edges), WITHIN, -1).mean(axis=1)
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
    return tuple(rows) if len(rows) == len(made) else None


def _where(basis: Basis, by: Array) -> Array:
    """Parts of a law where its quantity is known, and nothing elsewhere, shape (n, q)."""
    known = np.isfinite(by)
    found = basis(np.where(known, by, 0.0))
    found[~known] = 0.0
    return found


def _of_thrust(
    model: tuple[Rig, Sequence[MeasuredRun], Sequence[dict[str, float]], Fit], paths: Sequence[Path]
) -> Direction | None:
    """Part of the thrust that changes with the time of a run, alike in all: it fades, or comes up slowly."""
    runs = model[1]
    if any(run.run.force is None for run in runs):
        return None
    factors = [thrust(run.run, path.by["t"] + run.run.t0) for run, path in zip(runs, paths, strict=True)]
    most = max(float(np.abs(one).max()) for one in factors)
    if not most > 0.0:
        return None
    knots = np.linspace(0.0, max(float(path.by["t"].max()) for path in paths), IN_RUN)
    found = _family("t", knots, model, paths, [one / most for one in factors])
    return None if found is None else replace(found, effect=f"{found.effect} {THRUST}", listed=(0,))


def _by_run(
    model: tuple[Rig, Sequence[MeasuredRun], Sequence[dict[str, float]], Fit], paths: Sequence[Path]
) -> Direction | None:
    """Force of the time of each run by itself: of what moves along with the module, or of what changes its thrust."""
    rig, runs, _, _ = model
    places = [np.linspace(0.0, float(np.max(path.by["t"])), IN_RUN) for path in paths]
    own = _pushed(model, paths, [hats(path.by["t"], knots) for path, knots in zip(paths, places, strict=True)])
    if own is None:
        return None
    names = {f"t {number}@{at}": float(t) for number, knots in enumerate(places) for at, t in enumerate(knots)}
    rows = tuple(np.zeros((len(part), len(names))) for part in own)
    for number, part in enumerate(own):
        rows[number][:, number * IN_RUN : (number + 1) * IN_RUN] = part
    words = QUANTITIES[rig.coordinate]
    effect = f"{words['F'].word} of {words['t'].word} {ALONE}"
    return Direction(effect, names, _amount(rig, runs), rows, ways=tuple(names), listed=STRAIGHT)


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


# ---- what they say ------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Form:
    """One family, judged: χ² that it would remove, its degrees of freedom, and the amounts with their uncertainty."""

    family: str
    """What it is, and of what: 'force of velocity', 'fine force of time', 'curve of tension'."""
    chi_squared: float
    dof: int
    p_value: float
    at: Array
    amounts: Array
    u: Array

    @property
    def quantity(self) -> str:
        """What it depends on."""
        return self.family.removeprefix("fine ").partition(" of ")[2]

    @property
    def kind(self) -> str:
        """Whether it is a force, a torque, or a curved reading."""
        return self.family.removeprefix("fine ").partition(" of ")[0]


def forms(fit: Fit, families: Sequence[Direction]) -> list[Form]:
    """Scores of all families, in units of the noise that the readings themselves show."""
    level, off, explained = _level(fit), fit.covariance @ fit.gradient, _explained(fit)
    return [_form(fit, family, (off, explained), level) for family in families]


def _explained(fit: Fit) -> Array:
    """Orthonormal columns of all that the unknowns and their priors explain, shape (n + p, p).

    The products JᵀJ and JᵀG keep half of the digits, of which a combination that the unknowns explain but for 1e-5
    has none left.
    """
    J = np.vstack([*spread_out(fit), np.diag(np.sqrt(fit.problem.precision))])
    return orthonormal(J)


def _gathered(fit: Fit, rows: Sequence[Array]) -> Array:
    """JᵀG over all blocks, shape (p, …)."""
    total = np.zeros((len(fit.theta), *rows[0].shape[1:]))
    for block, slope, part in zip(fit.problem.blocks, fit.slopes, rows, strict=True):
        total[np.array(block.uses)] += slope.T @ part
    return total


def _form(fit: Fit, family: Direction, at: tuple[Array, Array], level: float) -> Form:
    from scipy.special import gammaincc

    off, explained = at
    G = np.vstack([*family.rows, np.zeros((len(off), len(family.values)))])
    b = _gathered(fit, family.rows).T @ off - np.asarray(
        sum(part.T @ own for part, own in zip(family.rows, fit.residuals, strict=True))
    )
    size = np.maximum(np.linalg.norm(G, axis=0), 1e-150)
    left = G / size - explained @ (explained.T @ (G / size))
    _, own, ways = np.linalg.svd(left, full_matrices=False)
    values, vectors = own**2, ways.T
    seen = values > max(SEEN, 1e-6 * float(values.max(initial=0.0)))
    turned = vectors[:, seen].T @ (b / size)
    chi_squared = float(np.sum(turned**2 / values[seen])) / level**2
    dof = int(seen.sum())
    p = float(gammaincc(dof / 2, chi_squared / 2)) if dof else 1.0
    amounts = vectors[:, seen] @ (turned / values[seen]) / size * family.amount
    u = level * np.sqrt(np.sum(vectors[:, seen] ** 2 / values[seen], axis=1)) / size * family.amount
    return Form(family.effect, chi_squared, dof, p, np.array(list(family.values.values())), amounts, u)


def _level(fit: Fit) -> float:
    """Noise of the readings over what is stated, from one reading to the next."""
    parts = [np.diff(part[used]) for part, used in zip(fit.residuals, fit.used, strict=True)]
    squares = np.concatenate(parts) ** 2
    # Without the largest: readings on either side of a channel's end, or of a gap, are not neighbours.
    return math.sqrt(max(float(np.mean(np.minimum(squares, 50.0))) / 2, 1e-12))


def missing(found: Sequence[Form]) -> Missing | None:
    """Force that is missing, as a function of what explains most of it; None where none of them stands out."""
    seen = [one for one in found if one.dof and len(one.at) > 2]
    if not seen:
        return None
    best = min(seen, key=lambda one: (one.p_value, -one.chi_squared / one.dof))
    excess = {one.quantity: 0.0 for one in seen}
    for one in seen:
        excess[one.quantity] = max(one.chi_squared - one.dof, excess[one.quantity])
    total = max(excess.values()) or 1.0
    by = best.quantity
    what, unit = ("reading", UNITS[by]) if best.kind == CURVED else (best.kind, UNITS[best.kind])
    largest = int(np.argmax(np.abs(best.amounts) / np.maximum(best.u, 1e-300)))
    text = (
        "A {what} of {size:.2g} {unit} (u = {u:.1g} {unit}) is missing where the {by} is {at:.3g} {by_unit}; what is "
        "missing depends most on {by}."
    )
    sentence = said(
        text, what=what, size=float(best.amounts[largest]), unit=unit, u=float(best.u[largest]), by=by,
        at=float(best.at[largest]), by_unit=UNITS[by],
    )  # fmt: skip
    return Missing(
        said("missing {what}", what=what), unit, by, UNITS[by], tuple(best.at.tolist()), tuple(best.amounts.tolist()),
        tuple(best.u.tolist()), {name: value / total for name, value in excess.items()}, sentence,
    )  # fmt: skip
