"""What a user is left with after a campaign with a corrupted record: the outcome of one case, and tables of many."""

from __future__ import annotations

import signal
import tempfile
import time
import traceback
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from corruption import KINDS, Inapplicable, corrupted
from laboratory import METHODS, Work
from scipy import stats

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError
from metrology.findings import Result
from metrology.language.notices import brief

FAR = 4.0
"""Standard uncertainties within which a result counts as right, or what is as improbable of few degrees of freedom."""
OUTCOMES = ("refused", "flagged", "within 4 u", "not finished", "escaped")
PATIENCE = 40.0
"""Seconds of CPU time after which a user who waits has no number either: nothing wrong is believed."""
LOUD = ("Failure", "Withheld", "Check", "Model", "Diagnosis", "Fit", "Comparison", "Note")


@dataclass(frozen=True)
class Case:
    """One case: method, kind and seed, what was done, and its outcome with what led to it."""

    method: str
    kind: str
    seed: int
    bare: bool
    amount: str
    outcome: str
    why: str
    seconds: float


def judge(work: Work) -> tuple[str, str]:
    """Outcome of a campaign, and why."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            findings = chain.evaluate(load(work.write(Path(folder))))
        except MetrologyError as error:
            return "refused", str(error.faults[0])
        except Exception:  # noqa: BLE001 - what no user may see
            return "escaped", "".join(traceback.format_exc(limit=-3))
    passed = [one.requirement for one in findings.conformity if "pass" in one.verdict]
    notices = [f"{kind}: {text}" for kind, text in brief(findings) if kind in LOUD]
    by_name = {one.name: one for one in findings.results}
    off = {
        name: _deviates(by_name[name], true)
        for name, true in work.truth.items()
        if name in by_name and np.isfinite(by_name[name].value)
    }
    text = "; ".join(f"{name} {z:+.3g} u, {by_name[name].value / work.truth[name]:.3g}" for name, z in off.items())
    if not off:
        return "refused", " | ".join(notices)
    if all(abs(z) < FAR for z in off.values()):
        return "within 4 u", text
    if not passed and notices:
        return "flagged", f"{text} | {' | '.join(notices)}"
    return "escaped", f"{text} | passed {passed} | {' | '.join(notices)}"


def _deviates(result: Result, true: float) -> float:
    """Standard deviations of a normal distribution that are as improbable as the deviation from the true value.

    Of few degrees of freedom, t has more in its tails: with two, 5.0 u are as improbable as 2.1 standard deviations.
    """
    t = (result.value - true) / max(result.u, 1e-300)
    return t if result.dof is None else float(np.sign(t) * stats.norm.isf(stats.t.sf(abs(t), result.dof)))


class Impatience(BaseException):
    """Not an Exception, so that nothing on the way takes it for a failure of its own."""


def _stop(*_: object) -> None:
    raise Impatience


def case(method: str, kind: str, seed: int, *, bare: bool = False, off: bool = False) -> Case | None:
    """One case by its seed; None where the kind says nothing to the method.

    `bare`: without what a laboratory knows twice; `off`: without diagnosis.
    """
    rng = np.random.default_rng([seed, *f"{method} {kind}".encode()])
    work = METHODS[method](rng, bare=bare)
    work.campaign["diagnosis"] = {"off": off}
    begun = time.process_time()
    try:
        work, amount = corrupted(work, kind, rng) if kind else (work, "nothing")
    except Inapplicable:
        return None
    signal.signal(signal.SIGVTALRM, _stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, PATIENCE)
    try:
        outcome, why = judge(work)
    except Impatience:
        outcome, why = "not finished", "".join(traceback.format_exc(limit=-6))
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    return Case(method, kind, seed, bare, amount, outcome, why, time.process_time() - begun)


def table(cases: list[Case]) -> str:
    """Outcomes counted by method and kind, as a table of the documentation."""
    rows = ["| method | corruption | " + " | ".join(OUTCOMES) + " |", "|---|---|" + "---:|" * len(OUTCOMES)]
    for method in METHODS:
        for kind in KINDS:
            own = [one.outcome for one in cases if (one.method, one.kind) == (method, kind)]
            if own:
                counts = " | ".join(str(own.count(outcome) or "") for outcome in OUTCOMES)
                rows.append(f"| {method} | {kind} | {counts} |")
    return "\n".join(rows)


def main() -> None:
    """Every kind at every seed, a line a case: `outcome.py METHOD FIRST LAST [bare] [off] [clean]`."""
    import sys

    method, first, last = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    cases = []
    for seed in range(first, last):
        for kind in KINDS if "clean" not in sys.argv else ("",):
            one = case(method, kind, seed, bare="bare" in sys.argv, off="off" in sys.argv)
            if one is not None:
                cases.append(one)
                print(
                    f"{one.outcome:10} {one.seconds:5.1f} s {seed} {kind}: {one.amount} -> {one.why}"[:600], flush=True
                )
    print(table(cases))


if __name__ == "__main__":
    main()
