"""Results as plain tables, for Simulink, Modelica and whatever reads CSV and JSON."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable, Sequence
from io import StringIO
from math import isfinite
from typing import Any

from metrology.errors import Fault, MetrologyError
from metrology.export.line import Words, heading
from metrology.export.series import Series, series
from metrology.findings import Findings, Result

SCHEMA = "metrology-parameters/1"


def files(findings: Findings, use: Sequence[str] = ()) -> dict[str, bytes]:
    """Parameters with u, distribution and correlations, and what was measured and simulated over time.

    Parameters
    ----------
    findings : Findings
    use : sequence of str
        Full names of the results that are wanted; all of them where empty.

    Returns
    -------
    dict
        ``parameters.csv``, ``correlations.csv``, ``parameters.json``, and ``series/TEST-RUN-CHANNEL.csv``.

    Raises
    ------
    MetrologyError
        For a name in `use` that is none of a result.
    """
    chosen = chosen_results(findings, use)
    matrix = _correlations(findings, chosen)
    words = Words(_plain)
    made = {f"series/{words(one.test, one.run, one.channel)}.csv": one for one in series(findings)}
    shown = [_entry(one) for one in chosen]
    keys = ("parameter", "value", "unit", "u", "distribution", "dof", "low", "high", "p", "sample", "test")
    named = [("", *(one.name for one in chosen)), *((o.name, *r) for o, r in zip(chosen, matrix, strict=True))]
    return {
        "parameters.csv": _csv([keys, *([one[key] for key in keys] for one in shown)]),
        "correlations.csv": _csv(named),
        "parameters.json": _json(findings, shown, matrix, made),
        **{name: _csv([tuple(one.columns), *zip(*one.columns.values(), strict=True)]) for name, one in made.items()},
    }


def chosen_results(findings: Findings, use: Sequence[str]) -> list[Result]:
    """Results by name, all of them where no name is given.

    Raises
    ------
    MetrologyError
        For a name that none of them has.
    """
    names = [one.name for one in findings.results]
    if unknown := [name for name in use if name not in names]:
        raise MetrologyError(*(Fault("--use", f"'{name}'", f"one of {', '.join(names)}") for name in unknown))
    return [one for one in findings.results if not use or one.name in use]


def _entry(result: Result) -> dict[str, Any]:
    low, high = result.interval
    entry = {
        "parameter": result.name, "quantity": result.quantity, "sample": result.sample, "test": result.test,
        "value": result.value, "unit": result.unit, "u": result.u, "distribution": _distribution(result),
        "dof": result.dof, "low": low, "high": high, "p": result.coverage.p,
        "density": None if result.monte_carlo.law_valid else _density(result),
        "stated": None if result.stated is None else {"value": result.stated.value, "u": result.stated.u},
    }  # fmt: skip
    return {key: None if isinstance(one, float) and not isfinite(one) else one for key, one in entry.items()}


def _distribution(result: Result) -> str:
    """Of the interval that is reported: the one of the framework where JCGM 101, clause 8, confirms it."""
    if not result.monte_carlo.law_valid:
        return "monte carlo"
    return "normal" if result.dof is None else "t"


def _density(result: Result) -> dict[str, Any]:
    return {"edges": list(result.monte_carlo.edges), "density": list(result.monte_carlo.density)}


def _correlations(findings: Findings, chosen: Sequence[Result]) -> list[list[float]]:
    known = {frozenset((one.a, one.b)): one.coefficient for one in findings.correlations}
    return [[1.0 if a is b else known.get(frozenset((a.name, b.name)), 0.0) for b in chosen] for a in chosen]


def _plain(parts: Sequence[str]) -> str:
    return re.sub(r"[^A-Za-z0-9._-]+", "-", "-".join(filter(None, parts)))


def _json(findings: Findings, shown: list[dict[str, Any]], matrix: list[list[float]], made: dict[str, Series]) -> bytes:
    names = [one["parameter"] for one in shown]
    document = {
        "schema": SCHEMA,
        "campaign": findings.campaign.id,
        "notices": heading(findings, "Parameters"),
        "parameters": shown,
        "correlations": {"names": names, "matrix": matrix},
        "series": [
            {"file": name, "test": one.test, "run": one.run, "channel": one.channel, "unit": one.unit,
             "noise": one.noise if isfinite(one.noise) else None, "readings": one.count,
             "kept": len(one.columns["time"])}
            for name, one in made.items()
        ],
    }  # fmt: skip
    return (json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _csv(rows: Iterable[Sequence[Any]]) -> bytes:
    stream = StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerows([["" if one is None or one != one else one for one in row] for row in rows])
    return stream.getvalue().encode()
