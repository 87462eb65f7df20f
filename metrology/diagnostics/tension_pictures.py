"""What diagnosis shows of the records of a tension test: residuals against load and time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from metrology.diagnosis import Curve, Missing, Picture
from metrology.diagnostics.pictures import ROLES, curve, extremes
from metrology.diagnostics.plain_reported import binned
from metrology.diagnostics.subject import Array, Fit
from metrology.diagnostics.tension_records import Record
from metrology.message import said


def gap(records: Sequence[Record], fit: Fit) -> Missing | None:
    """Residual extension against force and time."""
    u = np.concatenate([one.u for one in records])
    columns = {("force", "N"): np.concatenate([one.seen.force for one in records]),
               ("time", "s"): np.concatenate([one.seen.time for one in records])}  # fmt: skip
    return binned(said("missing {what}", what="extension"), "m", columns, np.concatenate(fit.residuals) * u, u)


def pictures(records: Sequence[Record], before: Fit, after: Fit | None) -> tuple[Picture, ...]:
    """Residual against load, crosshead and extensometer apart, and over time."""
    fits = [(role, name, fit) for (role, name), fit in zip(ROLES, (before, after), strict=True) if fit is not None]
    against: list[Curve] = []
    over: list[Curve] = []
    for role, name, fit in fits:
        residual = np.concatenate([part * one.u for part, one in zip(fit.residuals, records, strict=True)])
        force, time, head = (np.concatenate([getattr(one.seen, key) for one in records])
                             for key in ("force", "time", "crosshead"))  # fmt: skip
        for channel, kind in ((said("crosshead"), 1.0), (said("extensometer"), 0.0)):
            rows = head == kind
            if rows.any():
                named = said("{what}, {model}", what=channel, model=name)
                against.append(_sorted(role, named, force[rows], residual[rows]))
        over.append(_sorted(role, name, time, residual))
    return (
        Picture("load", said("Residual against load"), "force", "N", said("residual"), "m", tuple(against),
                said("A line in the crosshead is the set-up; a curve in both is the specimen, in one its reading.")),
        Picture("order", said("Residual over time"), "time", "s", said("residual"), "m", tuple(over),
                said("A step is a slip, a slope drift or creep.")),
    )  # fmt: skip


def _sorted(role, name: str, x: Array, y: Array) -> Curve:  # type: ignore[no-untyped-def]
    order = np.argsort(x, kind="stable")
    return curve(role, name, *extremes(x[order], y[order]))
