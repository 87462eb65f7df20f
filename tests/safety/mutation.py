"""Small campaigns of every method with changes that most of the time the readers let pass: what reaches the evaluation.

`works` is a strategy of Hypothesis, so that the tests draw from it, and fuzzing drives it by its bytes.
`evaluated` is what has to hold: findings without numbers that are none, or a refusal, within `PATIENCE`.
"""

from __future__ import annotations

import copy
import csv
import re
import signal
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache
from math import isinf, isnan
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from hypothesis import strategies as st
from laboratory import METHODS, Work

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError
from metrology.findings import Findings, from_json, to_json
from metrology.gum.evaluation import MonteCarlo

PATIENCE = 30.0
"""Seconds of CPU time; unchanged, a campaign takes one at most."""
READINGS = 100
"""Readings of a record, about."""
REFERENCE = Path(__file__).parents[1] / "reference"
MODELS = (
    "gum-h3-thermometer", "gum-h5-anova", "gum-h2-resistance-reactance", "iso28037-wls-1", "jcgm101-9-5-gauge-block",
    "jcgm106-9-5-ball-bearings", "pearson-york-errors-in-both",
)  # fmt: skip
"""Campaigns without a test: fits, layouts, equations and requirements."""
FACTORS = (1.001, 0.999, 1.1, 0.9, 2.0, 0.5, 10.0, 0.1, 1e3, 1e-3, -1.0, 0.0, 1e12, 1e-12, 1e60, 1e-60)
OPTIONS: tuple[tuple[tuple[str, ...], Any], ...] = (
    (("diagnosis", "off"), False),
    (("tests", "ride", "rig", "attachment"), "both ways"),
    (("tests", "ride", "rig", "attachment"), "none"),
    (("tests", "ride", "rig", "line_weight"), "elastic catenary"),
    (("tests", "ride", "rig", "line_weight"), "catenary"),
    (("tests", "hold", "held"), "load"),
    (("tests", "pull", "to_break"), True),
    (("fits", "york", "covariance"), "iso28037"),
    (("fits", "cal", "scatter"), "stated"),
)
"""Keys with another value than the campaigns have; without the test that they belong to they change nothing.

A response is not diagnosed: the search for causes takes minutes where its records hold nothing like a motion.
"""
OPTIONAL = (
    "section", "density", "linear_density", "references", "certificate", "air_density", "stiffness", "gauge_length",
    "setup_compliance", "known", "purpose", "m0", "a", "requirements", "uncertainty", "monte_carlo", "u_x", "u_y",
    "predict", "origin", "nested", "free", "crosshead",
)  # fmt: skip
"""Keys that a campaign may do without, most of the time."""
NUMBER = re.compile(r"(?<![\^\w])[-+]?\d+(\.\d*)?(e[-+]?\d+)?")
QUANTITY = re.compile(rf"{NUMBER.pattern}(\(\d+\))?( .*)?")
WORDS = {"format", "id", "date", "due", "readings", "number", "seed", "title", "digits", "max_trials", "class"}
"""Keys of numbers that are no quantities."""


