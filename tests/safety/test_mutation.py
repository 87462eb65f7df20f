"""Small campaigns of every method with changes, up to their results: no traceback, no hang, no number that is none."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from mutation import CAMPAIGNS, evaluated, unchanged, works

ANY = settings(deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)


@pytest.mark.long
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_limit_unchanged_campaigns_are_evaluated(name):
    findings = evaluated(unchanged(name))
    assert findings is not None
    assert findings.results or findings.fits


@pytest.mark.long
@settings(ANY, max_examples=60)
@given(works())
def test_law_what_is_changed_is_evaluated_or_refused(work):
    evaluated(work)


@pytest.mark.study
@settings(ANY, max_examples=2000, derandomize=False)
@given(works())
def test_law_what_is_changed_is_evaluated_or_refused_in_many(work):
    evaluated(work)
