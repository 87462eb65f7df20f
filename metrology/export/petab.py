"""Readings and parameters as a problem for other estimators, in the tables of PEtab 1.

Tables, columns and rules: the PEtab data format specification, version 1 (petab.readthedocs.io). PEtab asks for a model
in SBML: an elongation needs none besides its formula, so that the model written here is empty; that of a motion is the
reader's own, with the names that the tables have.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from math import isfinite, sqrt
from typing import Any

from metrology.elongation import ElongationFinding
from metrology.errors import Fault, MetrologyError
from metrology.export.line import Words, heading
from metrology.export.parameters import chosen_results
from metrology.export.series import Series, series
from metrology.findings import Findings, Result

_MODEL = b"""<?xml version="1.0" encoding="UTF-8"?>
<sbml xmlns="http://www.sbml.org/sbml/level3/version1/core" level="3" version="1"><model id="line"/></sbml>
"""
_WIDE = 10
"""Upper bound of a parameter that is positive, over its value; else how many u its bounds are away."""
Row = Mapping[str, Any]


@dataclass
class Tables:
    """The tables as they grow, a row each; `tests` are in them; `words` names what they hold.

    `moves`: the model has to be the reader's own.
    """

    parameters: list[Row] = field(default_factory=list)
    observables: dict[str, Row] = field(default_factory=dict)
    measurements: list[Row] = field(default_factory=list)
    conditions: dict[str, Row] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    tests: set[str] = field(default_factory=set)
    words: Words = field(default_factory=Words)
    moves: bool = False


def files(findings: Findings, use: Sequence[str] = ()) -> dict[str, bytes]:
    """Parameters to be estimated, observables, measurements and conditions, with the file that names them.

    Parameters
    ----------
    findings : Findings
    use : sequence of str
        Full names of the results that are parameters; every k and c of a test where empty.

    Returns
    -------
    dict
        ``problem.yaml``, ``parameters.tsv``, ``observables.tsv``, ``measurements.tsv``, ``conditions.tsv``, and
        ``model.xml`` where the formulae of the observables are the whole model.

    Raises
    ------
    MetrologyError
        Where no test has readings that are kept, and for a name in `use` that is none of a result.
    """
    tables = Tables()
    named = chosen_results(findings, use)
    sought = [one for one in named if (use or one.quantity in ("k", "c")) and isfinite(one.value + one.u)]
    tests = {one.test for one in sought}
    for test in findings.tests:
        if test.elongation is not None and test.id in tests:
            _add_elongation(tables, test.id, test.elongation)
    for one in series(findings):
        if one.test in tests and one.noise > 0:
            _add_series(tables, one)
    tables.parameters += [_parameter(one, tables.words) for one in sought if one.test in tables.tests]
    if not tables.measurements:
        raise MetrologyError(
            Fault(findings.campaign.id, "no readings for an estimate", "a test by elongation, free decay or response")
        )
    made = {
        "problem.yaml": _problem(findings, tables.notes),
        "parameters.tsv": _tsv(tables.parameters),
        "observables.tsv": _tsv(tables.observables.values()),
        "measurements.tsv": _tsv(tables.measurements),
        "conditions.tsv": _tsv(tables.conditions.values()),
    }
    return made if tables.moves else {**made, "model.xml": _MODEL}


def _parameter(result: Result, words: Words) -> Row:
    reach = _WIDE * result.u
    ends = (0.0, _WIDE * result.value) if result.value > 0 else (result.value - reach, result.value + reach)
    name = words(result.quantity, result.test)
    return _parameter_row(name, result.value, ends, of=(result.u, result.unit, result.name))


def _parameter_row(name: str, value: float, ends: tuple[float, float], *, of: tuple[float, str, str]) -> Row:
    """A parameter without a prior: what is known of it comes out of these very readings."""
    u, unit, source = of
    low, high = ends
    return {
        "parameterId": name, "parameterName": source, "parameterScale": "lin", "lowerBound": low, "upperBound": high,
        "nominalValue": value, "estimate": 1, "u": u, "unit": unit,
    }  # fmt: skip


def _add_elongation(tables: Tables, test: str, finding: ElongationFinding) -> None:
    """The line through load and extension: x = x₀ + F/k, with F as the parameter of each reading."""
    used = [at for at, reason in enumerate(finding.excluded) if not reason]
    scatter = sqrt(sum(finding.residual[at] ** 2 for at in used) / (len(used) - 2))
    if scatter == 0:
        tables.notes.append(f"{test}: no reading parts from the line, so that nothing weighs them; left out")
        return
    tables.tests.add(test)
    words = tables.words
    observable, zero, condition = words("x", test), words("x0", test), words(test)
    reach = max(abs(finding.extension[at]) for at in used)
    source = (finding.slope_u * max(finding.force), "m", f"zero of the readings of {test}")
    tables.parameters.append(_parameter_row(zero, finding.intercept, (-reach, reach), of=source))
    formula = f"{zero} + observableParameter1_{observable} / {words('k', test)}"
    tables.observables[observable] = _observable(observable, f"extension of {test} / m", formula)
    tables.conditions[condition] = {"conditionId": condition, "conditionName": test}
    for at in used:
        tables.measurements.append(
            {"observableId": observable, "simulationConditionId": condition, "measurement": finding.extension[at],
             "time": 0.0, "observableParameters": finding.force[at], "noiseParameters": scatter}
        )  # fmt: skip


def _add_series(tables: Tables, one: Series) -> None:
    """A channel of a run, of a model that has it as an entity of its name."""
    tables.moves = True
    tables.tests.add(one.test)
    observable, condition = tables.words(one.channel, one.test), tables.words(one.test, one.run)
    tables.observables[observable] = _observable(observable, f"{one.channel} of {one.test} / {one.unit}", one.channel)
    tables.conditions[condition] = {"conditionId": condition, "conditionName": f"{one.test}, {one.run}"}
    read = [pair for pair in zip(one.columns["time"], one.columns["measured"], strict=True) if all(map(isfinite, pair))]
    for time, value in read:
        tables.measurements.append(
            {"observableId": observable, "simulationConditionId": condition, "measurement": value, "time": time,
             "observableParameters": "", "noiseParameters": one.noise}
        )  # fmt: skip
    if len(read) < one.count:
        tables.notes.append(
            f"{one.name}: {len(read)} of {one.count} readings, the smallest and the largest of each short stretch: "
            "estimates need the file of the readings"
        )


def _observable(name: str, title: str, formula: str) -> Row:
    noise = f"noiseParameter1_{name}"
    return {"observableId": name, "observableName": title, "observableFormula": formula, "noiseFormula": noise}


def _problem(findings: Findings, notes: Sequence[str]) -> bytes:
    import yaml

    problem = {
        "format_version": 1,
        "parameter_file": "parameters.tsv",
        "problems": [
            {
                "sbml_files": ["model.xml"],
                "condition_files": ["conditions.tsv"],
                "measurement_files": ["measurements.tsv"],
                "observable_files": ["observables.tsv"],
            }
        ],
    }
    head = [f"# {' '.join(text.split())}" for text in [*heading(findings, "Problem in the tables of PEtab"), *notes]]
    return ("\n".join(head) + "\n" + yaml.safe_dump(problem, sort_keys=False)).encode()


def _tsv(rows: Iterable[Row]) -> bytes:
    stream = StringIO(newline="")
    listed = list(rows)
    writer = csv.DictWriter(stream, list(listed[0]), delimiter="\t", lineterminator="\n")
    writer.writeheader()
    writer.writerows(listed)
    return stream.getvalue().encode()
