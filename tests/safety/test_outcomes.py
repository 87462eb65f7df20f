"""No confident wrong number: corrupted records are refused, flagged and not judged, or do not matter."""

from __future__ import annotations

import numpy as np
import pytest
from corruption import KINDS
from laboratory import METHODS
from outcome import case, judge, table

QUICK = {"elongation": range(2), "decay": range(1), "response": range(1), "tension": range(1), "relaxation": range(1)}
"""Seeds of every kind that are tried each time: what fits into a minute of CPU time; the study has 2000 cases."""
SLOW = ("scale", "drift", "alias", "drop", "duplicate", "rate × 2 or / 2", "ms for s", "g for kg", "labels exchanged")
"""Kinds whose fit to a response takes seconds: left to the study."""
ESCAPING = {"scale", "g for kg", "rate × 2 or / 2", "ms for s", "alias", "hold"}
"""Kinds that contradict nothing where a campaign knows nothing twice: docs/safety.md."""


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("method", METHODS)
def test_law_no_confident_wrong_number(method, kind):
    for seed in QUICK[method] if method != "response" or kind not in SLOW else ():
        # Without its diagnosis a case takes a part of the time, and has the fewer checks.
        found = case(method, kind, seed, off=True)
        assert found is None or found.outcome != "escaped", f"{found.amount}: {found.why}"


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_limit_a_clean_record_is_judged(method):
    work = METHODS[method](np.random.default_rng(7))
    work.campaign["diagnosis"] = {"off": True}
    assert judge(work)[0] == "within 4 u"


@pytest.mark.study
@pytest.mark.parametrize("method", METHODS)
def test_law_no_confident_wrong_number_in_many(method):
    count = {"elongation": 70, "decay": 40, "response": 20, "tension": 30, "relaxation": 30}[method]
    cases = [found for kind in KINDS for seed in range(count) if (found := case(method, kind, 1000 + seed))]
    print(table(cases))
    assert [(one.kind, one.seed, one.amount, one.why) for one in cases if one.outcome == "escaped"] == []


@pytest.mark.study
@pytest.mark.parametrize("method", METHODS)
def test_limit_what_a_campaign_that_knows_nothing_twice_lets_escape(method):
    cases = [found for kind in KINDS for seed in range(10) if (found := case(method, kind, 2000 + seed, bare=True))]
    print(table(cases))
    assert {one.kind for one in cases if one.outcome == "escaped"} <= ESCAPING
