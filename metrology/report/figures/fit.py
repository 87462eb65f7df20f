"""A calibration line or curve: data, fit with its band, residuals beneath."""

from __future__ import annotations

import numpy as np

from metrology.findings import Fit
from metrology.report.display import scale
from metrology.report.figures.style import BAND, BLUE, FULL, GREY, INK, Plot, canvas, finish, legend, place, plain


def draw(fit: Fit, *, label: str = "") -> Plot:
    """Data and curve with the band of ±2 standard uncertainties; residuals with the residual standard deviation."""
    x_factor, x_unit = scale(max(map(abs, fit.x), default=0.0), fit.x_unit)
    y_factor, y_unit = scale(max(map(abs, fit.y), default=0.0), fit.y_unit)
    x, y = np.array(fit.x) / x_factor, np.array(fit.y) / y_factor
    curve_x, curve_y, curve_u = (
        np.array(fit.curve_x),
        np.array(fit.curve_y) / y_factor,
        np.array(fit.curve_u) / y_factor,
    )
    figure = canvas(FULL, 74.0, label=label)
    upper = place(figure, (15.0, 31.0, 1.5, 7.0))
    lower = place(figure, (15.0, 9.0, 1.5, 48.0), sharex=upper)
    upper.fill_between(
        curve_x / x_factor, curve_y - 2 * curve_u, curve_y + 2 * curve_u, color=BAND, lw=0, label="±2u of the fit"
    )
    upper.plot(curve_x / x_factor, curve_y, color=INK, lw=0.8, label="fit")
    upper.plot(x, y, "o", color=BLUE, ls="none", label="data")
    upper.set_ylabel(f"{'y'} / {y_unit}" if y_unit else "y")
    upper.tick_params(labelbottom=False)
    legend(upper)
    residual = y - np.interp(x, curve_x / x_factor, curve_y)
    lower.axhline(0.0, color=GREY, lw=0.5)
    if fit.residual_standard_deviation:
        half = 2 * fit.residual_standard_deviation / y_factor
        lower.axhspan(-half, half, color=BAND, lw=0)
    lower.plot(x, residual, "o", color=BLUE, ls="none")
    lower.set_ylabel(f"residual / {y_unit}" if y_unit else "residual")
    lower.set_xlabel(f"{'x'} / {x_unit}" if x_unit else "x")
    alt = (
        f"Fit {plain(fit.name)}, model {plain(fit.model)}: {len(fit.x)} points with the fitted curve "
        f"and its band of twice the standard "
        f"uncertainty; beneath, the residuals. {fit.sentence}"
    )
    return finish(
        figure,
        alt,
        "Data, fit and its band of ±2 standard uncertainties; beneath, residuals with ±2 residual standard deviations.",
    )
