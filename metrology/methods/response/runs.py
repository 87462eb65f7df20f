"""The runs of a response test as measured: channels with their stamps, thrust, start, and readings left out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from metrology.coordinate import Coordinate
from metrology.methods.response.schema import ResponseTest, StatedRun, Thrusting

if TYPE_CHECKING:
    import numpy as np

    from metrology.declaration.columns import Table
    from metrology.estimation import MeasuredRun
    from metrology.method.declared import Declared
    from metrology.rig import Force


def measured_runs(campaign: Declared, name: str, test: ResponseTest) -> tuple[MeasuredRun, ...]:
    """Return the runs of a test with their readings."""
    from metrology.methods.response.checks import run_tables

    tables = run_tables(campaign.tables["tests", name], test)
    excluded = {(exclusion.file, exclusion.line) for exclusion in test.exclusions}
    noise = {channel: stated.si for channel, stated in dict(test.noise).items() if stated is not None}
    return tuple(
        _run(run_name, run, tables[run_name], (excluded, noise), test.rig.coordinate)
        for run_name, run in test.runs.items()
    )


def _run(
    name: str,
    run: StatedRun,
    tables: tuple[Table, ...],
    known: tuple[set[tuple[str | None, int | None]], Mapping[str, float]],
    coordinate: Coordinate,
) -> MeasuredRun:
    import numpy as np

    from metrology.estimation import MeasuredRun
    from metrology.rig import Run

    excluded, noise = known
    stamps: dict[str, Any] = {}
    readings: dict[str, Any] = {}
    use: dict[str, Any] = {}
    for table in tables:
        dropped = [line for file, line in excluded if line is not None and file in (None, table.name)]
        for channel in ("x", "v", "T"):
            if channel in table.numbers:
                stamps[f"t_{channel}"], readings[channel] = table.numbers["time"], table.numbers[channel]
                if dropped:
                    use[channel] = ~np.isin(table.lines, dropped)
    begin = min(float(table.numbers["time"][0]) for table in tables)
    return MeasuredRun(
        name,
        Run(
            x0=run.start.position.si,
            v0=run.start.velocity.si,
            t0=begin,
            held_until=run.held_until.si if run.held_until else None,
            force=_force(run.thrust, tables),
            **stamps,
        ),
        noise={channel: size for channel, size in noise.items() if channel in readings},
        use=use,
        purpose=run.purpose,
        coordinate=coordinate,
        **readings,
    )


def _force(stated: tuple[Thrusting, ...] | None, tables: tuple[Table, ...]) -> Force | None:
    from metrology.rig import Force

    for table in tables:
        if "F" in table.numbers:
            return Force(table.numbers["time"], table.numbers["F"], "linear")
    if not stated:
        return None
    profile: dict[float, float] = {}
    for part in stated:
        profile[part.from_.si] = part.size.si
        if part.to is not None:
            profile[part.to.si] = 0.0
    return Force(_array(list(profile)), _array(list(profile.values())))


def _array(values: list[float]) -> np.ndarray[Any, Any]:
    import numpy as np

    return np.array(values)
