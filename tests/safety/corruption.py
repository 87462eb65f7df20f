"""What goes wrong with raw records: one function a kind, each with an amount drawn at random.

It changes a copy of a `Work`. A kind that says nothing to a method raises `Inapplicable`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
from laboratory import Work

Rng = np.random.Generator
Table = dict[str, list[Any]]


class Inapplicable(Exception):  # noqa: N818
    """The kind has no meaning for this method."""


def corrupted(work: Work, kind: str, rng: Rng) -> tuple[Work, str]:
    """A copy of the work with a corruption of this kind, and its amount in words."""
    changed = copy.deepcopy(work)
    return changed, KINDS[kind](changed, rng)


# ---- which files and columns -------------------------------------------------------------------------------------
def _files(work: Work, rng: Rng) -> list[str]:
    """One file, or all that hold the same columns: a slip of one day, or of the set-up."""
    one = str(rng.choice(work.raw))
    alike = [name for name in work.raw if list(work.tables[name]) == list(work.tables[one])]
    return alike if rng.random() < 0.5 else [one]


def _headings(table: Table) -> list[str]:
    return [heading for heading in table if "/" in heading and not heading.startswith("time")]


def _columns(work: Work, rng: Rng) -> list[tuple[Table, str]]:
    files = _files(work, rng)
    heading = str(rng.choice(_headings(work.tables[files[0]])))
    return [(work.tables[name], heading) for name in files]


def _each(work: Work, rng: Rng, change: Callable[[np.ndarray, float], np.ndarray]) -> str:
    """Change one column of one file or of all alike; the function is given values and their span."""
    found = _columns(work, rng)
    for table, heading in found:
        values = np.array(table[heading], dtype=float)
        table[heading] = change(values, float(np.nanmax(values) - np.nanmin(values))).tolist()
    return f"{found[0][1]} of {len(found)} files"


# ---- kinds -------------------------------------------------------------------------------------------------------
def scale(work: Work, rng: Rng) -> str:
    factor = float(rng.choice([10.0, 1000.0, 0.001]))
    return f"× {factor:g}, " + _each(work, rng, lambda values, span: factor * values)


def flip(work: Work, rng: Rng) -> str:
    return _each(work, rng, lambda values, span: -values)


def offset(work: Work, rng: Rng) -> str:
    part = float(rng.choice([-1, 1]) * 10 ** rng.uniform(-1, 2))
    return f"{part:.2g} spans, " + _each(work, rng, lambda values, span: values + part * span)


def drift(work: Work, rng: Rng) -> str:
    part = float(rng.choice([-1, 1]) * 10 ** rng.uniform(-2, 0.5))
    return f"{part:.2g} spans, " + _each(
        work, rng, lambda values, span: values + part * span * np.linspace(0, 1, values.size)
    )


def quantise(work: Work, rng: Rng) -> str:
    part = float(10 ** rng.uniform(-2, -0.3))
    return f"steps of {part:.2g} spans, " + _each(
        work, rng, lambda values, span: np.round(values / (part * span)) * part * span
    )


def spike(work: Work, rng: Rng) -> str:
    part, count = float(10 ** rng.uniform(-1, 2.5)), int(rng.integers(1, 6))

    def change(values: np.ndarray, span: float) -> np.ndarray:
        values[rng.choice(values.size, count, replace=False)] += part * span * rng.choice([-1, 1], count)
        return values

    return f"{count} of {part:.2g} spans, " + _each(work, rng, change)


def clip(work: Work, rng: Rng) -> str:
    part, both = float(rng.uniform(0.2, 0.95)), bool(rng.random() < 0.5)

    def change(values: np.ndarray, span: float) -> np.ndarray:
        low, high = float(values.min()), float(values.min()) + part * span
        return np.clip(values, low + (1 - part) * span if both and part > 0.5 else low, high)

    return f"at {part:.2g} spans, " + _each(work, rng, change)


def hold(work: Work, rng: Rng) -> str:
    """The transmission stops and the last sample is repeated; or every sample is repeated n times, at a slow update."""
    every, part = int(rng.choice([0, 3, 10, 30])), float(rng.uniform(0.05, 0.6))

    def change(values: np.ndarray, span: float) -> np.ndarray:
        at = np.arange(values.size)
        if every:
            return values[every * (at // every)]
        count = max(2, int(part * values.size))
        first = int(rng.integers(1, values.size - count + 1))
        values[first : first + count] = values[first - 1]
        return values

    how = f"every {every}" if every else f"{part:.2g} of the record"
    return f"{how}, " + _each(work, rng, change)


def _rows(work: Work, rng: Rng, choose: Callable[[int], np.ndarray], *, stamps: str) -> int:
    """Keep the rows chosen; `stamps`: 'kept' with the rows, or 'old', those that the recorder would have counted."""
    files = _files(work, rng)
    for name in files:
        table = work.tables[name]
        size = len(next(iter(table.values())))
        rows = choose(size)
        for heading, values in table.items():
            if heading.startswith("time") and stamps == "old":
                step = (values[-1] - values[0]) / (size - 1)
                table[heading] = [values[0] + step * at for at in range(len(rows))]
            else:
                table[heading] = [values[at] for at in rows]
    return len(files)


def alias(work: Work, rng: Rng) -> str:
    if work.method == "elongation":
        raise Inapplicable
    every = int(rng.choice([2, 3, 5, 10, 20]))
    count = _rows(work, rng, lambda size: np.arange(0, size, every), stamps="old")
    return f"every {every}, {count} files"


def drop(work: Work, rng: Rng) -> str:
    part, scattered, stamps = float(rng.uniform(0.02, 0.4)), bool(rng.random() < 0.5), str(rng.choice(["kept", "old"]))

    def choose(size: int) -> np.ndarray:
        gone = max(1, int(part * size))
        first = int(rng.integers(1, size - gone))
        lost = rng.choice(np.arange(1, size), gone, replace=False) if scattered else np.arange(first, first + gone)
        return np.setdiff1d(np.arange(size), lost)

    count = _rows(work, rng, choose, stamps=stamps)
    return f"{part:.2g} {'scattered' if scattered else 'in one'}, stamps {stamps}, {count} files"


def duplicate(work: Work, rng: Rng) -> str:
    part, scattered, stamps = float(rng.uniform(0.02, 0.4)), bool(rng.random() < 0.5), str(rng.choice(["kept", "old"]))

    def choose(size: int) -> np.ndarray:
        more = max(1, int(part * size))
        first = int(rng.integers(0, size - more))
        if scattered:
            return np.sort(np.concatenate([np.arange(size), rng.choice(size, more, replace=False)]))
        return np.concatenate([np.arange(first + more), np.arange(first, size)])

    count = _rows(work, rng, choose, stamps=stamps)
    return f"{part:.2g} {'scattered' if scattered else 'in one'}, stamps {stamps}, {count} files"


def rate(work: Work, rng: Rng) -> str:
    return _times(work, rng, float(rng.choice([2.0, 0.5])))


def milliseconds(work: Work, rng: Rng) -> str:
    return _times(work, rng, float(rng.choice([1000.0, 0.001])))


def _times(work: Work, rng: Rng, factor: float) -> str:
    if work.method == "elongation":
        raise Inapplicable
    files = _files(work, rng)
    for name in files:
        work.tables[name]["time / s"] = [factor * value for value in work.tables[name]["time / s"]]
    return f"× {factor:g}, {len(files)} files"


def grams(work: Work, rng: Rng) -> str:
    """A mass in another unit than stated: 250 g stand as 250 kg, or 1.2 kg as 1.2 g."""
    if not work.weighed:
        raise Inapplicable
    unit = str(rng.choice(["g", "Mg"]))
    for test in work.campaign["tests"].values():
        loads = list(test.get("loads", {}).values())
        if test["method"] != work.method:
            continue
        places = loads or [test.get("rig", test)]
        for place in places if rng.random() < 0.7 else places[: max(1, len(places) // 2)]:
            place["mass"] = place["mass"].replace(" kg", f" {unit}")
    return f"kg written as {unit}"


def swap_columns(work: Work, rng: Rng) -> str:
    """The headings of two columns of one file, or of all alike, are exchanged."""
    files = _files(work, rng)
    a, b = rng.choice(list(work.tables[files[0]]), 2, replace=False)
    for name in files:
        table = work.tables[name]
        table[str(a)], table[str(b)] = table[str(b)], table[str(a)]
    return f"{a} and {b}, {len(files)} files"


def exchange(work: Work, rng: Rng) -> str:
    """The labels of two loads, in the readings or in the list of loads, or the files of two runs are exchanged."""
    if work.method == "elongation":
        loads = work.campaign["tests"]["pull"]["loads"]
        a, b = map(str, rng.choice(list(loads), 2, replace=False))
        if rng.random() < 0.5:
            loads[a], loads[b] = loads[b], loads[a]
            return f"masses of {a} and {b}"
        table, repeats = work.tables["elongation.csv"], int(rng.integers(1, 4))
        other = {a: b, b: a}
        table["load"] = [
            other.get(load, load) if int(repeat) <= repeats else load
            for load, repeat in zip(table["load"], table["repeat"], strict=True)
        ]
        return f"labels of {a} and {b} in {repeats} repeats"
    if work.method != "response":
        raise Inapplicable
    runs = work.campaign["tests"]["ride"]["runs"]
    a, b = map(str, rng.choice(list(runs), 2, replace=False))
    if rng.random() < 0.5:
        at = int(rng.integers(2))
        runs[a]["readings"][at], runs[b]["readings"][at] = runs[b]["readings"][at], runs[a]["readings"][at]
        return f"one file of {a} and {b}"
    runs[a]["readings"], runs[b]["readings"] = runs[b]["readings"], runs[a]["readings"]
    return f"readings of {a} and {b}"


def copy_run(work: Work, rng: Rng) -> str:
    """One record stands under another's name, its stamps shifted or its numbers written with other digits."""
    if work.method == "elongation":
        return _copy_repeat(work, rng)
    how = str(rng.choice(["bytes", "shifted", "digits", "cut"]))
    kind = str(rng.choice(["motion", "cell"])) if work.method == "response" else ""
    names = [name for name in work.raw if kind in name]
    a, b = map(str, rng.choice(names, 2, replace=False))
    table = copy.deepcopy(work.tables[a])
    if how == "shifted" and work.method != "response":
        table["time / s"] = [value + 0.25 for value in table["time / s"]]
    elif how == "digits":
        table = {heading: [f"{value:.7f}" for value in values] for heading, values in table.items()}
    elif how == "cut":
        table = {heading: values[: -len(values) // 5] for heading, values in table.items()}
    work.tables[b] = table
    return f"{a} as {b}, {how}"


def _copy_repeat(work: Work, rng: Rng) -> str:
    table = work.tables["elongation.csv"]
    names = sorted(set(table["repeat"]))
    a, b = map(str, rng.choice(names, 2, replace=False))
    known = {
        (load, way): x
        for load, repeat, way, x in zip(*table.values(), strict=True)
        if repeat == a
    }  # fmt: skip
    table["reading / mm"] = [
        known[load, way] if repeat == b else x for load, repeat, way, x in zip(*table.values(), strict=True)
    ]
    return f"repeat {a} as {b}"


KINDS: dict[str, Callable[[Work, Rng], str]] = {
    "scale": scale, "sign flipped": flip, "offset": offset, "drift": drift, "quantise": quantise, "spike": spike,
    "clip": clip, "hold": hold, "alias": alias, "drop": drop, "duplicate": duplicate, "rate × 2 or / 2": rate,
    "ms for s": milliseconds, "g for kg": grams, "columns swapped": swap_columns, "labels exchanged": exchange,
    "run copied": copy_run,
}  # fmt: skip
