"""Checks of the records against what the model of a linear viscoelastic specimen supposes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from metrology import raw
from metrology.check import Check
from metrology.relaxation.blocks import Array
from metrology.relaxation.course import MOST as PIECES
from metrology.relaxation.evidence import HALF, Said, Supported
from metrology.relaxation.finding import Compared
from metrology.relaxation.fit import Fitted
from metrology.relaxation.forms import Scene
from metrology.relaxation.levels import WITHIN, Levels
from metrology.relaxation.noise import cosines
from metrology.relaxation.test import Mounting, RelaxationTest
from metrology.timeseries import Channel

LEVELS = "held levels"
GAPS = "gaps"
DURATION = "duration"
BRANCHES = "number of branches"
REST = "rest before the ramp"
FINAL, LATER = ("k_inf", "E_inf", "relaxed"), ("k_t", "E_t", "alpha")
"""Results that checks of the equilibrium concern, and of the time that was asked for."""
EQUILIBRIUM = "equilibrium and last reading"
ASKED = "time asked for"
DRIFT = "drift or relaxation"
RESIDUALS = "residuals"
SETUP = "set-up compliance"
DMA = "DMA sweep"
STILL = 8
"""Readings at rest, or at a level, from which on their scatter is judged."""
HOLD = 3.0
"""Times of a ramp that a level has to be held: a course that is shorter is that of the ramp."""
CHANGE = 10.0
"""Standard deviations of a reading by which the input has to change."""
GAP = 8.0
"""Time between two readings, over the largest of the times before and after, from which on it is a gap."""
BOUND = 1.0
"""Longest relaxation time over the longest hold from which on what it leaves is not known to end: at it, 37 % of the
branch are still to come, and it bends off a line by less than it goes on."""
TO_COME = 0.02
"""Part of k by which it may still change after the record without its being an extrapolation."""
EDGE = 0.02
"""Part of a hold by which a time may lie beyond its end, or of a ramp before: ends are known to a block of readings."""
SLOW = 2.0
"""Variance of slow residuals over that of all that passes: the colour of a noise is known to about a factor of two."""
LARGE, PARTS, ALIKE = 5.0, 1e-3, 0.5
"""Residuals over what the scatter from reading to reading leaves of the same means, their part of the range of the
answer, and the correlation of neighbours, that together are a misfit. A sound cell wanders by less than 0.1 % of its
reading. Noise with a memory of seconds is 5 to 50 times the white noise of such means, but has forgotten itself from
one to the next: 0.3 at most, where a slip, or levels of unlike stiffness, leave 0.6 to 0.9."""
STANDS = 2e-3
"""Part of the range of the answer by which it may change before the ramp: noise of 0.05 % of it with a memory of half a
second has a slope of 0.11 % over five seconds that means of a sixteenth take for significant."""
RESTS = 16
"""Means into which readings at rest are divided: a line through them leaves 14 degrees of freedom."""
SURE = 0.95
"""Probability from which on the readings decide between two things."""


@dataclass(frozen=True)
class Done:
    """One specimen as evaluated: its record, blocks and levels, the fit of the most probable form, what is said.

    `whole` is whether the course of its input was taken with all of its corners.
    """

    mounting: Mounting
    scene: Scene
    levels: Levels
    best: Fitted
    names: tuple[str, ...]
    said: Said
    whole: bool


def run(test: RelaxationTest, done: Sequence[Done], found: Supported, dma: Sequence[Compared]) -> tuple[Check, ...]:
    """All checks, in the order in which the report shows them."""
    checks = [records(test, done), gaps(done), levels(test, done), residuals(test, done), drift(done, found)]
    checks += [rest(done), branches(test, found), duration(done, found), equilibrium(done, found)]
    if test.at is not None:
        checks.append(asked(test.at, done))
    if not test.by_strain:
        checks.append(setup(test))
    if test.dma is not None:
        checks.append(sweep(dma))
    return tuple(checks)


def records(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Readings that are held, repeated or cut off at the end of a range: what answered, in every specimen."""
    force = test.held == "elongation"
    unit = "N" if force else "1" if test.by_strain else "m"
    channels = {}
    for one in done:
        value = one.mounting.force if force else one.mounting.stretch
        channels[one.mounting.name] = Channel(one.mounting.name, one.mounting.time, value, unit)
    found = raw.check(channels, test.force_division if force else test.stretch_division)
    still = [words for one in done for words in _clipped(test, one)]
    if not still:
        return found
    sentence = f"{'; '.join(still)}: clipped, where they scattered before the ramp. Repeat the test within the range."
    sentence = f"{found.sentence} {sentence}" if found.passed is False else sentence
    return Check(raw.NAME, (found.statistic or 0.0) + len(still), None, False, sentence)


