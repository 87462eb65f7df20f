"""A calibration line or curve: data, fit with its band, residuals beneath."""

from __future__ import annotations

import numpy as np

from metrology.findings import Fit
from metrology.language.catalogue import ENGLISH, Language
from metrology.language.display import scale
from metrology.message import said
from metrology.report.figures.marks import Mark
from metrology.report.figures.shapes import Pen
from metrology.report.figures.sketch import Sketch
from metrology.report.figures.style import BAND, BLUE, FULL, GREY, INK, NAMES, Plot, plain

_LINE, _DATA = Pen(stroke=INK, width=0.8), Mark("o", BLUE)


def draw(fit: Fit, *, label: str = "", language: Language = ENGLISH) -> Plot:
    """Data and curve with the band of ±2 standard uncertainties; residuals with the residual standard deviation."""
    x_factor, x_unit = scale(max(map(abs, fit.x), default=0.0), fit.x_unit)
    y_factor, y_unit = scale(max(map(abs, fit.y), default=0.0), fit.y_unit)
    x, y = np.array(fit.x) / x_factor, np.array(fit.y) / y_factor
    curve_x, curve_y = np.array(fit.curve_x) / x_factor, np.array(fit.curve_y) / y_factor
    half = 2 * np.array(fit.curve_u) / y_factor
    plot = Sketch((FULL, 74.0), (15.0, 31.0, NAMES, 2.0), label=label, language=language)
    xs = [*x.tolist(), *curve_x.tolist()]
    ys = [*y.tolist(), *(curve_y - half).tolist(), *(curve_y + half).tolist()]
    span = (min(xs, default=0.0), max(xs, default=1.0))
    margin, lift = 0.02 * (span[1] - span[0]), 0.05 * (max(ys, default=1.0) - min(ys, default=0.0))
    span = (span[0] - margin, span[1] + margin)
    plot.window(span, (min(ys, default=0.0) - lift, max(ys, default=1.0) + lift))
    plot.band(curve_x.tolist(), (curve_y - half).tolist(), (curve_y + half).tolist(), BAND)
    plot.line(curve_x.tolist(), curve_y.tolist(), _LINE)
    plot.dots(x.tolist(), y.tolist(), _DATA)
    plot.x_axis("")
    plot.y_axis(f"y / {y_unit}" if y_unit else "y", 5)
    last = float(curve_y[-1]) if curve_y.size else 0.0
    of_fit = (said("±2u of the fit"), last, Pen(fill=BAND)), (said("fit"), last, _LINE)
    plot.labels((*of_fit, (said("data"), float(y[np.argmax(x)]), _DATA)))
    residual = y - np.interp(x, curve_x, curve_y)
    spread = 2 * (fit.residual_standard_deviation or 0.0) / y_factor
    reach = 1.1 * max(float(np.max(np.abs(residual), initial=0.0)), spread) or 1.0
    plot.panel((15.0, 9.0, NAMES, 48.0))
    plot.window(span, (-reach, reach))
    if spread:
        plot.band(span, (-spread, -spread), (spread, spread), BAND)
    plot.level(0.0, Pen(stroke=GREY, width=0.5))
    plot.dots(x.tolist(), residual.tolist(), _DATA)
    plot.y_axis(said("residual / {unit}", unit=y_unit) if y_unit else said("residual"), 3)
    plot.x_axis(f"x / {x_unit}" if x_unit else "x", 8)
    text = (
        "Fit {name}, model {model}: {count} points with the fitted curve and its band of twice the standard "
        "uncertainty; beneath, the residuals. {sentence}"
    )
    alt = said(text, name=plain(fit.name), model=plain(fit.model), count=len(fit.x), sentence=fit.sentence)
    caption = (
        said(
            "Data, fit and its band of ±2 standard uncertainties; beneath, residuals with ±2 residual standard "
            "deviations."
        )
        if spread
        else said("Data, fit and its band of ±2 standard uncertainties; beneath, residuals.")
    )
    return plot.finish(alt, caption)
