"""One likelihood for a model and all candidate causes: coloured noise, priors, and what even the full list leaves.

readings = model(inputs, effects) + misfit + noise. Around a fit everything is linear: the evidence of every set of
effects is then closed-form (`sets`). The noise is whitened channel by channel (`noise.colour`). What the model with
*all* candidates still leaves, the misfit, is measured where the unknowns act and enters their covariance as one factor
λ (White, Econometrica 50 (1982) 1, with one mean factor in place of a matrix).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from metrology.diagnostics.candidate import Candidate
from metrology.diagnostics.subject import Array, Blocks, Direction, Fit, Marks, Slow
from metrology.estimation.covariance import spread
from metrology.estimation.priors import WIDER
from metrology.noise import PLACES, WHITE, Colour, colour, power_of

Places = NDArray[np.int64]
RANK = 1e-9
"""Part of a column below which what others leave of it is rounding."""
RESOLVED = 1e-5
"""Part of a column below which what others leave of it is not resolved: columns are differences of two motions, which
agree to half of their digits."""
CHUNK = 4096
"""Rows of a matrix that are worked on at a time."""
ABOUT = 8
"""Bins of the spectrum either side of a line over which the noise about it is taken: 30 degrees of freedom, a quarter;
a mode of a clamp or frame with 1 % of damping is as wide where a record holds hundreds of its periods."""


@dataclass(frozen=True)
class Noise:
    """Colour of every channel, and the factor of the misfit.

    Parameters
    ----------
    channels : mapping of str to Colour
        By name of the channel; white of unit size where one is not named.
    misfit : float
        λ ≥ 1: mean square, over that of the noise, of what the full list leaves where the unknowns act.
    """

    channels: Mapping[str, Colour]
    misfit: float = 1.0
    narrow: tuple[tuple[slice, Array, float], ...] = ()
    """Rows of a record, orthonormal whitened columns about a frequency in them, and its noise there over elsewhere."""

    def whitened(self, fit: Fit, rows: Blocks, used: Sequence[Marks]) -> Array:
        """Rows of all blocks, filtered channel by channel and stacked, shape (n, …); zero where `used` says so."""
        found = []
        for block, part, marks in zip(fit.problem.blocks, rows, used, strict=True):
            kept = part * (marks if part.ndim == 1 else marks[:, None])
            for segment in block.segments:
                one = self.channels.get(segment.name, WHITE)
                found.append(one.whitened(kept[segment.first : segment.last]))
        whole = np.concatenate(found)
        for rows_of, Q, factor in self.narrow:
            whole[rows_of] -= (1.0 - 1.0 / math.sqrt(factor)) * (Q @ (Q.T @ whole[rows_of]))
        return whole


def noise(fit: Fit, residuals: Blocks, floor: float = 0.0, taken: Array | None = None) -> Noise:
    """Colour of every channel from residuals, all blocks together.

    `taken`: orthonormal columns that were taken out of them, shape (n, q), readings stacked.
    """
    parts: dict[str, list[Array]] = {}
    along: dict[str, list[Array]] = {}
    stacked = iter(_segments(fit))
    for block, part, used in zip(fit.problem.blocks, residuals, fit.used, strict=True):
        for segment in block.segments:
            rows = slice(segment.first, segment.last)
            parts.setdefault(segment.name, []).append(part[rows] * used[rows])
            here = next(stacked)
            if taken is not None:
                along.setdefault(segment.name, []).append(taken[here])
    return Noise({name: colour(own, floor, along.get(name, ())) for name, own in parts.items()})


@dataclass(frozen=True)
class Column:
    """What a candidate adds to the straight line: its columns, and what it costs to have them.

    Parameters
    ----------
    effect : str
        Candidate, or the unlisted law.
    rows : ndarray, shape (n + p, q)
        Change of the stacked residuals (readings, then priors) for one unit of each coefficient.
    signed : bool
        Whether its size may have either sign; else the first coefficient, its amount, is not negative.
    direction : Direction or None
        The trial that it came from; None for an effect that the fit carries.
    """

    effect: str
    rows: Array
    signed: bool
    direction: Direction | None = None


@dataclass(frozen=True)
class Line:
    """A fit as a straight line in its unknowns and in the sizes of all candidates.

    Parameters
    ----------
    fit : Fit
        Where the line touches.
    noise : Noise
        By which it is weighted.
    base : ndarray, shape (n + p, b)
        Columns of the unknowns that belong to no effect; the rows after n are the priors.
    residual : ndarray, shape (n + p,)
        Residuals with all effects at their null, by the straight line.
    columns : tuple of Column
        Effects that the fit carries first, then the candidates in all their shapes.
    count : int
        Readings with weight.
    """

    fit: Fit
    noise: Noise
    base: Array
    residual: Array
    columns: tuple[Column, ...]
    count: int

    @cached_property
    def basis(self) -> Array:
        """Orthonormal columns that span the base."""
        return orthonormal(self.base)

    @cached_property
    def explained(self) -> tuple[Span, Array]:
        """Span of everything in the line, and the residual beside it."""
        return self.explained_with(())

    def explained_with(self, extra: Sequence[Array]) -> tuple[Span, Array]:
        """Return the same of everything in the line together with further columns, shape (n + p, q) each."""
        taken = spanned((self.base, *(one.rows for one in self.columns), *extra))
        return taken, self.residual - taken.part(self.residual)

    @cached_property
    def spectra(self) -> tuple[Spectrum, ...]:
        """Spectra of the residual beside all that is in the line, for each channel of each block."""
        return _spectra(self.fit, *self.explained)

    @cached_property
    def left(self) -> tuple[Array, ...]:
        """Rows of each column less their part within the base."""
        if not self.columns:
            return ()
        widths = np.cumsum([one.rows.shape[1] for one in self.columns])[:-1]
        whole = np.asfortranarray(np.hstack([one.rows for one in self.columns]))
        return tuple(np.split(self._reduced(whole), widths, axis=1))

    def with_misfit(self, factor: float) -> Line:
        """Return the same line with another λ: readings weigh less by its root, priors as before."""
        weight = np.ones(len(self.residual))
        weight[: len(weight) - len(self.fit.theta)] = math.sqrt(self.noise.misfit / factor)
        columns = tuple(replace(one, rows=weight[:, None] * one.rows) for one in self.columns)
        by = replace(self.noise, misfit=factor)
        return replace(
            self, noise=by, base=weight[:, None] * self.base, residual=weight * self.residual, columns=columns
        )

    def beside(self, rows: Array) -> Array:
        """What the base leaves of rows."""
        return self._reduced(np.array(rows))

    def _reduced(self, rows: Array) -> Array:
        """Rows less their part within the base, in place; twice, since rounding leaves some of it."""
        for _ in range(2):
            amounts = self.basis.T @ rows
            for first in range(0, len(rows), CHUNK):
                rows[first : first + CHUNK] -= self.basis[first : first + CHUNK] @ amounts
        return rows


@dataclass(frozen=True)
class Spectrum:
    """Of one record: power of what is left, and what the columns that were taken out of white noise had of it."""

    left: Array
    absorbed: Array


@dataclass(frozen=True)
class Span:
    """Orthonormal columns that span others, formed for some rows at a time: all at once they fill gigabytes.

    Parameters
    ----------
    columns : tuple of ndarray, shapes (n, q)
        What is spanned.
    turn : ndarray, shape (Σq, r)
        The orthonormal columns as sums of them.
    """

    columns: tuple[Array, ...]
    turn: Array

    @property
    def width(self) -> int:
        """Number r of orthonormal columns."""
        return int(self.turn.shape[1])

    def rows(self, at: slice) -> Array:
        """Some rows, turned among themselves: sums of squares of what is linear in each column stay as they are.

        As many columns as are not zero in these rows, where that is fewer: what belongs to one block is zero elsewhere.
        """
        seen, part = _seen([one[at] for one in self.columns])
        if len(seen) >= self.width:
            return np.asarray(part @ self.turn[seen])
        return np.asarray(part @ np.asarray(np.linalg.qr(self.turn[seen].T, mode="r")).T)

    def part(self, vector: Array) -> Array:
        """Part of a vector, shape (n,), within the span."""
        amounts = self.turn @ (self.turn.T @ np.concatenate([one.T @ vector for one in self.columns]))
        ends = np.cumsum([one.shape[1] for one in self.columns])[:-1]
        parts = zip(self.columns, np.split(amounts, ends), strict=True)
        return np.asarray(sum((one @ amount for one, amount in parts), np.zeros(len(vector))))


def pieces(columns: Sequence[Array]) -> Iterator[list[Array]]:
    """Columns of equal length, `CHUNK` rows at a time."""
    for first in range(0, len(columns[0]), CHUNK):
        yield [one[first : first + CHUNK] for one in columns]


def triangle(columns: Sequence[Array]) -> Array:
    """R of a QR factorisation of columns side by side, some rows at a time, of those that are not zero there."""
    width, parts = sum(one.shape[1] for one in columns), []
    for seen, part in map(_seen, pieces(columns)):
        own = np.linalg.qr(part, mode="r")
        parts.append(np.zeros((len(own), width)))
        parts[-1][:, seen] = own
    lacking = min(len(columns[0]), width) - sum(map(len, parts))
    whole = np.vstack([*parts, np.zeros((max(lacking, 0), width))])
    return np.asarray(whole if len(parts) == 1 else np.linalg.qr(whole, mode="r"))


def _seen(columns: Sequence[Array]) -> tuple[Places, Array]:
    """Which of some columns side by side are not zero, and these: every block has columns of its own."""
    masks = [one.any(axis=0) for one in columns]
    parts = [one if mask.all() else one[:, mask] for one, mask in zip(columns, masks, strict=True)]
    return np.flatnonzero(np.concatenate(masks)), np.hstack(parts)


def spanned(columns: tuple[Array, ...]) -> Span:
    """Span of columns, as `orthonormal` finds it."""
    from scipy.linalg import solve_triangular

    width = sum(one.shape[1] for one in columns)
    gram = np.zeros((width, width))
    for seen, part in map(_seen, pieces(columns)):
        gram[np.ix_(seen, seen)] += part.T @ part
    turn = _turn(gram)
    squares = np.zeros((turn.shape[1], turn.shape[1]))
    for seen, part in map(_seen, pieces(columns)):
        # In as few columns as are not zero there.
        ways, fewer = np.linalg.qr(turn[seen].T)
        once = part @ fewer.T
        squares += ways @ (once.T @ once) @ ways.T
    lower = np.linalg.cholesky(squares)
    return Span(columns, np.asarray(solve_triangular(lower, turn.T, lower=True).T))


def orthonormal(columns: Array) -> Array:
    """Orthonormal columns with the same span; those that add nothing are left out.

    By the eigenvectors of the Gram matrix (Stathopoulos & Wu, SIAM J. Sci. Comput. 23 (2002) 2165), whose rounding is
    far below `RESOLVED`², then once more by its Cholesky factor: less than half of the time of a QR factorisation.
    """
    from scipy.linalg import solve_triangular

    once = columns @ _turn(columns.T @ columns)
    lower = np.linalg.cholesky(once.T @ once)
    return np.asarray(solve_triangular(lower, once.T, lower=True, overwrite_b=True, check_finite=False).T)


def _turn(gram: Array) -> Array:
    """Sums of columns with this Gram matrix that are orthonormal, but for rounding, shape (q, r)."""
    size = np.sqrt(np.diag(gram))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0)
    squares, ways = np.linalg.eigh(scale[:, None] * gram * scale)
    seen = squares > RESOLVED**2
    return np.asarray(scale[:, None] * ways[:, seen] / np.sqrt(squares[seen]))


def line(
    fit: Fit, candidates: Mapping[str, Candidate], directions: Sequence[Direction], by: Noise, used: Sequence[Marks]
) -> Line:
    """Straight line through a fit with all candidate directions, in the metric of the noise.

    Parameters
    ----------
    fit : Fit
        Model with the effects that it carries.
    candidates : mapping of str to Candidate
        The table.
    directions : sequence of Direction
        What the other candidates would do.
    by : Noise
        Colour and misfit.
    used : sequence of ndarray of bool
        Readings that count.
    """
    root = 1.0 / math.sqrt(by.misfit)
    J = root * by.whitened(fit, spread_out(fit), used)
    r = root * by.whitened(fit, fit.full, used)
    stated = {name: stated_places(fit, candidates[name]) for name in fit.effects}
    precision = np.sqrt(fit.problem.precision)
    # An input that the fit has freed is known as stated where its effect is left out.
    precision[[at for places in stated.values() for at in places]] *= WIDER
    J = np.vstack([J, np.diag(precision)])
    r = np.concatenate([r, precision * (fit.theta - fit.problem.mean)])
    own, columns = np.zeros(len(fit.theta), dtype=bool), []
    for name in fit.effects:
        places, null = effect_places(fit, candidates[name])
        own[places] = True
        rows = np.hstack([J[:, places], *(_freed(len(r), len(precision), at, precision) for at in stated[name])])
        columns.append(Column(name, rows, candidates[name].signed))
        # An effect that goes with a power of its size is gone along its slope after one part in that power.
        powers = np.array([_power(fit, place, candidates[name]) for place in places])
        seen = powers > 0
        r = r + rows[:, : len(places)][:, seen] @ ((null - fit.theta[places])[seen] / powers[seen])
    for one in directions:
        data = root * by.whitened(fit, tuple(part.reshape(len(part), -1) for part in one.rows), used)
        columns.append(_tried(one, data, precision, signed=candidates[one.effect].signed))
    count = int(sum(marks.sum() for marks in used))
    return Line(fit, by, J[:, ~own], r, tuple(columns), count)


def spread_out(fit: Fit) -> Blocks:
    """Derivatives of every block by all unknowns, shape (n, p) each."""
    found = []
    for block, part in zip(fit.problem.blocks, fit.slopes, strict=True):
        wide = np.zeros((len(part), len(fit.theta)))
        wide[:, np.array(block.uses)] = part
        found.append(wide)
    return tuple(found)


def effect_places(fit: Fit, one: Candidate) -> tuple[list[int], Array]:
    """Unknowns that belong to an effect and would not be sought without it, and their nulls."""
    null = {size.name: size.null for size in one.parameters}
    own = {size.name for size in one.parameters if size.own}
    places = [
        at
        for at, entry in enumerate(fit.problem.unknowns)
        if (name := entry.name.split("@")[0]) in null and (entry.u is None or name in own)
    ]
    return places, np.array([null[fit.problem.unknowns[at].name.split("@")[0]] for at in places])


def base_places(fit: Fit, candidates: Mapping[str, Candidate]) -> list[int]:
    """Unknowns that belong to no effect: the columns of the base of a line, in their order."""
    own = {place for name in fit.effects for place in effect_places(fit, candidates[name])[0]}
    return [at for at in range(len(fit.theta)) if at not in own]


def stated_places(fit: Fit, one: Candidate) -> list[int]:
    """Inputs with a stated uncertainty that an effect frees: what it adds is a shift of the mean of their prior."""
    names = {size.name for size in one.parameters}
    return [at for at, entry in enumerate(fit.problem.unknowns) if entry.name in names and entry.u is not None]


def _freed(count: int, priors: int, at: int, precision: Array) -> Array:
    """Column of such a shift: no reading sees it."""
    found = np.zeros((count, 1))
    found[count - priors + at] = -precision[at]
    return found


def _power(fit: Fit, place: int, one: Candidate) -> int:
    """Power of a size with which its effect grows; 0 for a shape."""
    name = fit.problem.unknowns[place].name.split("@")[0]
    return next((size.power for size in one.parameters if size.name == name and not size.shape), 0)


def _tried(one: Direction, data: Array, precision: Array, *, signed: bool) -> Column:
    if one.stated is not None:
        # Freedom of a prior is a shift of its mean, which no reading sees.
        data = np.zeros((len(data), 1))
    priors = np.zeros((len(precision), data.shape[1]))
    if one.stated is not None:
        priors[one.stated, 0] = -one.amount * precision[one.stated]
    rows = np.vstack([data, priors])
    return Column(one.effect, rows, signed or rows.shape[1] > 1, one)


# ---- what the full list leaves ------------------------------------------------------------------------------------
def misfit(full: Line, sought: Array, explained: tuple[Span, Array] | None = None) -> float:
    """λ: mean square of what the full list leaves, where the unknowns act, over that of the noise; 1 at least.

    With orthonormal whitened columns Q of the unknowns and the periodogram P̂ of the residual,
    λ = mean over k of Σ_f |Q_k|²·P̂ / Σ_f |Q_k|². P̂ is smoothed over as many bins either side as unknowns were fitted,
    and raised by the degrees of freedom that they took there.

    Parameters
    ----------
    full : Line
        With every candidate, weighted with a misfit of 1.
    sought : ndarray, shape (n + p, m)
        Columns of the unknowns and effects about which something is to be said.
    explained : (Span, ndarray of shape (n + p,)), optional
        Span of a longer list than the line's own, and the residual beside it.
    """
    taken, _ = explained or full.explained
    spectra = _spectra(full.fit, *explained) if explained else full.spectra
    Q = orthonormal(sought)
    over = power = 0.0
    for rows, spectrum in zip(_segments(full.fit), spectra, strict=True):
        weight, here = _spectral(Q[rows], spectrum, taken.width)
        over += float((weight * here).sum())
        power += float(weight.sum())
    # Known to some per cent; rounded, it is the same on every processor.
    return max(1.0, round(over / max(power, 1e-300), PLACES))


def narrow(full: Line, lines: Sequence[Array], whole: float) -> tuple[tuple[slice, Array, float], ...]:
    """Where the noise of a record about a line that is tried, or carried, is stronger than a smooth colour says.

    A band of noise is no line: what it leaves beside the line's frequency says how much of the line it makes itself.
    A record has noise of its own: a clamp that rings in one run does not in the others.

    Parameters
    ----------
    full : Line
        With every candidate, weighted with a misfit of 1.
    lines : sequence of ndarray, shape (n + p, q)
        Columns of each line.
    whole : float
        Misfit where all unknowns act.
    """
    found = []
    for part, spectrum in zip(_segments(full.fit), full.spectra, strict=True) if lines else ():
        own = np.zeros((part.stop - part.start, 0))
        for rows in lines:
            columns = rows[part][:, rows[part].any(axis=0)]
            if not columns.shape[1]:
                continue
            weight, here = _spectral(orthonormal(columns), spectrum, ABOUT)
            factor = round(float((weight * here).sum() / weight.sum()), PLACES) / whole
            if factor > 1.0:
                about = _about(columns)
                about = orthonormal(about - own @ (own.T @ about))
                own = np.hstack([own, about])
                found.append((part, about, factor))
    return tuple(found)


def _about(rows: Array) -> Array:
    """Columns of a line in one record and of those within one bin of the spectrum, which grow along it."""
    along = np.linspace(-1.0, 1.0, len(rows))[:, None]
    return np.hstack([rows, along * rows, along**2 * rows])


def _segments(fit: Fit) -> list[slice]:
    """Rows of each channel of each block within the stack."""
    found, first = [], 0
    for block in fit.problem.blocks:
        for segment in block.segments:
            found.append(slice(first, first + segment.last - segment.first))
            first = found[-1].stop
    return found


def _spectra(fit: Fit, taken: Span, left: Array) -> tuple[Spectrum, ...]:
    """Spectra of what is left, and of what was taken, of each channel of each block."""
    records = ((left[rows, None], taken.rows(rows)) for rows in _segments(fit))
    return tuple(Spectrum(*(power_of(columns) / len(columns) for columns in record)) for record in records)


def _spectral(Q: Array, record: Spectrum, bins: int) -> tuple[Array, Array]:
    """Power of the unknowns by frequency in one record, and smoothed power of what is left."""
    weight = power_of(Q)
    width = min(2 * max(bins, 1) + 1, len(record.left))
    kernel = np.ones(width)
    inside = np.convolve(np.ones(len(record.left)), kernel, "same")
    smooth = np.convolve(record.left, kernel, "same") / inside
    # Of the two degrees of freedom of a bin, those that the fit took are not in what it leaves.
    free = 1.0 - np.convolve(record.absorbed, kernel, "same") / inside
    return weight, smooth / np.maximum(free, 0.3)


def estimated(fit: Fit, by: Noise, used: Sequence[Marks]) -> tuple[Array, Array]:
    """Unknowns of a fit in the metric of the noise, by one step on the straight line, and their covariance."""
    root, precision = 1.0 / math.sqrt(by.misfit), np.sqrt(fit.problem.precision)
    J = np.vstack([root * by.whitened(fit, spread_out(fit), used), np.diag(precision)])
    r = np.concatenate([root * by.whitened(fit, fit.full, used), precision * (fit.theta - fit.problem.mean)])
    covariance = spread(J)
    return fit.theta - covariance @ (J.T @ r), covariance


def slow_motion(fit: Fit, by: Noise, used: Sequence[Marks], every: Sequence[Slow]) -> tuple[Array, list[Array]]:
    """Ln evidence over none for a slow motion of the readings: of a steady drift, and of all that is fitted for it.

    A steady drift has one coefficient in place of four or more; each has the price of unit information (½·ln n). With
    them the slow motion of each block, a value a term.
    """
    theta, spread = estimated(fit, by, used)
    evidence, motions = np.zeros(2), []
    for one in every:
        rows = one.places(fit)
        level, price = theta[rows], 0.5 * math.log(one.count)
        within = spread[np.ix_(rows, rows)] + one.rounding**2 * np.eye(len(rows))
        evidence += (
            0.5 * level[0] ** 2 / within[0, 0] - price,
            0.5 * level @ np.linalg.solve(within, level) - len(rows) * price,
        )
        motions.append(level)
    return evidence, motions


# ---- nonlinear fits compared --------------------------------------------------------------------------------------
def weighted(fit: Fit, by: Noise, used: Sequence[Marks]) -> float:
    """Least cost of a fit in the metric of the noise: χ² / λ of the readings, and what the priors cost.

    The fit was found without the colour: one step on the straight line leads to the optimum with it. What such a step
    promises without the colour as well is not believed: the search has tried it.
    """
    root = 1.0 / math.sqrt(by.misfit)
    precision = np.sqrt(fit.problem.precision)
    J = np.vstack([root * by.whitened(fit, spread_out(fit), used), np.diag(precision)])
    r = np.concatenate([root * by.whitened(fit, fit.full, used), precision * (fit.theta - fit.problem.mean)])
    free = (fit.theta > fit.problem.low) & (fit.theta < fit.problem.high)
    whole = float(r @ r)
    return min(_left(J[:, free], r) + fit.unfinished, whole)


def _left(columns: Array, r: Array) -> float:
    """Sum of squares that columns leave of r, as `orthonormal` has their span, without forming it."""
    size = np.linalg.norm(columns, axis=0)
    R = triangle([columns[:, size > 0] / size[size > 0], r[:, None]])
    inside = R[:-1, -1]
    ways, seen, _ = np.linalg.svd(R[:-1, :-1])
    return float(R[-1, -1] ** 2) + float(inside @ inside) - float(np.sum((ways[:, seen > RESOLVED].T @ inside) ** 2))


def common(fits: Sequence[Fit]) -> tuple[Marks, ...]:
    """Readings that carry weight in all of them."""
    return tuple(np.logical_and.reduce(marks) for marks in zip(*(one.used for one in fits), strict=True))