def _clipped(test: RelaxationTest, one: Done) -> Iterator[str]:
    """Levels at which what was imposed stands still though it was read: at rest, before the ramp, it scattered.

    What was commanded, or rests below its last digit, is alike at rest too.
    """
    u = one.mounting.stretch if test.held == "elongation" else one.mounting.force
    time = one.mounting.time - one.mounting.time[0]
    rest = u[time < one.levels.before]
    if len(rest) < STILL or float(np.median(np.abs(np.diff(rest)))) == 0:
        return
    for level in one.levels.held:
        held = u[(time > level.start) & (time < level.stop)]
        if len(held) >= STILL and float(np.mean(np.diff(held) == 0)) > HALF:
            yield f"{one.mounting.name}: the input stands at {float(np.median(held)):.4g} for {level.duration:.3g} s"


def gaps(done: Sequence[Done]) -> Check:
    """Times without readings, and whether the input was the same before and after."""
    seen, moved = [], []
    for one in done:
        time = one.mounting.time
        steps = np.diff(time)
        around = np.maximum(np.append(steps[1:], steps[-1]), np.append(steps[0], steps[:-1]))
        for at in np.flatnonzero(steps > GAP * around).tolist():
            words = f"{one.mounting.name}: {steps[at]:.3g} s from {time[at] - time[0]:.4g} s on"
            seen.append(words)
            if _moves(one, at):
                moved.append(words)
    if moved:
        sentence = f"The input moved while nothing was read: {'; '.join(moved)}. The course between is not known."
        return Check(GAPS, float(len(seen)), None, False, sentence)
    sentence = f"Without readings at a level that was held: {'; '.join(seen)}." if seen else "No gap in the stamps."
    return Check(GAPS, float(len(seen)), None, True, sentence)


def _moves(one: Done, at: int) -> bool:
    of, time = one.scene.answer.of, one.mounting.time
    begin, end = (float(time[place] - time[0]) for place in (at, at + 1))
    return not any(each.start - 1e-9 <= begin and end <= each.stop + 1e-9 for each in one.levels.held) and not (
        end <= one.levels.before or begin >= float(of.time[-1])
    )


