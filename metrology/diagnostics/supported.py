"""What the data support: values and covariance, by cause, of the unknowns that all blocks share."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from metrology.diagnosis import Source, Supported
from metrology.diagnostics.fit_parts import Parts, Shared, by_cause, parts_of
from metrology.diagnostics.judged import LIKELY, Judged
from metrology.diagnostics.likelihood import RANK, Noise, spread_out
from metrology.diagnostics.sets import NEGLIGIBLE
from metrology.diagnostics.subject import Array, Fit, Marks, Subject
from metrology.estimation.covariance import BLIND
from metrology.gum.matrix import root
from metrology.message import said
from metrology.noise import Colour

HELD = 0.1
"""Part of the information on a direction that the other runs hold at least where a run is compared with them in it.

What one run alone tells cannot differ from the others, and a step to where they would have it ends anywhere. A choice:
two runs alike hold half each, one of a third of the amplitude of the other a tenth."""
WITH_REMAINDER = ("unexplained", "explained in the main")
"""Verdicts that say that something is in the readings which no listed effect explains."""


def supported(judged: Judged, subject: Subject) -> Supported | None:
    """Joint distribution of k, c, effects and stated inputs under the models that the data do not rule out.

    Mean over the best model and those that do as well, weighted by their evidence; the covariance holds the difference
    between them (Hoeting et al., Statist. Sci. 14 (1999) 382, eq. 3 and 4). None where the model as stated stands.

    Notes
    -----
    Readings enter with the colour of their noise: H⁻¹·JᵀCJ·H⁻¹, C = (WᵀW)⁻¹ of the whitening filter W. What no model
    explains (λ > 1) is a part of its own, (λ − 1) times that of the readings: λ measures it where the unknowns act.
    """
    if judged.verdict in ("nothing missing", "not testable", "not finished"):
        return None
    last = judged.last
    entries = [entry for entry in last.problem.unknowns if "@" not in entry.name]
    names = tuple(entry.name for entry in entries)
    null = {one.name: one.null for cause in subject.candidates.values() for one in cause.parameters}
    start = np.array([null.get(name, math.nan) for name in names])
    noise = noise_of(judged, subject)
    members = [(last, 0.0), *judged.exchanged.values(), *(one[1:] for one in judged.kinds), *_models_without(judged)]
    found = [(parts_of(subject.finished(fit), names, start, noise), more) for fit, more in members]
    lawful = _with_laws(judged, names, found)
    # Listed effects that have no name since few readings are followed as well by any other are of any size, and k with
    # them.
    replaced = subject.is_scarce and judged.verdict == "unexplained" and judged.unlisted > LIKELY
    found = lawful if replaced and lawful else found + lawful
    low, high = (np.array([getattr(entry, side) for entry in entries]) for side in ("low", "high"))
    possible = [one for one in found if ((one[0].values >= low) & (one[0].values <= high)).all()]
    found = possible or found[:1]
    evidence = np.array([more for _, more in found])
    weights = np.exp(evidence - evidence.max())
    own = {size.name for name in last.effects for size in subject.candidates[name].parameters}
    effects = np.array([entry.name in own and entry.u is None for entry in entries])
    mean, sources = _mixed([one for one, _ in found], weights / weights.sum(), judged, effects, names, subject)
    base = parts_of(judged.base, names, np.full(len(names), math.nan), noise)
    by_base = np.sqrt(np.maximum(np.diag(base.total), 0.0))
    units = tuple(entry.unit for entry in entries)
    return Supported(names, units, _floats(mean), sources, _floats(base.values), _floats(by_base))


def noise_of(judged: Judged, subject: Subject) -> Noise:
    """Noise of the readings, with what no model explains: of its colours, or of the size that few readings tell."""
    return _level(judged.last, subject.floor) if subject.is_scarce else judged.view.noise


def spread(fit: Fit, noise: Noise) -> Array:
    """Standard uncertainty of every unknown of a fit, those of single blocks as well, shape (p,): noise and priors."""
    parts = by_cause(fit, np.eye(len(fit.theta)), fit.theta, noise)
    return np.asarray(np.sqrt(np.diag(parts.total + (noise.misfit - 1.0) * parts.readings)))


def _models_without(judged: Judged) -> Iterator[tuple[Fit, float]]:
    """Models without one of the effects, where the data leave that a probability, and their ln evidence."""
    own = frozenset(judged.last.effects)
    for fit in judged.others.values():
        weight = judged.weights.get(frozenset(fit.effects), 0.0)
        if weight > NEGLIGIBLE:
            yield fit, math.log(weight / judged.weights[own])


def _level(fit: Fit, floor: float) -> Noise:
    """White noise of the size that a fit to few readings leaves, that of their rounding at least."""
    level = max(math.sqrt(fit.chi_squared / max(fit.free, 1)), floor)
    channels = {one.name: Colour(level, np.array([1.0 / max(level, 1e-300)])) for block in fit.problem.blocks
                for one in block.segments}  # fmt: skip
    return Noise(channels)


def _with_laws(judged: Judged, names: Sequence[str], found: Sequence[tuple[Parts, float]]) -> list[tuple[Parts, float]]:
    """Models with an unlisted law: what it changes in the best one, it changes in those that do as well."""
    # The effect that a model has in another way than the best one; a law in its place is there already.
    otherwise = [None, *(name for name, _ in judged.exchanged), *(name for name, *_ in judged.kinds)]
    best, _ = found[0]
    return [(_with_law(model, best, names, law.values), more + law.log_evidence)
            for name, (model, more) in zip(otherwise, found, strict=False)
            for law in judged.lawful if name is None or name in law.kept]  # fmt: skip


def _with_law(model: Parts, best: Parts, names: Sequence[str], values: Mapping[str, tuple[float, float]]) -> Parts:
    """Parts of a model with what an unlisted law changes in the best one: its values, and what it adds to variances."""
    moved, total = model.values.copy(), best.total
    law = np.zeros_like(total)
    for at, name in enumerate(names):
        if name in values:
            value, u = values[name]
            moved[at] += value - best.values[at]
            more = u**2 - total[at, at]
            law[at, at] = more if more > RANK * total[at, at] else 0.0
    return replace(model, values=moved, law=law)


def _mixed(
    found: Sequence[Parts], weights: Array, judged: Judged, effects: Marks, names: Sequence[str], subject: Subject
) -> tuple[Array, tuple[Source, ...]]:
    """Mean over models and its covariance by cause, the difference between them a cause of its own."""
    last, misfit = judged.last, judged.misfit
    mean = np.asarray(sum(w * one.values for w, one in zip(weights, found, strict=True)))
    count = len(mean)
    readings = np.asarray(sum(w * one.readings for w, one in zip(weights, found, strict=True)))
    law = np.asarray(sum((w * one.law for w, one in zip(weights, found, strict=True)), np.zeros((count, count))))
    priors = {key: np.asarray(sum(w * one.priors.get(key, 0.0) for w, one in zip(weights, found, strict=True)))
              for key in dict.fromkeys(key for one in found for key in one.priors)}  # fmt: skip
    known = {entry.name: entry for entry in last.problem.unknowns if entry.u}
    per_run = {name.split("@")[0] for name in known if "@" in name}
    dof = max(last.free, 1.0)
    sources = [Source(name, kind, _rows(columns), dof=dof) for name, kind, columns in _apart(readings, effects)]
    elsewhere = []
    for (name, shared), columns in priors.items():
        if shared == "common" and name in known:
            entry = known[name]
            mean_of, u = float(entry.mean or 0.0), float(entry.u or 0.0)
            sources.append(Source(name, "common", _rows(columns), mean_of, u, entry.unit))
        elif shared == "per run" and name in per_run:
            blocks = len(last.problem.blocks)
            own = float(blocks - 1) if name in subject.scatters else None
            sources.append(Source(name, "per run", _rows(columns), dof=own))
        else:
            elsewhere.append(columns)
    if misfit > 1:
        sources.append(Source(said("model inadequacy"), "inadequacy", _rows(math.sqrt(misfit - 1) * root(readings))))
    if law.any():
        sources.append(Source(said("form of the unlisted law"), "inadequacy", _rows(root(law))))
    if subject.has_repeats and judged.verdict in WITH_REMAINDER:
        sources += _between(last, names, sources)
    if len(found) > 1:
        # Summed, not what the other causes leave of the whole: that is a small difference of large numbers.
        away = [math.sqrt(w) * _away(one, mean, priors) for w, one in zip(weights, found, strict=True)]
        away += elsewhere
        sources.append(Source(said("choice of the model"), "models", _rows(np.hstack(away))))
    return mean, tuple(sources)


def _away(one: Parts, mean: Array, priors: Mapping[tuple[str, Shared], Array]) -> Array:
    """What a model differs by from the mean: in its values, and in what every prior does."""
    return np.column_stack([one.values - mean, *(one.priors.get(key, 0.0) - own for key, own in priors.items())])


def _between(fit: Fit, names: Sequence[str], sources: Sequence[Source]) -> Iterator[Source]:
    """What the estimates differ by from run to run beyond what is covered already, where a model explains not all.

    A cause that nobody lists acts in another way in every run, or repeat, or release. Each is left out in turn (one
    step of the fit to the others): the jackknife's covariance (B − 1)/B·Σ(θ_b − θ̄)², with B − 1 degrees of freedom
    (Efron & Stein, Ann. Statist. 9 (1981) 586). Of it, parameter by parameter, what exceeds the other causes, as much
    larger as they are in the others alone: one run may tell far less of an unknown than another.
    """
    slopes = spread_out(fit)
    count = len(slopes)
    if count < 2:
        return
    shared = sorted(set.intersection(*(set(block.uses) for block in fit.problem.blocks)))
    whole = np.diag(_inverse(fit.information, fit.information))
    steps, spreads = [], []
    for block, part, residual, used in zip(fit.problem.blocks, slopes, fit.residuals, fit.used, strict=True):
        # What belongs to this block alone, such as its zero, is gone with it.
        others = [at for at in range(len(fit.theta)) if at in shared or at not in block.uses]
        kept = (part * used[:, None])[:, others]
        given = fit.information[np.ix_(others, others)]
        rest = _inverse(given - kept.T @ kept, given)
        moved = dict(zip(others, rest @ (kept.T @ residual), strict=True))
        wider = dict(zip(others, np.diag(rest) - whole[others], strict=True))
        steps.append([moved.get(at, 0.0) if (at := fit.index(name)) is not None else 0.0 for name in names])
        spreads.append([wider.get(at, 0.0) if (at := fit.index(name)) is not None else 0.0 for name in names])
    away = np.array(steps) - np.mean(steps, axis=0)
    covered = sum((np.square(np.array(one.columns)).sum(axis=1) for one in sources), np.zeros(len(names)))
    # What the noise makes of the same differences, over the variance of the whole fit: 1 where all tell as much.
    own = np.array([whole[at] if (at := fit.index(name)) is not None else 0.0 for name in names])
    noise = (count - 1) / count * np.maximum(spreads, 0.0).sum(axis=0)
    covered = covered * np.maximum(np.divide(noise, own, out=np.ones_like(own), where=own > 0), 1.0)
    variance = (count - 1) / count * np.square(away).sum(axis=0)
    excess = np.where(variance > covered, 1.0 - covered / np.where(variance > 0, variance, 1.0), 0.0)
    if excess.any():
        columns = math.sqrt((count - 1) / count) * (away * np.sqrt(excess)).T
        yield Source(
            said("differences between {count} runs", count=count), "inadequacy", _rows(columns), dof=float(count - 1)
        )


def _inverse(information: Array, whole: Array) -> Array:
    """Inverse of a part of some information, in the directions in which it is `HELD` of the whole at least."""
    size = np.sqrt(np.maximum(np.diag(whole), BLIND))
    values, vectors = np.linalg.eigh(whole / np.outer(size, size))
    known = values > RANK * values.max()
    # Coordinates in which the whole is one: each eigenvalue of a part is what it holds of the whole.
    ways = vectors[:, known] / np.sqrt(values[known]) / size[:, None]
    held, turned = np.linalg.eigh(ways.T @ information @ ways)
    ways = ways @ turned[:, held > HELD]
    return np.asarray(ways / held[held > HELD] @ ways.T)


def _apart(readings: Array, effects: Marks) -> Iterator[tuple[str, Literal["readings", "effects"], Array]]:
    """Part of the readings in what they would leave with the effects known, and what is not known of the effects.

    For normal variables a = a' + B·e with B = R_ae·R_ee⁻¹, and a' independent of e.
    """
    # An effect that moves no reading where it was found has no share in anything.
    effects = effects & (np.diag(readings) > 0)
    if not effects.any():
        yield said("readings"), "readings", root(readings)
        return
    of_effects = np.zeros((len(effects), int(effects.sum())))
    own = root(readings[np.ix_(effects, effects)])
    of_effects[effects] = own
    cross = readings[np.ix_(~effects, effects)]
    size = np.linalg.norm(own, axis=1)[:, None]
    of_effects[~effects] = np.linalg.lstsq(own / size, cross.T / size, rcond=None)[0].T
    left = readings - of_effects @ of_effects.T
    left[effects] = left[:, effects] = 0.0
    yield said("readings"), "readings", root(left)
    yield said("sizes of the effects"), "effects", of_effects


def _rows(columns: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(_floats(row) for row in columns)


def _floats(values: Array) -> tuple[float, ...]:
    return tuple(values.tolist())
