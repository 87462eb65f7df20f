"""One held-out run by two models: readings over the model as stated and the extended one, and the residuals of both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import number, scale
from metrology.message import said
from metrology.report.figures import over_time, response
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, BLUE, FULL, ORANGE, Plot, plain
from metrology.report.figures.zoom import as_json, packed

if TYPE_CHECKING:
    from metrology.timeseries import Trace

Array = npt.NDArray[np.float64]
ROW = 29.0
"""Height in mm of one channel: readings and residuals."""
CAPTION = (
    "Held-out run: readings, the model as stated and the extended model, each with the run's own inputs re-estimated, "
    "and the 95 % band in which the extended model predicts the run; beneath each channel, the residuals of both "
    "models over the noise of one reading, with ±2. Shaded: every other phase."
)


def draw(
    stated: Mapping[str, Any], extended: Mapping[str, Any], title: str, *, label: str = "",
    traces: Mapping[str, Mapping[str, Trace]] = MappingProxyType({}), language: Language = ENGLISH,
) -> Plot:  # fmt: skip
    """Each channel measured over both models, beneath it the residuals of both over the noise.

    Parameters
    ----------
    stated, extended : mapping
        The run, as the verification of each model holds it.
    title : str
        Of the test.
    label : str
        Mark on the plot.
    traces : mapping
        Every sample, by ``'stated'`` and ``'extended'``, then by channel, for the plot that can be zoomed.
    language : Language
        Of its words.
    """
    pairs = list(zip(stated["series"], extended["series"], strict=True))
    height = ROW * len(pairs) + 17.0
    plot = Sketch((FULL, height), (0.0, 0.0, 0.0, 0.0), label=label, language=language)
    span = over_time.whole(one["time"] for one in extended["series"])
    scales = response.noises(stated, extended)
    for index, pair in enumerate(pairs):
        top = 10.0 + ROW * index
        _channel(plot, pair, extended["phases"], (span, top, height), first=index == 0)
        _residuals(plot, pair, extended["phases"], (span, top + 17.0, height), scales, last=index == len(pairs) - 1)
    plot.panel((16.0, height - 9.0, 1.5, 6.5))
    names = (said("measured"), said("model as stated"), said("extended model"), said("95 % band"), "±2")
    pens = (response.MEASURED, response.CLOSED, response.SIMULATED, Pen(fill=BAND), response.LIMIT)
    plot.legend(zip(names, pens, strict=True))
    finished = plot.finish(_alt(stated, extended, title), said(CAPTION))
    return replace(finished, series=_zoom(pairs, extended["phases"], traces, scales, language))


def best(channel: Mapping[str, Any]) -> Any:
    """Prediction with the run's own inputs re-estimated, where there are any."""
    return channel["closed"] or channel["simulated"]


def _channel(
    plot: Sketch, pair: tuple[Mapping[str, Any], Mapping[str, Any]], phases: Any,
    place: tuple[tuple[float, float], float, float], *, first: bool,
) -> None:  # fmt: skip
    (before, after), (span, top, height) = pair, place
    values = [before["measured"], best(before), best(after), after["low"], after["high"]]
    factor, unit = scale(over_time.largest(*values), after["unit"])
    plot.panel((16.0, height - top - 15.0, 1.5, top))
    plot.window(span, over_time.spread(*values, factor=factor))
    over_time.shaded(plot, phases, span, named=first)
    over_time.band(plot, after["time"], after, factor)
    over_time.stroke(plot, after["time"], after["measured"], factor, response.MEASURED)
    over_time.stroke(plot, before["time"], best(before), factor, response.CLOSED)
    over_time.stroke(plot, after["time"], best(after), factor, response.SIMULATED)
    plot.x_axis("")
    plot.y_axis(f"{over_time.symbol(after)} / {unit}", 4)


def _residuals(
    plot: Sketch, pair: tuple[Mapping[str, Any], Mapping[str, Any]], phases: Any,
    place: tuple[tuple[float, float], float, float], noises: Mapping[str, float], *, last: bool,
) -> None:  # fmt: skip
    (before, after), (span, top, height) = pair, place
    noise = noises.get(after["channel"], 1.0)
    plot.panel((16.0, height - top - 10.0, 1.5, top))
    plot.window(
        span, over_time.spread(response.left(before), response.left(after), (2 * noise, -2 * noise), factor=noise)
    )
    over_time.shaded(plot, phases, span, named=False)
    over_time.stroke(plot, before["time"], response.left(before), noise, Pen(stroke=ORANGE, width=0.5))
    over_time.stroke(plot, after["time"], response.left(after), noise, Pen(stroke=BLUE, width=0.5))
    for level in (2.0, -2.0):
        plot.line(span, (level, level), response.LIMIT)
    plot.x_axis(said("time / s") if last else "", 8)
    plot.y_axis("r / u", 2)


def _zoom(
    pairs: list[tuple[Mapping[str, Any], Mapping[str, Any]]], phases: Any, traces: Mapping[str, Mapping[str, Trace]],
    noises: Mapping[str, float], language: Language,
) -> str:  # fmt: skip
    """Every sample that there is, both models on the times of the readings."""
    panels = []
    for before, after in pairs:
        name = after["channel"]
        one = _columns(traces.get("stated", {}).get(name), before)
        other = _columns(traces.get("extended", {}).get(name), after)
        factor, unit = scale(over_time.largest(after["measured"], best(after)), after["unit"])
        # What results.json keeps of each model stands at times of its own.
        stated = np.interp(other["time"], one["time"], one["best"])
        lines = {key: packed(other[key], factor) for key in ("measured", "low", "high")}
        lines |= {"simulated": packed(other["best"], factor), "closed": packed(stated, factor)}
        count, noise = after.get("count", 0), noises.get(name, 1.0)
        known = {"u": noise / factor} if name in noises else {}
        panels.append({"title": f"{over_time.symbol(after)} / {unit}", "count": count, "time": packed(other["time"]),
                       "models": True, **known, **lines})  # fmt: skip
        gap = other["measured"] - other["best"], other["measured"] - stated
        panels.append({"title": language.say("residual / u"), "count": count, "time": packed(other["time"]),
                       "error": packed(gap[0], noise), "other": packed(gap[1], noise),
                       "twice_u_val": packed(0 * gap[0] + 2 * noise, noise)})  # fmt: skip
    return as_json(panels, response.told(phases, language))


def _columns(trace: Trace | None, channel: Mapping[str, Any]) -> dict[str, Array]:
    """Every sample that there is of a channel by one model, else what the findings hold; NaN for a gap."""
    found = channel if trace is None else trace
    names = {"best": "closed" if channel["closed"] else "simulated"}
    keys = ("time", "measured", "low", "high", "best")
    return {key: np.array(found[names.get(key, key)], float) for key in keys}


def _alt(stated: Mapping[str, Any], extended: Mapping[str, Any], title: str) -> str:
    after = {one["channel"]: one["closed_rms"] for one in extended["scores"] if one["name"] == "all"}
    changes = "{channel} {before:figures} to {after:figures}"
    words = [
        said(changes, channel=one["channel"], before=number(one["closed_rms"]), after=number(after.get(one["channel"])))
        for one in stated["scores"]
        if one["name"] == "all" and one["closed_rms"] is not None
    ]
    text = (
        "{title}, held-out run {run}: readings, model as stated and extended model against time. Residual over noise "
        "from the model as stated to the extended one: {changes:comma}. Verdict of the extended model: {verdict}"
    )
    rows = tuple(words) or (said("none"),)
    return said(text, title=title, run=plain(extended["run"]), changes=rows, verdict=extended["sentence"])