def levels(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Whether something was held: for several times as long as the ramp to it."""
    still = [one.mounting.name for one in done if _rests(test, one)]
    if still:
        sentence = f"The input does not change beyond its noise: no ramp in the record of {', '.join(still)}."
        return Check(LEVELS, None, None, False, sentence)
    short = [one.mounting.name for one in done
             if not any(each.duration >= HOLD * one.levels.ramp for each in one.levels.held)]  # fmt: skip
    if short:
        sentence = (
            f"No level was held for {HOLD:.0f} times as long as the ramp to it: {', '.join(short)}. Ramp faster, or "
            "hold for longer."
        )
        return Check(LEVELS, None, None, False, sentence)
    rough = [one.mounting.name for one in done if not one.whole]
    if rough:
        sentence = (
            f"The course of the input has more corners than the {PIECES} pieces that are taken: {', '.join(rough)}. "
            "What was imposed is not known well enough. Hold fewer levels in one record, or state the instrument's "
            "'resolution' where its steps are read as corners."
        )
        return Check(LEVELS, None, None, False, sentence)
    most = max(len(one.levels.held) for one in done)
    off = max(each.range / (float(np.ptp(one.scene.answer.of.u)) or 1.0) for one in done for each in one.levels.held)
    several = "1 level was" if most == 1 else f"up to {most} levels were"
    sentence = (
        f"{several.capitalize()} held within {100 * off:.2g} % of the range of the input; what it moved "
        "meanwhile is in the model."
    )
    return Check(LEVELS, None, None, True, sentence)


def _rests(test: RelaxationTest, one: Done) -> bool:
    """Whether the course of the input does not stand out of the noise of its readings."""
    u = one.mounting.stretch if test.held == "elongation" else one.mounting.force
    scatter = float(np.median(np.abs(np.diff(u)))) / 0.9539
    return float(np.ptp(one.scene.answer.of.u)) < CHANGE * scatter


def residuals(test: RelaxationTest, done: Sequence[Done]) -> Check:
    """Slow residuals of the most probable form, against all of them: Fisher's F of their variances, over `SLOW`."""
    from scipy.special import fdtrc

    worst, name, p_least = 0.0, "", 1.0
    for one in done:
        n, q = len(one.best.model), len(one.best.values)
        low = cosines(n, q)
        p = float(fdtrc(low, n - q, one.best.excess / SLOW))
        if p <= p_least:
            worst, name, p_least = one.best.excess, one.mounting.name, p
    p_least = min(1.0, p_least * len(done))
    causes = (
        "the specimen is not linear viscoelastic over its levels, a grip slips, the crosshead has backlash, or the "
        "noise has a colour of its own"
    )
    if p_least < test.significance:
        sentence = (
            f"The most probable form leaves slow residuals in {name}, {worst:.2g} times the variance of its noise: "
            f"{causes}. Intervals are wider by that."
        )
        return Check(RESIDUALS, worst, p_least, False, sentence)
    # The colour of the noise is found with the form, and takes what no form explains: newtons do not follow it.
    for one in done:
        part, ratio, alike = _misfit(test, one)
        if part > PARTS and ratio > LARGE and alike > ALIKE:
            sentence = (
                f"The most probable form misses {one.mounting.name} by {100 * part:.2g} % of the range of the answer, "
                f"{ratio:.2g} times what the scatter from reading to reading leaves, and alike from one mean to the "
                f"next: {causes}. It is taken for slow noise."
            )
            return Check(RESIDUALS, part, None, False, sentence)
    return Check(RESIDUALS, worst, p_least, True, "What the most probable form leaves is noise.")


def _misfit(test: RelaxationTest, one: Done) -> tuple[float, float, float]:
    """Residuals over the range of the answer, over white noise as from reading to reading, correlation of neighbours.

    Root mean squares over time: means over blocks count by their readings.
    """
    of = one.scene.answer.of
    readings = one.mounting.force if test.held == "elongation" else one.mounting.stretch
    # The median of |difference| of two readings is 0.954 standard deviations of one.
    white = float(np.median(np.abs(np.diff(readings)))) / 0.9539
    rest, count = of.y - one.best.model, of.count.astype(float)
    size = float(np.sqrt((count * rest**2).sum() / count.sum()))
    expected = max(white * float(np.sqrt(len(count) / count.sum())), 1e-300)
    weighed = np.sqrt(count) * rest
    alike = float(weighed[1:] @ weighed[:-1] / max(weighed @ weighed, 1e-300))
    return size / (float(np.ptp(of.y)) or 1.0), size / expected, alike


def drift(done: Sequence[Done], found: Supported) -> Check:
    """Whether the readings distinguish a drift of the instrument from what the specimen does.

    A relaxation over more decades than the branches span is evenly slow too: a drift counts as one of the instrument
    only where it shows while nothing was held.
    """
    p = found.drift
    if p <= 1 - SURE:
        return Check(DRIFT, p, None, True, f"No drift of the readings is supported (probability {p:.2g}).")
    advice = "Read the instrument unloaded for a while before the ramp and after a return."
    if p < SURE:
        sentence = (
            f"The readings do not decide whether the instrument drifted (probability {p:.2g}): results are means over "
            f"both. {advice}"
        )
        return Check(DRIFT, p, None, False, sentence, covered=True)
    if all(_drifts_at_rest(one) for one in done):
        sentence = f"The readings drift evenly (probability {p:.3g}), before the ramp as well; the drift is taken off."
        return Check(DRIFT, p, None, True, sentence)
    sentence = (
        f"An even drift fits the readings (probability {p:.3g}) and is taken off, but readings at rest alone do not "
        f"show it: it may be a relaxation, or a flow, that goes on, and the equilibrium stiffness is then too high. "
        f"{advice}"
    )
    return Check(DRIFT, p, None, False, sentence)


def _drifts_at_rest(one: Done) -> bool:
    """Whether a line through the readings before the first ramp has a slope, and that of the drift that was fitted.

    Readings after a return to zero recover from the hold, and do not tell the instrument's drift from that.
    """
    from scipy.special import stdtrit

    best, of = one.best, one.scene.answer.of
    if not best.form.drift:
        return False
    slope, own, _ = _slope_at_rest(one)
    duration = float(of.time[-1] - of.time[0])
    fitted, u_fitted = best.values[1] / duration, float(np.sqrt(best.covariance[1, 1])) / duration
    reach = float(stdtrit(RESTS - 2, 0.995))
    return abs(slope) > reach * own and abs(slope - fitted) < reach * float(np.hypot(own, u_fitted))


def _slope_at_rest(one: Done) -> tuple[float, float, float]:
    """Slope of the line through what answered before the first ramp, its standard uncertainty, and its duration."""
    time = one.mounting.time
    before = time - time[0] < one.levels.before
    n = int(before.sum()) // RESTS * RESTS
    if n < RESTS:
        return 0.0, np.inf, 0.0
    answer = one.mounting.force if one.scene.held == "elongation" else one.mounting.stretch
    t, y = (channel[:n].reshape(RESTS, -1).mean(axis=1) for channel in (time - time[0], answer))
    away = t - t.mean()
    slope = float(away @ y / (away @ away))
    left = y - y.mean() - slope * away
    return slope, float(np.sqrt(left @ left / (RESTS - 2) / (away @ away))), float(t[-1] - t[0])


def rest(done: Sequence[Done]) -> Check:
    """Whether what answered stands still before the first ramp: the model begins at rest."""
    from scipy.special import stdtr

    worst, words = 0.0, ""
    for one in done:
        slope, u, duration = _slope_at_rest(one)
        part = abs(slope) * duration / (float(np.ptp(one.scene.answer.of.y)) or 1.0)
        # What drifts on is in the model.
        sure = 2 * stdtr(RESTS - 2, -abs(slope) / max(u, 1e-300)) < 1 - 0.999
        if part > max(worst, STANDS) and sure and not _drifts_at_rest(one):
            worst, words = part, one.mounting.name
    if not words:
        return Check(REST, worst, None, True, "What answered stood still before the first ramp.")
    sentence = (
        f"What answered changes before the first ramp ({words}: by {100 * worst:.2g} % of its range), and does not go "
        "on so: the specimen was loaded before the record begins, and still relaxes. Unload it and wait, or begin the "
        "record before the first load."
    )
    return Check(REST, worst, None, False, sentence)


def equilibrium(done: Sequence[Done], found: Supported) -> Check:
    """Whether the equilibrium stiffness exceeds what was read last at the highest level.

    At a level that no reading exceeded, force by stretch is never less than in equilibrium, whatever was before:
    integrated by parts, F − k_∞·x is a sum of (x(t) − x(s)) with positive weights (and so is J_∞·F − x).
    """
    if found.power > HALF:
        return Check(EQUILIBRIUM, None, None, None, "A power law has no equilibrium.")
    worst, words = 0.0, ""
    for one in done:
        read, u_read = _read_last(one)
        place = one.names.index("r_inf")
        value, u = float(one.said.values[place]), float(one.said.u[place])
        over = (value - read) / max(2 * float(np.hypot(u, u_read)), 1e-300)
        if over > worst:
            worst, words = over, f"{one.mounting.name}: {value:.5g} against {read:.5g}"
    if worst > 1:
        sentence = (
            f"The equilibrium stiffness (force by stretch, {words}) exceeds what was read last at the highest level by "
            f"{worst:.2g} times its expanded uncertainty: no specimen stiffens as it relaxes. A drift that "
            "was taken off, or levels of unlike stiffness, may have made it so."
        )
        return Check(EQUILIBRIUM, worst, None, False, sentence, concerns=FINAL)
    sentence = "The equilibrium stiffness does not exceed what was read last at the highest level."
    return Check(EQUILIBRIUM, worst, None, True, sentence)


def _read_last(one: Done) -> tuple[float, float]:
    """Force by stretch at the end of the hold at the highest level, less a drift that shows at rest, with its u."""
    of, best = one.scene.answer.of, one.best
    y = of.y
    if _drifts_at_rest(one):
        y = y - best.values[1] * (of.time - of.time[0]) / (of.time[-1] - of.time[0])
    away = of.u - of.u[0]
    # The last block that is as high as any: WITHIN of the range is a level.
    at = int(np.flatnonzero(np.abs(away) >= (1 - WITHIN) * np.abs(away).max())[-1])
    first = max(int((of.end <= one.levels.before).sum()), 1)
    weights = of.count[:first].astype(float)
    zero_u, zero = (float(weights @ channel[:first] / weights.sum()) for channel in (of.u, y))
    secant = (float(y[at]) - zero) / (float(of.u[at]) - zero_u)
    u = float(np.std(of.y - best.model)) * np.sqrt(2) / abs(float(of.u[at]) - zero_u)
    return (secant, u) if one.scene.held == "elongation" else (1 / secant, u / secant**2)


def branches(test: RelaxationTest, found: Supported) -> Check:
    """Whether a further branch might have been supported: none was weighed beyond `branches`."""
    form = found.forms[found.best]
    if test.branches and not form.power and form.branches >= test.branches:
        sentence = (
            f"The most probable form has as many branches as were allowed ({test.branches}): the readings may tell of "
            "more, and of an equilibrium that is lower. State more 'branches' (6 at most), or ask for the stiffness at "
            "a time ('at')."
        )
        return Check(BRANCHES, float(form.branches), None, False, sentence)
    return Check(BRANCHES, float(form.branches), None, True, "The readings support fewer branches than were allowed.")


def duration(done: Sequence[Done], found: Supported) -> Check:
    """Whether the equilibrium is read or extrapolated: what is still to come after the last hold."""
    if found.power > HALF:
        sentence = "A power law has no equilibrium: no equilibrium stiffness is given."
        return Check(DURATION, None, None, None, sentence)
    worst, name = 0.0, ""
    for one in done:
        held = max((each.duration for each in one.levels.held), default=0.0)
        form = one.best.form
        if form.power:
            continue
        end = _slowest(one)
        if end > BOUND * held:
            sentence = (
                f"The slowest branch of {one.mounting.name} is not bounded by the record: its time reaches "
                f"{end:.2g} s, the longest hold {held:.4g} s. A steady flow, or a drift, would look the same: there "
                "is no equilibrium stiffness to rely on. Hold for longer, or ask for the stiffness at a time ('at')."
            )
            return Check(DURATION, end, None, False, sentence, concerns=FINAL)
        now, final = one.scene.at(form, one.best.values, np.array([held]))[0], one.scene.final(form, one.best.values)
        left = abs(float(now) / final - 1)
        if left >= worst:
            worst, name = left, one.mounting.name
    if worst > TO_COME:
        sentence = (
            f"The equilibrium is extrapolated: after the longest hold {100 * worst:.2g} % of its stiffness are still "
            f"to come ({name}), if no slower branch follows. Hold for longer, or ask for the stiffness at a time "
            "('at')."
        )
        return Check(DURATION, worst, None, False, sentence, concerns=FINAL)
    sentence = (
        f"At the end of the longest hold at most {100 * worst:.2g} % of the equilibrium stiffness are still to come."
    )
    return Check(DURATION, worst, None, True, sentence)


def _slowest(one: Done) -> float:
    """Upper end of the 95 % interval of the longest time / s; 0 where there is no branch."""
    from scipy.special import stdtrit

    best, m = one.best, one.best.form.branches
    if not m:
        return 0.0
    reach = float(stdtrit(one.said.dof, 0.975)) * np.sqrt(np.diag(best.covariance)[-m:])
    return float(np.exp(np.minimum(best.values[-m:] + reach, 600.0)).max())


def asked(at: float, done: Sequence[Done]) -> Check:
    """Whether the time that was asked for lies between the longest ramp and the longest hold of every specimen."""
    ramp = max(one.levels.ramp for one in done)
    hold = min(max((each.duration for each in one.levels.held), default=0.0) for one in done)
    if ramp * (1 - EDGE) <= at <= hold * (1 + EDGE):
        sentence = (
            f"{at:.4g} s lie between the longest ramp ({ramp:.3g} s) and the end of the longest hold ({hold:.4g} s)."
        )
        return Check(ASKED, at, None, True, sentence)
    side = (
        f"before the end of the longest ramp ({ramp:.3g} s)" if at < ramp else f"after the longest hold ({hold:.4g} s)"
    )
    sentence = (
        f"The stiffness at {at:.4g} s is extrapolated: that is {side}, and what follows there was not read. Ask for a "
        "time that the record holds, or hold for longer."
    )
    return Check(ASKED, at, None, False, sentence, concerns=LATER)


def setup(test: RelaxationTest) -> Check:
    """Whether the stretch was read apart from the compliance of grips, cell and frame."""
    if test.setup is not None:
        return Check(
            SETUP, None, None, True, "The compliance of the set-up is known by its calibration, and taken off."
        )
    sentence = (
        "The crosshead moves by the stretch of the specimen and of grips, cell and frame, and these relax too: k and E "
        "are too small by an unknown part. State 'setup_compliance' (0 um/N with its uncertainty where it is small), "
        "or use an extensometer."
    )
    return Check(SETUP, None, None, False, sentence)


def sweep(dma: Sequence[Compared]) -> Check:
    """E_n of storage and loss modulus at the frequencies that the records support."""
    seen = [(abs(en), word, one.frequency) for one in dma
            for en, word in ((one.storage_en, "E′"), (one.loss_en, "E″")) if en is not None]  # fmt: skip
    if not seen:
        sentence = "Not made: no frequency of the sweep lies in the range that the records support."
        return Check(DMA, None, None, None, sentence)
    worst, word, frequency = max(seen)
    inside = sum(one.storage_en is not None for one in dma)
    many = f"{inside} of {len(dma)} frequencies lie in the range of the records"
    stated = "" if all(one.storage_u is not None for one in dma) else "; no uncertainty of the sweep is stated"
    passed = worst <= 1.0
    sentence = f"{many}{stated}: the largest |E_n| is {worst:.2g} ({word} at {frequency:.3g} Hz)"
    sentence += "." if passed else ", more than 1: sweep and hold do not show the same specimen."
    return Check(DMA, worst, None, passed, sentence)


def notes(done: Sequence[Done], found: Supported, ends: Array) -> Iterator[str]:
    """What is worth knowing of the evaluation."""
    memory = max(one.best.memory for one in done)
    yield (
        "Readings in a row do not count as independent: every colour of the noise, with a memory of up to the duration "
        f"of the record, is weighed by the record itself (mean correlation time up to {memory:.2g} s)."
    )
    yield (
        "The ramp is in the model: the answer is Boltzmann's integral over the input as it was read, linear between "
        "means of readings."
    )
    yield f"Moduli are predicted from {ends[0]:.2g} Hz (longest hold) to {ends[1]:.2g} Hz (longest ramp)."
    if found.power <= HALF:
        fastest = min((float(np.exp(one.best.values[-1 - at])) for one in done for at in range(one.best.form.branches)),
                      default=np.inf)  # fmt: skip
        ramp = max(one.levels.ramp for one in done)
        if fastest < ramp:
            yield (
                f"The fastest branch ({fastest:.2g} s) is faster than the ramp ({ramp:.2g} s): the instantaneous "
                "stiffness is extrapolated to times before its end."
            )
        if found.power > 1 - SURE:
            yield (
                f"A power law, which has no equilibrium, has a probability of {found.power:.2g}: instantaneous and "
                "equilibrium stiffness are those of the other forms."
            )
    if any(not one.levels.before for one in done):
        yield "Nothing was read before the ramp: the zero of what answered is that of the first readings."
