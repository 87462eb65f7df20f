"""This package as an entry: the only file here that knows how its `results.json` holds a diagnosis."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.causes.answers import Answer
from benchmarks.causes.names import NAMES

ENDS = ("low", "high")


def main(folder: str) -> int:
    """Diagnose a case and print the answer."""
    with tempfile.TemporaryDirectory() as place:
        words = [sys.executable, "-m", "metrology", "diagnose", "--output", place, f"{folder}/campaign.yaml"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        found = list(Path(place).rglob("results.json"))
        if done.returncode not in (0, 1) or not found:
            sys.stderr.write(done.stderr[-400:] or "no results.json\n")
            return done.returncode or 2
        print(answer(json.loads(found[0].read_text(encoding="utf-8"))).text())
    return 0


def answer(results: dict[str, Any]) -> Answer:
    """Answer that a `results.json` holds."""
    k, c = (_interval(results, quantity) for quantity in "kc")
    if not results["diagnosis"]:
        return Answer("not testable", k=k, c=c, failure="; ".join(map(str, results["failures"])) or "no diagnosis")
    one = results["diagnosis"][0]
    causes = sorted(one["causes"], key=lambda cause: -(cause["probability"] or 0.0))
    named = tuple(cause["effect"] for cause in causes if cause["verdict"] == "supported")
    known = tuple(name for name in named if name in NAMES[one["method"]])
    causes = [cause for cause in causes if cause["effect"] in NAMES[one["method"]]]
    verdict = one["verdict"]
    groups = [group for group in one["groups"] if len(group) > 1]  # alone: not decided, no name
    listed = (tuple(name for name in group if name in NAMES[one["method"]]) for group in groups)
    inside = tuple(group for group in listed if group)
    if not named and groups and not inside:
        verdict = "unexplained"
    if known != named:  # a name that is not in the list of the benchmark: something unlisted
        verdict = "explained in the main" if known else "unexplained"
    return Answer(
        verdict,
        known,
        inside,
        {cause["effect"]: min(1.0, max(0.0, cause["probability"] or 0.0)) for cause in causes},
        k,
        c,
        _held_out(one["gain"]),
    )


def _interval(results: dict[str, Any], quantity: str) -> tuple[float, float, float] | None:
    """Value and interval as page 1 of the report prints them."""
    for one in results["results"]:
        if one["quantity"] == quantity and one["method"] in ("response", "decay", "elongation"):
            trials = one["monte_carlo"]
            found = one["coverage"] if trials["law_valid"] else {end: trials[f"shortest_{end}"] for end in ENDS}
            ends = [found[end] for end in ENDS]
            if all(isinstance(end, float | int) for end in ends):
                return one["value"], *ends
    return None


def _held_out(gain: dict[str, Any]) -> tuple[float, float] | None:
    """Root mean square over the channels."""
    pairs = [(one["before"], one["after"]) for one in gain.values()]
    pairs = [pair for pair in pairs if all(isinstance(value, float | int) and value > 0 for value in pair)]
    if not pairs:
        return None
    before, after = (math.sqrt(sum(value**2 for value in side) / len(pairs)) for side in zip(*pairs, strict=True))
    return before, after


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
