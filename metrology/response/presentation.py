"""A fit as values for the report: estimates, inputs before and after, measured beside fitted."""

from __future__ import annotations

import math

import numpy as np

from metrology.identify import Identification, MeasuredRun, shares
from metrology.identify.measured import UNITS
from metrology.identify.problem import Array
from metrology.response.finding import ChannelFit, FittedRun, InputAfter, Sought, plotted
from metrology.rig import EFFECTS, Rig, simulate
from metrology.verify.compare import decimated

ATTACHED = {"tether": "a line that only pulls", "both ways": "a line that pulls and pushes", "none": "no line"}
WEIGHING = {
    "none": "",
    "catenary": ", its weight by eq. 3 of the paper while it is slack",
    "elastic catenary": ", sagging as an elastic catenary",
}


def model_text(rig: Rig) -> str:
    """Say in words what is simulated."""
    effects = "".join(f", {name} = {value:g}" for name, value in rig.effects.items())
    return f"module of {rig.m:g} kg on {ATTACHED[rig.attachment]}{WEIGHING[rig.line_weight]}{effects}"


BASE = {
    "tether": "m·x″ = F − T, T = k·e + c·e′ while e = x − x_t > 0 and T > 0, else 0",
    "both ways": "m·x″ = F − T, T = k·e + c·e′, e = x − x_t",
    "none": "m·x″ = F",
}
WEIGHT = {
    "none": "",
    "catenary": "slack: T = q·L²/(8·√(3·L·(s − L)/8)), L = s − (x_t − x)",
    "elastic catenary": "T³/k − e·T² − q²·s³/24 = 0",
}


def equations(rig: Rig) -> tuple[str, ...]:
    """Equation of motion that was simulated: the base model, the weight of the line, and every effect that acts."""
    told = [BASE[rig.attachment], WEIGHT[rig.line_weight]]
    for effect in (*EFFECTS, *(own.effect for own in rig.own)):
        acting = [entry for entry in effect.parameters if entry.name in rig.effects]
        values = (
            f"{one.symbol} = {rig.value(one.name):.6g}{'' if one.unit == '1' else f' {one.unit}'}" for one in acting
        )
        if acting:
            told.append(f"{effect.equation}, {', '.join(values)}")
    return tuple(line for line in told if line)


def sought(found: Identification, free: tuple[str, ...]) -> tuple[Sought, ...]:
    """Estimates of the free parameters."""
    return tuple(
        Sought(
            name=entry.name, unit=entry.unit, value=entry.value, u=entry.u, low=entry.low, high=entry.high,
            interval=entry.interval, determined=entry.determined, sentence=entry.sentence,
            shares=tuple(shares(found, entry.name).items()),
        )
        for entry in found.parameters
        if entry.name in free
    )  # fmt: skip


def inputs_after(found: Identification) -> tuple[InputAfter, ...]:
    """Inputs with priors, before and after the fit."""
    sources = {prior.name: prior.source for prior in found.priors}
    told = []
    for entry in found.parameters:
        if entry.prior_mean is None or entry.prior_u is None:
            continue
        name, _, run = entry.name.partition("@")
        numbers = (entry.prior_mean, entry.prior_u, entry.value, entry.u)
        told.append(InputAfter(name, run, entry.unit, *numbers, sources.get(name, "")))
    return tuple(told)


def fitted_runs(found: Identification) -> tuple[FittedRun, ...]:
    """Every run of the fit beside the fitted motion."""
    return tuple(FittedRun(run.name, _channels(found, run)) for run in found.runs)


def _channels(found: Identification, run: MeasuredRun) -> tuple[ChannelFit, ...]:
    motion = simulate(found.rig_of(run.name), run.run)
    told = []
    for name in run.channels:
        fitted = getattr(motion, name)
        measured = np.where(run.used(name), run.readings(name), np.nan)
        kept = decimated(measured, measured - fitted, fitted)
        weighted = next(one for one in found.residuals if (one.run, one.channel) == (run.name, name))
        used = weighted.residual[weighted.used.astype(bool)]
        told.append(
            ChannelFit(
                channel=name, unit=UNITS[name], noise=run.noise[name],
                rms=float(np.sqrt(np.mean(used**2))) if used.size else None, count=int(used.size),
                time=_plain(run.stamps(name)[kept]), measured=_gaps(measured[kept]),
                fitted=_plain(fitted[kept]), residual=_gaps((measured - fitted)[kept]),
            )
        )  # fmt: skip
    return tuple(told)


def _gaps(values: Array) -> tuple[float | None, ...]:
    return plotted(value if math.isfinite(value) else None for value in values.tolist())


def _plain(values: Array) -> tuple[float, ...]:
    return tuple(value for value in plotted(values.tolist()) if value is not None)
