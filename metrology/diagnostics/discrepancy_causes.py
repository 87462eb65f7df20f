"""Causes of a modulus or stiffness off its reference: what each would be, and whether the data allow it."""

from __future__ import annotations

import math

import numpy as np

from metrology.diagnosis import Explanation
from metrology.diagnostics.discrepancy_setting import Setting
from metrology.diagnostics.discrepancy_stated import BEYOND, judged, rounded, sized, stated_size
from metrology.diagnostics.elongation import Elongation
from metrology.elongation import ElongationTest
from metrology.message import said

NOTHING = said("no uncertainty of it is stated")


def every_cause(test: ElongationTest, setting: Setting, rho: float, u: float) -> list[Explanation]:
    """Every cause that could make the found value ρ times the reference, with u(ρ) of the stiffness alone."""
    shape = (*_sections(setting, rho, u), _length(setting, rho, u)) if setting.quantity == "E" else ()
    return [
        *shape, *_damage(setting, rho, u), _frame(setting, rho, u),
        _clamp(test, setting, rho, u), _force(test, rho, u), _indicator(test, rho, u), _expected(setting, rho),
    ]  # fmt: skip


def _sections(setting: Setting, rho: float, u: float) -> list[Explanation]:
    found = []
    for name, stated in setting.section.items():
        needed, needed_u = rho * stated.value, u * stated.value
        spread = math.hypot(needed_u, stated.u or 0.0)
        tension = abs(stated.value - needed) / spread if stated.u else None
        change = abs(stated.value - needed)
        steps = max(2, math.ceil((2 * BEYOND * (stated.u or 0.0) / change) ** 2)) if change else 2
        unit = "m²" if name == "area" else "m"
        measurement = (
            "measure the {dimension} at {steps} places along the sample, or weigh it: mass over length and density is "
            "the mean section"
        )
        power = "weighing to 0.5 % shows the {percent:.1f} % with {times:.0f} standard uncertainties"
        sentence = (
            "A {dimension} of {needed:figures} instead of {stated:figures} would explain it."
            if tension is None
            else "A {dimension} of {needed:figures} instead of {stated:figures} would explain it: {times:.1f} of its "
            "standard uncertainties away."
        )
        found.append(
            Explanation(
                f"section.{name}", said(_OF_SECTION[name]), needed, needed_u, unit, judged(tension),
                tension,
                (stated_size(stated, unit),
                 said("E and its reference are of the metal; a damaged or thinner part is weaker at the same length")),
                said(measurement, dimension=name, steps=steps),
                said(power, percent=100 * abs(1 - rho), times=abs(1 - rho) / 0.005),
                said(sentence, dimension=name, needed=sized(needed, unit), stated=sized(stated.value, unit),
                     times=tension or 0.0),
            )
        )  # fmt: skip
    return found


_OF_SECTION = {
    "width": "Width of the section", "thickness": "Thickness of the section", "height": "Height of the section",
    "area": "Area of the section",
}  # fmt: skip
"""Dimension → what it is the dimension of."""


def _damage(setting: Setting, rho: float, u: float) -> list[Explanation]:
    """Part of a section of the right size that bears nothing: cracked, or strained beyond its yield."""
    if rho >= 1:
        return []
    width = setting.section.get("width")
    needed = 1 - rho
    evidence = [said("no caliper sees it, and dead loads and free decay both take it for a lower k")]
    if width is not None:
        text = "that is {part:.2g} mm of the width of {width:.4g} mm"
        evidence.insert(0, said(text, part=1e3 * needed * width.value, width=1e3 * width.value))
    seen = needed / (math.sqrt(2) * max(setting.stiffness.relative, 1e-300))
    measurement = (
        "a piece of the same roll that was never strained, of the same length, in the same rig: if k rises, the sample "
        "was damaged; if not, it is frame, section or reference"
    )
    power = "two stiffnesses as well known as this one part {percent:.1f} % by {times:.1f} standard uncertainties"
    sentence = "A part of {percent:.1f} ± {u:.1f} % of the section that bears no load would explain it."
    return [
        Explanation(
            "damage", said("Damaged part of the section"), needed, u, "1", "allowed", None, tuple(evidence),
            said(measurement), said(power, percent=100 * needed, times=seen),
            said(sentence, percent=100 * needed, u=100 * u),
        )
    ]  # fmt: skip


def _length(setting: Setting, rho: float, u: float) -> Explanation:
    stated = setting.length
    needed = stated.value / rho
    spread = math.hypot(needed * u / rho, stated.u or 0.0)
    tension = abs(needed - stated.value) / (stated.u or spread) if spread else None
    power = "a steel tape to 1 mm shows the {size:.0f} mm without doubt"
    sentence = "A length of {needed:.4g} m between the clamps instead of {stated:.4g} m would explain it."
    return Explanation(
        "length", said("Free length"), needed, needed * u / rho, "m", judged(tension), tension,
        (stated_size(stated, "m"),),
        said("measure the length between the clamps under the first load"),
        said(power, size=1e3 * abs(needed - stated.value)),
        said(sentence, needed=needed, stated=stated.value),
    )  # fmt: skip