@cache
def _made(name: str) -> Work:
    work = METHODS[name](np.random.default_rng(7)) if name in METHODS else _model(name)
    work.campaign["monte_carlo"] = {"digits": 1, "max_trials": 10_000}
    work.campaign["diagnosis"] = {"off": True}
    for table in work.tables.values():
        thin = max(1, len(next(iter(table.values()))) // READINGS)
        table.update({heading: values[::thin] for heading, values in table.items()})
    return work


def unchanged(name: str) -> Work:
    """A campaign as it is."""
    return copy.deepcopy(_made(name))


def _model(name: str) -> Work:
    folder = REFERENCE / name
    campaign = yaml.safe_load((folder / "campaign.yaml").read_text(encoding="utf-8"))
    tables = {path.name: _table(path) for path in folder.glob("*.csv")}
    return Work("model", campaign, tables, {}, tuple(tables))


def _table(path: Path) -> dict[str, list[Any]]:
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    return {heading: [_value(row[at]) for row in rows] for at, heading in enumerate(head)}


def _value(text: str) -> Any:
    return float(text) if "." in text else text


CAMPAIGNS = (*METHODS, *MODELS)


@st.composite
def works(draw: st.DrawFn, names: tuple[str, ...] = CAMPAIGNS) -> Work:
    """A campaign of one of these names, with up to four changes."""
    work = unchanged(draw(st.sampled_from(names)))
    kinds = [_scalar, _option, _removed, *([_cell, _column, _rows] if work.tables else [])]
    for _ in range(draw(st.integers(0, 4))):
        draw(st.sampled_from(kinds))(draw, work)
    return work


# ---- changes -----------------------------------------------------------------------------------------------------
def _places(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Every key and every entry of a list, by its path, with what stands there."""
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in entries:
        yield (*place, key), entry
        yield from _places(entry, (*place, key))


def _quantities(campaign: Any) -> list[tuple[Any, ...]]:
    return [
        place
        for place, entry in _places(campaign)
        if not isinstance(entry, dict | list) and QUANTITY.fullmatch(str(entry)) and not WORDS & set(place)
    ]


def _within(campaign: Any, place: tuple[Any, ...]) -> Any:
    for key in place:
        campaign = campaign[key]
    return campaign


def _scalar(draw: st.DrawFn, work: Work) -> None:
    """One number of one quantity of the campaign, its value or its uncertainty, by a factor."""
    places = _quantities(work.campaign)
    if not places:
        return
    place = draw(st.sampled_from(places))
    owner, old = _within(work.campaign, place[:-1]), str(_within(work.campaign, place))
    numbers = list(NUMBER.finditer(old))
    number = numbers[draw(st.integers(0, len(numbers) - 1))]
    new = f"{float(number.group()) * draw(st.sampled_from(FACTORS)):g}"
    text = old[: number.start()] + new + old[number.end() :]
    owner[place[-1]] = float(text) if NUMBER.fullmatch(text) else text


def _option(draw: st.DrawFn, work: Work) -> None:
    place, value = draw(st.sampled_from(OPTIONS))
    if place == ("diagnosis", "off") and work.method == "response":
        return
    owner = work.campaign
    for key in place[:-1]:
        if key not in owner:
            return
        owner = owner[key]
    owner[place[-1]] = value


def _removed(draw: st.DrawFn, work: Work) -> None:
    places = [place for place, _ in _places(work.campaign) if place[-1] in OPTIONAL]
    if not places:
        return
    place = draw(st.sampled_from(places))
    del _within(work.campaign, place[:-1])[place[-1]]


def _chosen(draw: st.DrawFn, work: Work) -> tuple[dict[str, list[Any]], str]:
    table = work.tables[draw(st.sampled_from(sorted(work.tables)))]
    return table, draw(st.sampled_from(sorted(table)))


def _cell(draw: st.DrawFn, work: Work) -> None:
    """One reading takes another's place, or is another number."""
    table, heading = _chosen(draw, work)
    values = table[heading]
    at = draw(st.integers(0, len(values) - 1)) if values else None
    if at is None:
        return
    other = values[draw(st.integers(0, len(values) - 1))]
    values[at] = other * draw(st.sampled_from(FACTORS)) if isinstance(other, float) else other


CHANGES: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "scaled": lambda x, part: part * x,
    "shifted": lambda x, part: x + part * np.ptp(x),
    "drifting": lambda x, part: x + part * np.ptp(x) * np.linspace(0, 1, x.size),
    "coarse": lambda x, part: np.round(x / (part * np.ptp(x) or 1.0)) * part * np.ptp(x),
    "constant": lambda x, part: np.full(x.size, part * x[0]),
    "clipped": lambda x, part: np.minimum(x, x.min() + part * np.ptp(x)),
    "backwards": lambda x, part: part * x[::-1],
    "sorted": lambda x, part: part * np.sort(x),
    "bent": lambda x, part: x + part * np.sign(x) * x**2,
    "alternating": lambda x, part: x + part * np.ptp(x) * (np.arange(x.size) % 2),
}


def _column(draw: st.DrawFn, work: Work) -> None:
    """A whole column, of numbers, is another."""
    table, heading = _chosen(draw, work)
    if table[heading] and all(isinstance(value, float) for value in table[heading]):
        change = CHANGES[draw(st.sampled_from(sorted(CHANGES)))]
        part = draw(st.sampled_from(FACTORS))
        with np.errstate(all="ignore"):
            table[heading] = change(np.array(table[heading]), part).tolist()


def _rows(draw: st.DrawFn, work: Work) -> None:
    """A stretch of rows is missing, or is all that is left, or stands there twice, or backwards."""
    table, heading = _chosen(draw, work)
    size = len(table[heading])
    first = draw(st.integers(0, size))
    last = draw(st.integers(first, size))
    at = list(range(size))
    order = {
        "missing": at[:first] + at[last:],
        "left": at[first:last],
        "twice": at[:last] + at[first:],
        "backwards": at[:first] + at[first:last][::-1] + at[last:],
    }[draw(st.sampled_from(["missing", "left", "twice", "backwards"]))]
    table.update({name: [values[i] for i in order] for name, values in table.items()})


# ---- what has to hold --------------------------------------------------------------------------------------------
class Hang(BaseException):
    """The evaluation had not ended in time; no `Exception`, so that nothing on the way takes it for its own."""


def _hang(*_: object) -> None:
    raise Hang


def evaluated(work: Work) -> Findings | None:
    """What the chain makes of a campaign; None where it is refused in our words.

    Raises
    ------
    Hang
        Where it takes longer than `PATIENCE`.
    AssertionError
        For a result that is no number without a failure that says so, and for findings that cannot be read back.
    """
    signal.signal(signal.SIGVTALRM, _hang)
    signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE)
    try:
        with tempfile.TemporaryDirectory() as folder:
            findings = chain.evaluate(load(work.write(Path(folder))), coverage=False)
    except MetrologyError:
        return None
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    for result in findings.results:
        lacking = list(_no_numbers(replace(result, monte_carlo=None), result.name))
        told = any(text.startswith(f"{result.name} has no ") for text in findings.failures)
        assert told or not lacking, lacking
        assert _drawn(result.monte_carlo), result.monte_carlo
    assert to_json(from_json(to_json(findings))) == to_json(findings)
    return findings


def _drawn(made: MonteCarlo) -> bool:
    """Whether the figures of Monte Carlo are numbers, but a mean that does not exist, or all of them are none."""
    figures = [made.mean, made.u, made.low, made.high, made.shortest_low, made.shortest_high]
    return all(map(isnan, figures)) or not any(map(isnan, figures[isinf(made.u) :]))


def _no_numbers(value: Any, place: str) -> Iterator[str]:
    """Places of a number that is none within what dataclasses hold."""
    if isinstance(value, float) and isnan(value):
        yield place
    elif is_dataclass(value):
        for field in fields(value):
            yield from _no_numbers(getattr(value, field.name), f"{place}.{field.name}")
    elif isinstance(value, tuple | list):
        for at, entry in enumerate(value):
            yield from _no_numbers(entry, f"{place}[{at}]")
