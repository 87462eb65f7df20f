"""What was measured over time and what was simulated of it, out of findings: one table a test, run and channel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import nan

from metrology.findings import Findings

Column = tuple[float, ...]


@dataclass(frozen=True)
class Series:
    """One channel of one run, in SI; a gap is NaN.

    Parameters
    ----------
    test, run, channel, unit : str
        What was read, where.
    columns : mapping
        Numbers by name: ``time`` / s, ``measured``, ``simulated``, and what the results hold besides.
    noise : float
        Standard uncertainty of one reading; NaN where the results have none.
    count : int
        Readings of the channel. Of a long one the results keep the smallest and the largest of each short stretch.
    """

    test: str
    run: str
    channel: str
    unit: str
    columns: Mapping[str, Column]
    noise: float
    count: int

    @property
    def name(self) -> str:
        """Test, run and channel in one word."""
        return "-".join(part for part in (self.test, self.run, self.channel) if part)


def series(findings: Findings) -> Iterator[Series]:
    """Every channel over time: of releases, of runs that were fitted, and of runs that judged the model."""
    for test in findings.tests:
        if test.decay is not None:
            for one in test.decay.records:
                columns = {"time": one.time, "measured": one.displacement, "simulated": one.fit}
                if one.time:
                    yield Series(test.id, one.record, "x", one.unit, columns, one.noise, one.count)
        if test.response is not None:
            for run in test.response.runs:
                for fit in run.channels:
                    columns = {"time": fit.time, "measured": _numbers(fit.measured), "simulated": fit.fitted}
                    yield Series(test.id, run.run, fit.channel, fit.unit, columns, fit.noise, fit.count)
    yield from _held_out(findings)


def _held_out(findings: Findings) -> Iterator[Series]:
    for check in findings.verification:
        basis = "" if check.get("basis", "stated") == "stated" else f" {check['basis']}"
        for run in check["runs"]:
            for one in run["series"]:
                names = {"time": "time", "measured": "measured", "simulated": "simulated", "low": "low", "high": "high"}
                columns = {name: _numbers(one[key]) for name, key in names.items()}
                where = (check["test"], f"{run['run']}{basis}", one["channel"], one["unit"])
                yield Series(*where, columns, nan, one["count"])


def _numbers(values: Sequence[float | None]) -> Column:
    return tuple(nan if value is None else value for value in values)