def _frame(setting: Setting, rho: float, u: float) -> Explanation:
    """Compliance in series: the same frame bears every sample, standing or swinging."""
    k = setting.stiffness
    needed, needed_u = (1 - rho) / k.value, u / k.value
    tension: float | None = None
    evidence = [said("loading, unloading and linearity are silent on it: it is exactly a lower k")]
    if needed <= 0:
        evidence.append(said("a compliance cannot raise k"))
        tension = abs(needed) / max(needed_u, 1e-300)
    if setting.dynamic is not None:
        d = setting.dynamic
        apart = (d.value - k.value) / max(math.hypot(d.u or 0.0, k.u or 0.0), 1e-300)
        text = (
            "free decay gives k = {k:figures} N/m, {apart:+.1f} u from the dead loads: a frame that gives alike at "
            "rest and in motion lowers both, so this does not speak against it"
        )
        evidence.append(said(text, k=rounded(d), apart=apart))
    for other in setting.others:
        share = needed * other.stiffness.value
        if other.reference is not None:
            off = other.modulus.value / other.reference.value - (1 - share)
            spread = math.hypot(other.modulus.relative, other.reference.relative)
            against = abs(off) / max(spread, 1e-300)
            text = "in the same rig {other} would come out {share:.2g} % too soft; it is {times:.1f} u from that"
            evidence.append(said(text, other=other.name, share=100 * share, times=against))
            tension = max(tension or 0.0, against)
        else:
            seen = share / max(other.modulus.relative, 1e-300)
            text = (
                "in the same rig {other} would come out {share:.2g} % too soft, {times:.1f} of the standard "
                "uncertainty of its modulus: it would show"
                if seen > BEYOND
                else "in the same rig {other} would come out {share:.2g} % too soft, {times:.1f} of the standard "
                "uncertainty of its modulus: it could not show"
            )
            evidence.append(said(text, other=other.name, share=100 * share, times=seen))
    moved = needed * 1.0
    measurement = (
        "an indicator on the mount under the same loads; or a sample of half the length: x/F against length has C as "
        "its intercept"
    )
    power = (
        "the mount would move {moved:.2g} µm for each newton: an indicator of 1 µm sees it from {force:.2g} N on with "
        "{times:g} standard uncertainties"
    )
    sentence = "A frame that gives {needed:.3g} ± {u:.2g} nm/N would explain it."
    return Explanation(
        "frame", said("Frame and clamps in series"), needed, needed_u, "m/N", judged(tension, data=True), tension,
        tuple(evidence), said(measurement),
        said(power, moved=1e6 * moved, force=BEYOND * 1e-6 / max(abs(moved), 1e-300), times=BEYOND),
        said(sentence, needed=1e9 * needed, u=1e9 * needed_u),
    )  # fmt: skip


def _clamp(test: ElongationTest, setting: Setting, rho: float, u: float) -> Explanation:
    """Slip: extension that does not come back, so unloading would lie above loading by what slipped meanwhile."""
    posed = Elongation(test)
    F = posed.force
    span = float(F.max() - F.min())
    needed = (1 - rho) * span / setting.stiffness.value
    gaps = _returns(posed)
    evidence = [
        said("slip in a clamp does not come back: it raises unloading above loading, and the zero of the next repeat")
    ]
    tension: float | None = None
    if len(gaps) >= 2:
        mean, spread = float(gaps.mean()), float(gaps.std(ddof=1)) / math.sqrt(len(gaps))
        spread = max(spread, test.resolution.u / math.sqrt(len(gaps)))
        # Half of what slips on the way up is missing at the middle load on the way down, on average.
        tension = abs(0.5 * needed - mean) / max(spread, 1e-300)
        text = "unloading lies {gap:+.2g} µm (u = {u:.2g} µm) from loading; slip would make it {needed:+.3g} µm"
        evidence.append(said(text, gap=1e6 * mean, u=1e6 * spread, needed=1e6 * 0.5 * needed))
    else:
        evidence.append(said("no load was read both ways: these data do not test it"))
    evidence.append(said("elastic give of the clamps is no slip: it acts like the frame"))
    power = "a microscope of 5 µm shows {size:.0f} µm a cycle with {times:.0f} standard uncertainties"
    sentence = "A slip of {needed:.3g} µm from the smallest to the largest load, in every repeat, would explain it."
    return Explanation(
        "clamp", said("Slip in the clamps"), needed, u * span / setting.stiffness.value, "m",
        judged(tension, data=True), tension, tuple(evidence),
        said("marks on the sample at both clamps, read before and after a cycle"),
        said(power, size=1e6 * abs(needed), times=abs(needed) / 5e-6), said(sentence, needed=1e6 * needed),
    )  # fmt: skip


