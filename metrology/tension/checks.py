"""Checks of the records against what the model of the line supposes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from metrology import raw, specimens
from metrology.check import Check
from metrology.message import said
from metrology.tension.departure import FAR, excused_bow, off_line
from metrology.tension.lines import Lines
from metrology.tension.model import Built
from metrology.tension.results import Facts
from metrology.tension.slope import Array, Slope, slope
from metrology.tension.test import TensionTest
from metrology.timeseries import Channel

LINEARITY = "linearity"
SETUP = "set-up compliance"
CHANNELS = "crosshead against extensometer"
OPPOSITE = "opposite extensometers"
OF_THE_STRETCH = ("extensometer slip", "extensometer toe", "slip", "slack")
"""Effects by which crosshead and extensometer contradict each other, and which leave E.

No compliance of the set-up does; with an extensometer of unknown scale the crosshead alone says E, set-up and all.
"""
OF_A_SPECIMEN = (*OF_THE_STRETCH, "lost section", "uneven curvature")
"""Effects that a specimen may have and the others not."""


def run(test: TensionTest, drawn: tuple[Lines, ...], built: Built, facts: Facts) -> tuple[Check, ...]:
    """All checks, in the order in which the report shows them."""
    found = [records(test), linearity(test, drawn), outlier(test, drawn, built), setup(test, facts)]
    if any(one.strain is not None and one.crosshead is not None for one in drawn):
        found.append(channels(test, drawn))
    if any(len(one.mounting.strains) > 1 for one in drawn):
        found.append(opposite(drawn))
    return tuple(found)


def records(test: TensionTest) -> Check:
    """Readings of force and extensometers that are held, repeated or cut off; of the crosshead where it is the stretch.

    A crosshead may be read by its steps, or be what was commanded: where an extensometer is, it decides nothing, and
    that its steps are all alike says nothing of it (stamps taken by its steps need not be even).
    """
    found: list[str] = []
    for one in test.mountings:
        if (strain := one.nominal) is not None:
            found += raw.strained(one.name, strain[: int(np.argmax(one.force)) + 1])
        channels: dict[str, tuple[Array, str]] = {"force": (one.force, "N")}
        channels |= {said("strain {number}", number=at + 1): (part, "1") for at, part in enumerate(one.strains)}
        if one.crosshead is not None and not one.strains:
            channels["crosshead"] = (one.crosshead, "m")
        for name, (values, unit) in channels.items():
            seen = np.isfinite(values)
            time = one.time if one.time is not None and name != "crosshead" else np.arange(float(len(values)))
            division = test.division.get(name.split()[0], 0.0)
            channel = Channel(
                said("{specimen}, {channel}", specimen=one.name, channel=name), time[seen], values[seen], unit
            )
            found += [said("{name}: {fault}", name=channel.name, fault=one) for one in raw.faults(channel, division)]
    return raw.check_of(found)


def linearity(test: TensionTest, drawn: tuple[Lines, ...]) -> Check:
    """Bow of each record over its range, against its noise and what the classes of the instruments allow.

    A line through a curve leaves the curve, which raises u of the bow: a bow beyond `excused` that u alone makes
    insignificant is not passed. Of a step or an S, which have no bow, no part of the record may be as far off the line.
    """
    from scipy.special import stdtr

    worst: tuple[float, float, str, float] = (-1.0, 0.0, "", 0.0)
    failed, unsure, off = [], [], []
    for one in drawn:
        line, reading = one.main, one.passage
        span = abs(line.value) * (reading.force[1] - reading.force[0])
        allowed = test.tolerance * span
        t = max(abs(line.bow) - allowed, 0.0) / max(line.bow_u, 1e-300)
        # Of records within what is allowed none is worse by t: the largest bow then.
        worst = max(worst, (t, abs(line.bow / span), one.mounting.name, line.dof))
        p = min(1.0, 2 * len(drawn) * float(stdtr(line.dof, -t)))
        bow = f"{100 * line.bow / span:+.2g}".replace("-", "−")
        if p < test.significance:
            failed.append(said("{specimen} ({bow:figures} %)", specimen=one.mounting.name, bow=bow))
        elif abs(line.bow) > allowed + (noise := excused_bow(one, test.tolerance)) * span:
            u = f"{100 * line.bow_u / span:.2g}"
            unsure.append(said("{specimen} ({bow:figures} ± {u:figures} %)", specimen=one.mounting.name, bow=bow, u=u))
        elif (part := off_line(test, one)) > test.tolerance + noise:
            off.append(said("{specimen} ({part:.2g} %)", specimen=one.mounting.name, part=100 * part))
    p = min(1.0, 2 * len(drawn) * float(stdtr(worst[3], -worst[0])))
    if failed:
        sentence = said(
            "Not straight over the range, beyond noise and the {allowed:.2g} % that the classes of the instruments "
            "allow: bow of {failed:comma} of the range. k and E are means over it. Choose a narrower range, or let it "
            "be looked for.",
            allowed=100 * test.tolerance,
            failed=tuple(failed),
        )
        return Check(LINEARITY, worst[0], p, False, sentence)
    if unsure:
        sentence = said(
            "Whether the record is straight cannot be determined: the bow of {unsure:comma} of the range is larger "
            "than the {allowed:.2g} % that the classes of the instruments allow, and too uncertain to be called noise "
            "or a curve. Choose a narrower range, or let it be looked for.",
            allowed=100 * test.tolerance,
            unsure=tuple(unsure),
        )
        return Check(LINEARITY, worst[0], p, False, sentence)
    if off:
        sentence = said(
            "A part of the record lies off its line by more than noise and the {allowed:.2g} % that the classes of the "
            "instruments allow, though it does not bow: {off:comma} of the range, as a step or an S does. Choose a "
            "narrower range, or let it be looked for.",
            allowed=100 * test.tolerance,
            off=tuple(off),
        )
        return Check(LINEARITY, worst[0], p, False, sentence)
    sentence = said(
        "No record bows by more than its noise and the {allowed:.2g} % that the classes of the instruments allow: "
        "the largest bow is {bow:.2g} % of the range ({specimen}).",
        allowed=100 * test.tolerance,
        bow=100 * worst[1],
        specimen=worst[2],
    )
    return Check(LINEARITY, worst[0], p, True, sentence)


def outlier(test: TensionTest, drawn: tuple[Lines, ...], built: Built) -> Check:
    """Specimens whose modulus, stiffness or set-up compliance does not fit with the others."""
    names = [one.mounting.name for one in drawn]
    return specimens.outlier(names, (built.values, built.within), _compared(built), test.significance, OF_A_SPECIMEN)


def outliers(test: TensionTest, drawn: tuple[Lines, ...], built: Built) -> dict[str, str]:
    """Each specimen that does not fit, with what does not."""
    names = [one.mounting.name for one in drawn]
    return specimens.off(names, (built.values, built.within), _compared(built), test.significance)


def _compared(built: Built) -> tuple[str, str]:
    return "E" if built.values and all("E" in one for one in built.values.values()) else "EA", "C"


def setup(test: TensionTest, facts: Facts) -> Check:
    """Whether the stretch was read apart from the compliance of grips, cell and frame."""
    if facts.strain:
        return Check(SETUP, None, None, True, said("The extensometer reads the specimen alone."))
    if test.setup is not None or facts.by_lengths:
        calibration = "The compliance of the set-up is known by its calibration, and taken off."
        lengths = "The compliance of the set-up is known by specimens of several lengths, and taken off."
        return Check(SETUP, None, None, True, said(calibration if test.setup is not None else lengths))
    sentence = said(
        "The crosshead moves by the stretch of the specimen and of grips, cell and frame: k and E are too small by an "
        "unknown part. State 'setup_compliance', use an extensometer, or pull specimens of several lengths."
    )
    return Check(SETUP, None, None, False, sentence)


def channels(test: TensionTest, drawn: tuple[Lines, ...]) -> Check:
    """What the crosshead moves beyond the specimen is a set-up that settles: it may stiffen with load, never yield.

    Where it yields, one of the two readings is wrong: the extensometer where its record stiffens and the crosshead does
    not follow, else a grip. Without a free length the set-up's part is not known: the crosshead has to follow by half.
    A compliance below zero there is none: the extensometer reads more than the crosshead moves.
    """
    p = test.significance / len(drawn)
    found = {one.mounting.name: why for one in drawn if (why := _beyond(one, test.tolerance, p))}
    found |= {one.mounting.name: why for one in drawn if (why := _culprit(one, test.tolerance))}
    if not found:
        sentence = said("The set-up moves in proportion to the load, or stiffens with it, in every mounting.")
        return Check(CHANNELS, None, None, True, sentence)
    named = tuple(said("{name}: {fault}", name=name, fault=why) for name, why in found.items())
    sentence = said("Crosshead and extensometer contradict each other: {found}.", found=named)
    return Check(CHANNELS, None, None, False, sentence, effects=OF_THE_STRETCH)


def _beyond(one: Lines, tolerance: float, p: float) -> str:
    """Words where the crosshead moves less than the specimen stretches, which no set-up does; else empty.

    Beyond what the classes allow of the stretch, and what scatter (Student's, one side) and free length leave open.
    """
    from scipy.special import stdtrit

    if one.setup is None or one.strain is None or one.mounting.length is None:
        return ""
    length = one.mounting.length
    u = float(np.hypot(one.setup.u, length.u * one.strain.value))
    limit = tolerance * length.value * abs(one.strain.value) + float(stdtrit(one.setup.dof, 1 - p)) * u
    if one.setup.value >= -limit:
        return ""
    return said(
        "strain off: the extensometer reads more than the crosshead moves (C = −{least:.3g} ± {u:.2g} nm/N), or a "
        "wrong free length",
        least=-1e9 * float(one.setup.value),
        u=1e9 * u,
    )


def _culprit(one: Lines, tolerance: float) -> str:
    """What is wrong where the crosshead and the extensometer bend apart; empty where they agree."""
    if one.strain is None or one.crosshead is None:
        return ""
    force = one.passage.force[1] - one.passage.force[0]
    strain, crosshead = (_relative(line, abs(line.value) * force) for line in (one.strain, one.crosshead))
    if strain[0] < -tolerance - FAR * strain[1] and crosshead[0] > strain[0] / 2 + FAR * crosshead[1]:
        return said("strain off: the extensometer reads too much at first, or slips")
    if one.setup is None:
        return ""
    bow, u = _relative(one.setup, abs(one.crosshead.value) * force)
    lags = said("the set-up seems to yield as the load grows: slip in the grips, or an extensometer that lags")
    return lags if bow > tolerance + FAR * u else ""


def _relative(line: Slope, span: float) -> tuple[float, float]:
    """Bow and its standard uncertainty, over the range of a reading."""
    return line.bow / span, line.bow_u / span


def opposite(drawn: tuple[Lines, ...]) -> Check:
    """Slopes of two extensometers on opposite sides: their difference is bending (ASTM E1012-19, 3.1)."""
    found: dict[str, float] = {}
    for one in drawn:
        if len(one.mounting.strains) > 1:
            first, second = (slope(one.mounting.force[one.passage.rows], part[one.passage.rows]).value
                             for part in one.mounting.strains[:2])  # fmt: skip
            found[one.mounting.name] = abs(first - second) / abs(first + second)
    name = max(found, key=lambda each: found[each])
    passed = found[name] <= LARGEST_BENDING
    text = "Bending strain is up to {part:.2g} % of the mean ({specimen}); their mean is used."
    sentence = said(text, part=100 * float(found[name]), specimen=name)
    return Check(OPPOSITE, 100 * found[name], None, passed, sentence, covered=True)


LARGEST_BENDING = 0.10
"""Part of the mean strain up to which a machine counts as aligned (ASTM E1012-19, note to 1.1: usual requirement)."""


def notes(test: TensionTest, drawn: tuple[Lines, ...], facts: Facts) -> Iterator[str]:
    """What is worth knowing of the evaluation."""
    memory = max(one.main.memory for one in drawn)
    yield said(
        "Slopes by generalised least squares: the noise of each record is weighed with its own memory, so that "
        "readings in a row do not count as independent (correlation of neighbouring means up to {memory:.2g}).",
        memory=float(memory),
    )
    if any(one.mounting.length is not None and one.mounting.length.name == f"{test.name}.gauge" for one in drawn):
        yield said(
            "No free length is stated: k is the stiffness of the gauge length, and C holds what stretches outside "
            "of it."
        )
    if any(one.setup is not None for one in drawn) and facts.lengths:
        yield said("C is the slope, by force, of what the crosshead moves beyond the stretch of the free length.")
