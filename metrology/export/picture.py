"""The control chart as SVG, as one HTML file that works offline, and as CSV."""

from __future__ import annotations

import csv
from html import escape
from io import StringIO

from metrology.export.control import Chart
from metrology.language.display import rounded, scale
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BLUE, GREY, ORANGE, Plot, plain

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
_STYLE = (
    "body{font:15px/1.45 'DejaVu Sans',Verdana,sans-serif;color:#1b1f24;max-width:58rem;margin:2rem auto}"
    "h1{font-size:1.4rem;color:#0b2f52}svg{width:100%;height:auto}table{border-collapse:collapse;width:100%}"
    "th,td{text-align:left;padding:.25rem .6rem .25rem 0;border-bottom:1px solid #d5dae0}.number{text-align:right}"
)


def files(chart: Chart, stem: str) -> dict[str, bytes]:
    """Return the files of a chart by name."""
    return {
        f"{stem}.csv": _csv(chart),
        f"{stem}.svg": draw(chart).svg.encode(),
        f"{stem}.html": _html(chart).encode(),
    }


def draw(chart: Chart) -> Plot:
    """The chart: every result with its uncertainty, mean, warning and action limits."""
    size, unit = scale(chart.mean, chart.unit)
    sketch = Sketch((170.0, 80.0), (18.0, 11.0, 16.0, 10.0))
    days = [float(i) for i, _ in enumerate(chart.points, 1)]
    values = [point.value / size for point in chart.points]
    doubled = [2 * point.u / size for point in chart.points]
    ends = [*chart.action, *(v * size for v in values), *((v - d) * size for v, d in zip(values, doubled, strict=True))]
    ends += [(v + d) * size for v, d in zip(values, doubled, strict=True)]
    sketch.window((0.4, len(days) + 0.6), (min(ends) / size, max(ends) / size))
    sketch.level(chart.mean / size, Pen(stroke=BLUE, width=0.9))
    for pair, dash, word in ((chart.warning, (4.0, 2.0), "warning"), (chart.action, (), "action")):
        for end in pair:
            sketch.level(end / size, Pen(stroke=ORANGE, width=0.8, dash=dash))
            sketch.text(word, (len(days) + 0.65, end / size))
    sketch.errors(days, values, doubled, Pen(stroke=GREY, width=0.8))
    sketch.dots(days, values, Mark("o", BLUE, 3.6))
    sketch.x_axis("result, by date", min(max(len(days), 2), 10))
    sketch.y_axis(f"{plain(chart.name)} / {unit or '1'}", 5)
    alt = f"Control chart of {plain(chart.name)} with ±2u of each result. {plain(chart.sentence, 400)}"
    return sketch.finish(alt, chart.sentence)


def _csv(chart: Chart) -> bytes:
    stream = StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\r\n")
    writer.writerow(
        (
            "date",
            "report",
            "value",
            "u",
            "unit",
            "mean",
            "s",
            "warning_low",
            "warning_high",
            "action_low",
            "action_high",
        )
    )
    for point in chart.points:
        report = f"'{point.report}" if point.report.startswith(("=", "+", "-", "@")) else point.report
        limits = (chart.mean, chart.s, *chart.warning, *chart.action)
        writer.writerow((point.date.isoformat(), report, point.value, point.u, chart.unit, *limits))
    return stream.getvalue().encode()


def _html(chart: Chart) -> str:
    plot = draw(chart)
    size, unit = scale(chart.mean, chart.unit)
    rows = "".join(
        f'<tr><td>{point.date.isoformat()}</td><td>{escape(point.report)}</td><td class="number">{value}</td>'
        f'<td class="number">{u}</td></tr>'
        for point in chart.points
        for value, u in [rounded(point.value / size, point.u / size)]
    )
    head = f'<th>Date</th><th>Report</th><th class="number">Value / {escape(unit or "1")}</th><th class="number">u</th>'
    picture = plot.svg.replace("<svg ", f'<svg role="img" aria-label="{escape(plot.alt)}" ', 1)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta http-equiv="Content-Security-Policy" '
        f'content="{_POLICY}"><title>Control chart of {escape(chart.name)}</title><style>{_STYLE}</style></head>\n'
        f"<body><h1>Control chart of {escape(chart.name)}</h1><p>{escape(chart.sentence)}</p>{picture}"
        f"<p>Points with ±2 standard uncertainties; limits from the moving ranges (ISO 7870-2).</p>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></body></html>\n"
    )