def _returns(posed: Elongation) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Unloading less loading reading of the same load of the same repeat, the largest load left out."""
    found = []
    for rows in posed.at:
        for load in range(len(posed.loads)):
            own = rows[posed.load[rows] == load]
            if not len(own) or posed.force[own[0]] >= posed.force.max():
                continue
            up, down = (own[posed.back[own] == side] for side in (0, 1))
            if len(up) and len(down):
                found.append(float(posed.values[down].mean() - posed.values[up].mean()))
    return np.array(found)


def _force(test: ElongationTest, rho: float, u: float) -> Explanation:
    stated = math.hypot(test.weights.u if test.weights is not None else 0.0, test.gravity.u / test.gravity.value)
    own = [load.quantity.u / load.quantity.value for load in test.loads if load.quantity.value > 0]
    stated = math.hypot(stated, max(own, default=0.0))
    tension = abs(1 - rho) / stated if stated > 0 else None
    sentence = "Loads that are {percent:+.1f} % from the stated ones would explain it."
    return Explanation(
        "force", said("Loads"), 1 / rho - 1, u / rho**2, "1", judged(tension), tension,
        (said("masses and gravity are stated to {percent:.2g} %", percent=100 * stated) if stated > 0 else NOTHING,),
        said("weigh the loads again on another balance"), said("any balance of 1 % shows it"),
        said(sentence, percent=100 * (1 / rho - 1)),
    )  # fmt: skip


def _indicator(test: ElongationTest, rho: float, u: float) -> Explanation:
    span = max(reading.value for reading in test.used) - min(reading.value for reading in test.used)
    errors = math.sqrt(sum(one.u**2 for one in test.indicator)) * math.sqrt(2)
    scale = test.scale.u if test.scale is not None else 0.0
    stated = math.hypot(scale, errors / span) if span > 0 else 0.0
    tension = abs(1 - rho) / stated if stated > 0 else None
    text = "over its {span:.3g} mm of travel the indicator is stated to {percent:.2g} %"
    evidence = said(text, span=1e3 * span, percent=100 * stated) if stated > 0 else NOTHING
    sentence = "An indicator that shows {percent:+.1f} % of its travel too much would explain it."
    return Explanation(
        "indicator", said("Scale of the indicator"), 1 / rho - 1, u / rho**2, "1", judged(tension), tension,
        (evidence,), said("gauge blocks over the same travel"),
        said("a gauge block shows {size:.0f} µm at once", size=1e6 * abs(1 - rho) * span),
        said(sentence, percent=100 * (1 / rho - 1)),
    )  # fmt: skip


def _expected(setting: Setting, rho: float) -> Explanation:
    return _expected_modulus(setting, rho) if setting.quantity == "E" else _expected_stiffness(setting, rho)


def _expected_stiffness(setting: Setting, rho: float) -> Explanation:
    reference, k = setting.reference, setting.stiffness
    tension = abs(reference.value - k.value) / math.hypot(reference.u, k.u or 0.0) if reference.u else None
    text = (
        "{value:.4g} N/m is stated with u = {u:.3g} N/m"
        if reference.u
        else "{value:.4g} N/m is stated without an uncertainty"
    )
    stated = said(text, value=reference.value, u=reference.u or 0.0)
    if reference.source:
        stated = said("{stated} ({source})", stated=stated, source=reference.source)
    power = "a method good to 2 % parts {k:.4g} N/m from {reference:.4g} N/m by {times:.1f} standard uncertainties"
    sentence = "A reference of {k:.4g} N/m for this very sample would explain it."
    return Explanation(
        "reference", said("The reference itself"), k.value, k.u or 0.0, "N/m", judged(tension), tension,
        (stated, said("a stiffness depends on length, section and treatment: that of another sample is another one")),
        said("another method on the same sample: the frequency of a free oscillation with a known mass"),
        said(power, k=k.value, reference=reference.value, times=abs(1 - rho) / 0.02), said(sentence, k=k.value),
    )  # fmt: skip


def _expected_modulus(setting: Setting, rho: float) -> Explanation:
    reference = setting.reference
    needed, spread = setting.modulus.value, setting.modulus.u or 0.0
    tension = abs(reference.value - needed) / math.hypot(reference.u, spread) if reference.u else None
    text = (
        "{value:.4g} GPa is stated with u = {u:.3g} GPa"
        if reference.u
        else "{value:.4g} GPa is stated without an uncertainty"
    )
    stated = said(text, value=reference.value / 1e9, u=(reference.u or 0.0) / 1e9)
    if reference.source:
        stated = said("{stated} ({source})", stated=stated, source=reference.source)
    power = "a method good to 2 % parts {E:.3g} GPa from {reference:.3g} GPa by {times:.0f} standard uncertainties"
    sentence = "A reference of {E:.3g} GPa for this very material and condition would explain it."
    return Explanation(
        "reference", said("The reference itself"), needed, spread, "Pa", judged(tension), tension,
        (stated,
         said("a modulus depends on alloy, rolling and strain: foil worked to its edge is not the bulk of a handbook")),
        said("another method on the same foil: the frequency of a vibrating strip of it, or ultrasound"),
        said(power, E=needed / 1e9, reference=reference.value / 1e9, times=abs(1 - rho) / 0.02),
        said(sentence, E=needed / 1e9),
    )  # fmt: skip
