"""Spectra of the residuals of a model, and of what its columns had of white noise."""

from __future__ import annotations

from dataclasses import dataclass

from metrology.diagnostics.span import Span
from metrology.diagnostics.subject import Array, Fit
from metrology.noise import power_of


@dataclass(frozen=True)
class Spectrum:
    """Of one record: power of what is left, and what the columns that were taken out of white noise had of it."""

    left: Array
    absorbed: Array


def segments(fit: Fit) -> list[slice]:
    """Rows of each channel of each block within the stack."""
    found, first = [], 0
    for block in fit.problem.blocks:
        for segment in block.segments:
            found.append(slice(first, first + segment.last - segment.first))
            first = found[-1].stop
    return found


def spectra_of(fit: Fit, taken: Span, left: Array) -> tuple[Spectrum, ...]:
    """Spectra of what is left, and of what was taken, of each channel of each block."""
    records = ((left[rows, None], taken.rows(rows)) for rows in segments(fit))
    return tuple(Spectrum(*(power_of(columns) / len(columns) for columns in record)) for record in records)
