"""Responses: measured over simulated with band, comparison error against u_val, phases shaded; residuals of the fit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import ceil
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from metrology.coordinate import QUANTITIES
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import number, percent, scale
from metrology.message import said
from metrology.report.figures.over_time import SHADE, SYMBOLS, band, largest, shaded, spread, stroke, symbol, whole
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, BLUE, FULL, GREY, INK, ORANGE, Plot, plain
from metrology.report.figures.zoom import as_json, packed
from metrology.response import ChannelFit, FittedRun, ResponseFinding

if TYPE_CHECKING:
    from metrology.report.figures import Job, Subject
    from metrology.timeseries import Trace

NAMES = {channels[name].unit: channels[name].word for channels in QUANTITIES.values() for name in "xvT"}
"""Unit of a channel → what it is."""
_ROW = 28.0
"""Height in mm of one channel: readings and comparison error."""
MEASURED, SIMULATED, _BOUND = Pen(stroke=GREY, width=1.3), Pen(stroke=BLUE, width=0.7), Pen(stroke=INK, width=0.5)
CLOSED = Pen(stroke=ORANGE, width=0.7, dash=(3.0, 1.6))
LIMIT = Pen(stroke=INK, width=0.6, dash=(2.4, 1.6))


def jobs(finding: ResponseFinding, subject: Subject) -> Iterator[Job]:
    """The plot of the residuals of the fit, where there was one."""
    if finding.runs:
        key = f"response/{subject.test}"
        yield key, partial(draw_fit, finding.runs, subject.title, label=subject.label, traces=subject.of(key),
                           language=subject.language)  # fmt: skip


def draw_verification(
    run: Mapping[str, Any], title: str, *, label: str = "", traces: Mapping[str, Trace] = MappingProxyType({}),
    language: Language = ENGLISH,
) -> Plot:  # fmt: skip
    """One held-out run: each channel measured over simulated with its band, beneath it E against ±2·u_val.

    `traces`: every sample by channel, for the plot that can be zoomed.
    """
    series = run["series"]
    height = _ROW * len(series) + 17.0
    plot = Sketch((FULL, height), (0.0, 0.0, 0.0, 0.0), label=label, language=language)
    for index, channel in enumerate(series):
        top = 10.0 + _ROW * index
        _channel(plot, channel, run, (top, height), first=index == 0, last=index == len(series) - 1)
    plot.panel((16.0, height - 9.0, 1.5, 6.5))
    names = (said("measured"), said("simulated"), said("95 % band"), said("own inputs re-estimated"), "±2 uᵥₐₗ")
    plot.legend(zip(names, (MEASURED, SIMULATED, Pen(fill=BAND), CLOSED, LIMIT), strict=True))
    return replace(plot.finish(_alt(run, title), said(_CAPTION)), series=_zoom(run, traces, language))


def _channel(
    plot: Sketch,
    channel: Mapping[str, Any],
    run: Mapping[str, Any],
    place: tuple[float, float],
    *,
    first: bool,
    last: bool,
) -> None:
    top, height = place
    span = whole(one["time"] for one in run["series"])
    time = channel["time"]
    values = [channel[key] for key in ("measured", "simulated", "low", "high")]
    factor, unit = scale(largest(*values), channel["unit"])
    plot.panel((16.0, height - top - 16.5, 1.5, top))
    plot.window(span, spread(*values, factor=factor))
    shaded(plot, run["phases"], span, named=first)
    band(plot, time, channel, factor)
    for key, pen in (("measured", MEASURED), ("simulated", SIMULATED), ("closed", CLOSED)):
        stroke(plot, time, channel[key], factor, pen)
    plot.x_axis("")
    plot.y_axis(f"{symbol(channel)} / {unit}", 4)
    _error(plot, channel, run, (top + 18.0, height), last=last)


def _error(
    plot: Sketch, channel: Mapping[str, Any], run: Mapping[str, Any], place: tuple[float, float], *, last: bool
) -> None:
    """E = S − D with ±2·u_val."""
    top, height = place
    time, error, limit = channel["time"], channel["error"], channel["twice_u_val"]
    factor, unit = scale(largest(error, limit), channel["unit"])
    plot.panel((16.0, height - top - 9.5, 1.5, top))
    span = whole(one["time"] for one in run["series"])
    plot.window(span, spread(error, limit, [-v for v in limit], factor=factor))
    for _, start, stop in run["phases"][1::2]:
        plot.shade(start, stop, SHADE)
    stroke(plot, time, error, factor, Pen(stroke=BLUE, width=0.5))
    for sign in (1.0, -1.0):
        stroke(plot, time, [sign * v for v in limit], factor, LIMIT)
    plot.x_axis(said("time / s") if last else "", 8)
    plot.y_axis(f"E / {unit}", 2)


def left(channel: Mapping[str, Any]) -> Any:
    """Measured less the best prediction."""
    return channel["closed_residual"] or [None if e is None else -e for e in channel["error"]]


def noises(*runs: Mapping[str, Any]) -> dict[str, float]:
    """Noise of one reading by channel, from the RMS of a residual and its ratio to the noise; 1 where there is none."""
    found: dict[str, float] = {}
    for run in runs:
        ratios = {one["channel"]: one["closed_rms"] for one in run["scores"] if one["name"] == "all"}
        for channel in run["series"]:
            known = [value for value in left(channel) if value is not None]
            ratio = ratios.get(channel["channel"])
            size = (sum(v * v for v in known) / len(known)) ** 0.5 if known else 0.0
            if size and ratio:
                found[channel["channel"]] = size / ratio
    return found


def _zoom(run: Mapping[str, Any], traces: Mapping[str, Trace], language: Language) -> str:
    """Every sample that there is of a run, in the display unit; E stands on the times of the channel above it."""
    panels, known = [], noises(run)
    for channel in run["series"]:
        columns = traces.get(channel["channel"], channel)
        factor, unit = scale(largest(channel["measured"], channel["simulated"]), channel["unit"])
        lines = {key: packed(columns[key], factor) for key in ("measured", "simulated", "low", "high", "closed")}
        title, count = f"{symbol(channel)} / {unit}", channel.get("count", 0)
        of_reading = {"u": known[channel["channel"]] / factor} if channel["channel"] in known else {}
        panels.append({"title": title, "count": count, "time": packed(columns["time"]), **of_reading, **lines})
        factor, unit = scale(largest(channel["error"], channel["twice_u_val"]), channel["unit"])
        lines = {key: packed(columns[key], factor) for key in ("error", "twice_u_val")}
        panels.append({"title": f"E / {unit}", "count": count, **lines})
    return as_json(panels, told(run["phases"], language))


def told(phases: Iterable[Sequence[Any]], language: Language) -> list[Sequence[Any]]:
    """Phases by their names in a language."""
    return [(language.word(name), *ends) for name, *ends in phases]


def _alt(run: Mapping[str, Any], title: str) -> str:
    units = {channel["channel"]: channel["unit"] for channel in run["series"]}
    words = [
        said(
            "{channel} {share:figures}", channel=NAMES.get(units.get(score["channel"], ""), score["channel"]),
            share=percent(score["share"]),
        )
        for score in run["scores"]
        if score["name"] == "all" and score["share"] is not None
    ]  # fmt: skip
    text = (
        "{title}, held-out run {run}: measured over simulated against time. Share of the readings with |E| ≤ 2 u_val: "
        "{shares:comma}. Verdict: {verdict}"
    )
    shares = tuple(words) or (said("none"),)
    return said(text, title=title, run=plain(run["run"]), shares=shares, verdict=run["sentence"])


_CAPTION = (
    "Held-out run: readings, prediction with its 95 % band, prediction with the run's own inputs re-estimated; beneath "
    "each, the comparison error E = S − D with ±2 u_val. Shaded: every other phase. Smallest and largest value of each "
    "column drawn."
)


def draw_fit(
    runs: Sequence[FittedRun], title: str, *, label: str = "", traces: Mapping[str, Trace] = MappingProxyType({}),
    language: Language = ENGLISH,
) -> Plot:  # fmt: skip
    """Residuals of every run that was fitted, in its noise, one row a run and one column a channel.

    `traces`: every sample by run and channel, for the plots that can be zoomed, which stand beneath the still one.
    """
    across = max((len(run.channels) for run in runs), default=1)
    height = 19.0 * len(runs) + 12.0
    plot = Sketch((FULL, height), (0.0, 0.0, 0.0, 0.0), label=label, language=language)
    width = 154.0 / across
    span = whole(channel.time for run in runs for channel in run.channels)
    for row, run in enumerate(runs):
        for column, channel in enumerate(run.channels):
            left = 15.0 + width * column
            plot.panel((left, height - 19.0 - 19.0 * row, FULL - left - width + 9.0, 5.0 + 19.0 * row))
            _residual(plot, channel, span, last=row == len(runs) - 1, first=column == 0)
            plot.note(_name(run, channel), span[0], rise=1.0)
    alt = "{title}: residuals of the fit over time for {count} runs, in standard uncertainties of one reading. {runs}"
    named = tuple(said("{run}: {spread:figures}", run=plain(run.run), spread=_spread(run)) for run in runs)
    caption = said(
        "Residuals of the runs that were fitted (measured less fitted) in standard uncertainties of one reading; "
        "dashed: ±2. What is not noise is what the model does not know."
    )
    finished = plot.finish(said(alt, title=title, count=len(runs), runs=named), caption)
    panels = [
        _residual_zoom(run, channel, traces.get(f"{run.run}/{channel.channel}", {}), language)
        for run in runs
        for channel in run.channels
        if channel.time
    ]
    return replace(finished, series=as_json(panels, beneath=True))


def _name(run: FittedRun, channel: ChannelFit) -> str:
    return f"{plain(run.run, 24)}: {SYMBOLS.get(channel.unit, channel.channel)}"


def _residual_zoom(run: FittedRun, channel: ChannelFit, trace: Trace, language: Language) -> dict[str, Any]:
    """Every sample that there is of a residual, and the two lines that noise stays between nineteen times in twenty."""
    time, residual = trace.get("time", channel.time), trace.get("residual", channel.residual)
    ends = [float(time[0]), float(time[-1])]
    limits = [
        {"name": name, "role": "limit", "x": ends, "y": [level, level]} for name, level in (("+2 u", 2), ("−2 u", -2))
    ]
    return {
        "name": _name(run, channel),
        "title": language.say("residual / u"),
        "count": channel.count,
        "time": packed(time),
        "curves": [
            {"name": language.say("residual"), "role": "residual", "y": packed(residual, channel.noise)},
            *limits,
        ],
    }


def _residual(plot: Sketch, channel: ChannelFit, span: tuple[float, float], *, last: bool, first: bool) -> None:
    if not channel.time:
        return
    reach = max(4.0, ceil(1.05 * largest(channel.residual) / channel.noise))
    plot.window(span, (-reach, reach))
    stroke(plot, channel.time, channel.residual, channel.noise, Pen(stroke=BLUE, width=0.4))
    for level in (-2.0, 2.0):
        plot.line((channel.time[0], channel.time[-1]), (level, level), LIMIT)
    plot.x_axis(said("time / s") if last else "", 4)
    plot.y_axis("r / u" if first else "", 2)


def _spread(run: FittedRun) -> str:
    return ", ".join(
        f"{channel.channel} RMS {number((channel.rms or 0.0) / channel.noise, 3)}" for channel in run.channels
    )
