"""A fit as values for the report: estimates, inputs before and after, measured beside fitted."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from metrology.estimation import Identification, MeasuredRun, shares
from metrology.estimation.problem import Array
from metrology.message import said
from metrology.response.finding import ChannelFit, FittedRun, InputAfter, Sought, plotted
from metrology.rig import EFFECTS, Rig, simulate
from metrology.timeseries import Trace
from metrology.verify.series import decimated

ATTACHED = {
    "tether": "module of {m:g} kg on a line that only pulls",
    "both ways": "module of {m:g} kg on a line that pulls and pushes",
    "none": "module of {m:g} kg on no line",
}
TURNED = {
    "tether": "body with a moment of inertia of {m:g} kg·m² on a torsion spring that holds one way only",
    "both ways": "body with a moment of inertia of {m:g} kg·m² on a torsion spring",
    "none": "body with a moment of inertia of {m:g} kg·m² on no spring",
}
WEIGHING = {
    "catenary": said("its weight by eq. 3 of the paper while it is slack"),
    "elastic catenary": said("sagging as an elastic catenary"),
}


def model_text(rig: Rig) -> str:
    """Say in words what is simulated."""
    if rig.coordinate == "angle":
        base, weighing = said(TURNED[rig.attachment], m=rig.m), ""
    else:
        base, weighing = said(ATTACHED[rig.attachment], m=rig.m), WEIGHING.get(rig.line_weight, "")
    effects = (said("{name} = {value:g}", name=name, value=value) for name, value in rig.effects.items())
    texts = (base, *([weighing] if weighing else ()), *effects)
    return said("{texts:comma}", texts=texts)


MOTION = {"position": "m·x″ = F − T", "angle": "J·φ″ = M − T"}
WITHOUT = {"position": "m·x″ = F", "angle": "J·φ″ = M"}
BEYOND = {"position": "e = x − x_t", "angle": "e = φ − φ_t"}
LINE = {
    "tether": "while {beyond} > 0 and this is positive, else 0",
    "both ways": "with {beyond}",
}
WEIGHT = {
    "none": "",
    "catenary": said("T = q·L²/(8·√(3·L·(s − L)/8)), while slack, L = s − (x_t − x)"),
    "elastic catenary": "e = T/k − s·(1 − asinh(w)/w), w = q·s/(2·T)",
}


def equations(rig: Rig) -> tuple[str, ...]:
    """Equation of motion that was simulated: the base model, the weight of the line, and every effect that acts."""
    rows: list[str] = [WITHOUT[rig.coordinate]]
    if rig.attachment != "none":
        when = said(LINE[rig.attachment], beyond=BEYOND[rig.coordinate])
        line = said("T = k·e + c·e′, {when}", when=when)
        rows = [MOTION[rig.coordinate], line, WEIGHT[rig.line_weight]]
    for effect in (*EFFECTS, *(own.effect for own in rig.own)):
        acting = [entry for entry in effect.parameters if entry.name in rig.effects]
        units = {one.name: rig.parameters[one.name].unit for one in acting}
        values = ", ".join(
            f"{one.symbol} = {rig.value(one.name):.6g}{'' if units[one.name] == '1' else f' {units[one.name]}'}"
            for one in acting
        )
        if acting:
            rows.append(said("{equation}, with {values:figures}", equation=effect.equation, values=values))
    return tuple(line for line in rows if line)


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
    rows = []
    for entry in found.parameters:
        if entry.prior_mean is None or entry.prior_u is None:
            continue
        name, _, run = entry.name.partition("@")
        numbers = (entry.prior_mean, entry.prior_u, entry.value, entry.u)
        rows.append(InputAfter(name, run, entry.unit, *numbers, sources.get(name, "")))
    return tuple(rows)


def fitted_runs(found: Identification) -> tuple[FittedRun, ...]:
    """Every run of the fit beside the fitted motion."""
    return tuple(FittedRun(run.name, _channels(found, run)) for run in found.runs)


def residuals(found: Identification) -> dict[str, Trace]:
    """Every sample of the residuals of the fit, measured − fitted, by run and channel; a gap is NaN."""
    return {
        f"{run.name}/{name}": {"time": run.stamps(name), "residual": measured - fitted}
        for run in found.runs
        for name, measured, fitted in _beside(found, run)
    }


def _beside(found: Identification, run: MeasuredRun) -> Iterator[tuple[str, Array, Array]]:
    """Each channel with what was measured of it and what was fitted."""
    motion = simulate(found.rig_of(run.name), run.run)
    for name in run.channels:
        yield name, np.where(run.used(name), run.readings(name), np.nan), getattr(motion, name)


def _channels(found: Identification, run: MeasuredRun) -> tuple[ChannelFit, ...]:
    rows = []
    for name, measured, fitted in _beside(found, run):
        kept = decimated(measured, measured - fitted, fitted)
        weighted = next(one for one in found.residuals if (one.run, one.channel) == (run.name, name))
        used = weighted.residual[weighted.used.astype(bool)]
        rows.append(
            ChannelFit(
                channel=name, unit=run.unit(name), noise=run.noise[name],
                rms=float(np.sqrt(np.mean(used**2))) if used.size else None, count=int(used.size),
                time=_plain(run.stamps(name)[kept]), measured=_gaps(measured[kept]),
                fitted=_plain(fitted[kept]), residual=_gaps((measured - fitted)[kept]),
            )
        )  # fmt: skip
    return tuple(rows)


def _gaps(values: Array) -> tuple[float | None, ...]:
    return plotted(value if math.isfinite(value) else None for value in values.tolist())


def _plain(values: Array) -> tuple[float, ...]:
    return tuple(value for value in plotted(values.tolist()) if value is not None)
