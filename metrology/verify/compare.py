"""A fitted model against runs that the fit has not seen."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from metrology.errors import Fault, MetrologyError
from metrology.estimation import Identification, MeasuredRun
from metrology.message import said
from metrology.timeseries import SCREEN
from metrology.verify.closed_residuals import Array, Closed, closed_residuals, slow_part
from metrology.verify.finding import PhaseScore, RingingScore, RunVerification, Series, VerificationFinding
from metrology.verify.judge import COARSE, FEWEST, RULE, above, judge, overall
from metrology.verify.metrics import METRICS, ringing
from metrology.verify.phases import Phase, phases
from metrology.verify.prediction import Prediction, closed_loop, numerical, open_loop
from metrology.verify.series import decimated


def compare(
    found: Identification,
    runs: Sequence[MeasuredRun],
    rng: np.random.Generator,
    *,
    names: tuple[str, str] = ("", ""),
    certificates: Mapping[str, float] | None = None,
) -> VerificationFinding:
    """Verification of a fitted model by runs with the purpose 'verification'.

    E = S − D reading by reading, u_val² = u_num² + u_input² + u_D² (ASME V&V 20-2009, 1-5.3), open loop and with the
    run's own inputs re-estimated within their priors, by channel and phase; the verdict by `RULE`.

    Parameters
    ----------
    found : Identification
        With status 'ok'.
    runs : sequence of MeasuredRun
        Those with the purpose 'verification' are used.
    rng : numpy.random.Generator
        For the Monte Carlo bands.
    names : (str, str)
        Sample and test, as the report names them.
    certificates : mapping of str to float
        Standard uncertainty by channel that the instrument's certificate leaves, beyond what the priors of the fit say.

    Returns
    -------
    VerificationFinding
        Metrics by run, channel and phase, the verdict of each run, and that over all.

    Raises
    ------
    MetrologyError
        Where no run is left, a run went into the fit as well, or the fit failed.
    """
    chosen = [one for one in runs if one.purpose == "verification"]
    seen = {one.name for one in found.runs} & {one.name for one in chosen}
    expected = "a run that the fit has not seen"
    faults = [Fault(f"verify.{name}", "a run that went into the fit", expected) for name in sorted(seen)]
    if found.status != "ok":
        faults.append(Fault("verify", "a fit that failed", "a fit with results", found.sentence))
    if not chosen:
        faults.append(Fault("verify.runs", "no run for verification", "at least one that the fit has not seen"))
    if faults:
        raise MetrologyError(*faults)
    judged = tuple(_run(found, one, rng, certificates or {}) for one in chosen)
    verdict, sentence = overall([(one.run, one.verdict) for one in judged])
    note = said(
        "No model predicts at the level of the noise: what differs from run to run in thrust and start is "
        "in the band. The residuals with the run's own inputs re-estimated show what the model itself leaves."
    )
    model = ", ".join(f"{name} = {value:.6g}" for name, value in found.common_values.items())
    return VerificationFinding(names[0], names[1], model, verdict, sentence, RULE, judged, (note,))


def _run(
    found: Identification, measured: MeasuredRun, rng: np.random.Generator, certificates: Mapping[str, float]
) -> RunVerification:
    ahead = open_loop(found, measured, rng)
    if ahead is None:
        sentence: str = said("not testable: the motion of this run cannot be followed with the fitted values")
        return RunVerification(
            measured.name, "not testable", sentence, RULE, None, None, (), (), (), (), (), (), found.notes[:0]
        )
    behind = closed_loop(found, measured, rng)
    parts = phases(ahead.rig, measured.run, ahead.motion)
    u_num = numerical(ahead.rig, measured.run, ahead.motion, measured.channels)
    u_val = {}
    for name in measured.channels:
        flat = (measured.noise[name], u_num[name], certificates.get(name, 0.0))
        u_val[name] = np.sqrt(ahead.u_input[name] ** 2 + sum(u**2 for u in flat))
    scores = _scores(measured, (ahead, behind), parts, u_val)
    own = () if behind is None else tuple((name, value, far) for name, (far, value) in behind.own.items())
    tension = ahead.motion.T if ahead.motion.T is not None else np.ones(1)
    verdict, sentence = judge(scores, own, bool((tension > 0).any()) or found.rig.attachment == "none")
    inside = [_inside(measured, ahead, name) for name in measured.channels]
    shares = [_share(measured, ahead, name, u_val[name]) for name in measured.channels]
    notes: tuple[str, ...] = ()
    if behind is None:
        notes = (said("nothing of the run itself could be re-estimated: no prior has a part per run"),)
    if ahead.lost:
        text = "{count} Monte Carlo draws could not be followed and are left out of the band"
        notes = (*notes, said(text, count=ahead.lost))
    return RunVerification(
        run=measured.name, verdict=verdict, sentence=sentence, rule=RULE, share=_mean(shares), in_band=_mean(inside),
        phases=tuple((part.name, part.start, part.stop) for part in parts), scores=scores,
        ringing=_ringing(measured, ahead), own=own, u_num=tuple(u_num.items()),
        series=tuple(_series(measured, (ahead, behind), name, u_val[name]) for name in measured.channels), notes=notes,
    )  # fmt: skip


def _mean(parts: Sequence[Array]) -> float | None:
    together = np.concatenate(parts)
    return float(together.mean()) if together.size else None


def _inside(measured: MeasuredRun, ahead: Prediction, name: str) -> Array:
    used, y = measured.used(name), measured.readings(name)
    inside: Array = ((y >= ahead.low[name]) & (y <= ahead.high[name]))[used].astype(float)
    return inside


def _share(measured: MeasuredRun, ahead: Prediction, name: str, u_val: Array) -> Array:
    used = measured.used(name)
    error = getattr(ahead.motion, name) - measured.readings(name)
    within: Array = (np.abs(error) <= 2 * u_val)[used].astype(float)
    return within


def _scores(
    measured: MeasuredRun,
    predictions: tuple[Prediction, Prediction | None],
    parts: Sequence[Phase],
    u_val: Mapping[str, Array],
) -> tuple[PhaseScore, ...]:
    scores = []
    behind = predictions[1]
    for name in measured.channels:
        stamps = measured.stamps(name)
        closed = None if behind is None else closed_residuals(measured, behind, name)
        whole = Phase("all", float(stamps[0]), float(stamps[-1]))
        for part in (whole, *parts):
            last = part.stop == measured.run.end or part.name == "all"
            inside = (stamps >= part.start) & ((stamps <= part.stop) if last else (stamps < part.stop))
            scores.append(_score(measured, (predictions[0], closed), (name, part), inside, u_val[name]))
    return tuple(scores)


def _score(
    measured: MeasuredRun,
    of: tuple[Prediction, Closed | None],
    place: tuple[str, Phase],
    inside: NDArray[np.bool_],
    u_val: Array,
) -> PhaseScore:
    (ahead, behind), (name, part) = of, place
    every = measured.readings(name)[measured.used(name)]
    used = inside & measured.used(name)
    count = int(used.sum())
    span = float(np.ptp(every))
    if count < FEWEST:
        return PhaseScore(name, part.name, part.start, part.stop, count)
    d, s = measured.readings(name)[used], getattr(ahead.motion, name)[used]
    found = {label: _number(metric(d, s)) for label, metric in METRICS.items()}
    typical = float(np.sqrt(np.mean(u_val[used] ** 2)))
    signal = float(np.std(d)) if part.name == "all" else max(float(np.std(d)), float(np.abs(d - every[0]).max()) / 2)
    closed, white = (None, None) if behind is None else behind.within(inside)
    if closed is None or len(closed) < FEWEST:
        closed = white = None
    return PhaseScore(
        channel=name, name=part.name, start=part.start, stop=part.stop, count=count, rms=found["rms"],
        nrms=None if span == 0 or found["rms"] is None else found["rms"] / span, r_squared=found["r_squared"],
        peak_error=found["peak_error"], magnitude=found["magnitude"], phase=found["phase"], combined=found["combined"],
        share=float((np.abs(s - d) <= 2 * u_val[used]).mean()), u_val=typical,
        closed_rms=None if closed is None else float(np.sqrt(np.mean(closed**2))),
        closed_above=None if closed is None or behind is None else above(closed, behind.alike),
        closed_excess=None if closed is None or white is None else slow_part(closed, white),
        testable=typical <= COARSE * signal,
    )  # fmt: skip


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _ringing(measured: MeasuredRun, ahead: Prediction) -> tuple[RingingScore, ...]:
    """Swing over the longest stretch in which the line stays taut and the thrust does not change."""
    rig, run = ahead.rig, measured.run
    if rig.k <= 0:
        return ()
    edges = [(event.t, event.kind) for event in ahead.motion.events if event.kind in ("taut", "slack", "force")]
    begin = [(run.t0, "taut" if rig.attachment == "both ways" or run.x0 > rig.taut else "slack")]
    stretches, taut = [], begin[0][1] == "taut"
    marks = [*begin, *edges, (run.end, "end")]
    for (start, kind), (stop, _) in pairwise(marks):
        taut = taut if kind == "force" else kind == "taut"
        if taut:
            stretches.append((start, stop))
    if not stretches:
        return ()
    start, stop = max(stretches, key=lambda one: one[1] - one[0])
    stop = min(stop, start + 12 * 2 * math.pi * math.sqrt(rig.m / rig.k))
    found = []
    for name in measured.channels:
        used = measured.used(name) & (measured.stamps(name) > start) & (measured.stamps(name) < stop)
        t, omega = measured.stamps(name)[used], math.sqrt(rig.k / rig.m)
        seen = ringing(t, measured.readings(name)[used], omega)
        swing = ringing(t, getattr(ahead.motion, name)[used], omega)
        if seen is not None and swing is not None:
            found.append(
                RingingScore(
                    name, start, stop, seen.omega, seen.omega_u, swing.omega, seen.rate, seen.rate_u, swing.rate
                )
            )
    return tuple(found)


def _series(
    measured: MeasuredRun, predictions: tuple[Prediction, Prediction | None], name: str, u_val: Array
) -> Series:
    ahead, behind = predictions
    y = np.where(measured.used(name), measured.readings(name), np.nan)
    s = getattr(ahead.motion, name)
    closed = None if behind is None else getattr(behind.motion, name)
    kept = decimated(y, y - s, closed if closed is not None else s, points=SCREEN)

    def gaps(values: Array) -> tuple[float | None, ...]:
        return tuple(_number(float(value)) for value in values[kept])

    def plain(values: Array) -> tuple[float, ...]:
        return tuple(float(value) for value in values[kept])

    return Series(
        channel=name, unit=measured.unit(name), time=plain(measured.stamps(name)), measured=gaps(y), simulated=plain(s),
        low=plain(ahead.low[name]), high=plain(ahead.high[name]), error=gaps(s - y), twice_u_val=plain(2 * u_val),
        closed=() if closed is None else plain(closed), closed_residual=() if closed is None else gaps(y - closed),
        count=y.size,
    )  # fmt: skip
