"""Steps of the verdict, as docs/methods/diagnosis.md has them in its table."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from metrology.diagnostics.judgement import _verdict

LADDER = [
    # effects of the model, named, groups, likeliest set, share, probability of an unlisted law, λ → verdict
    ((), (), (), (), 0.0, 0.2, 1.2, "nothing missing"),
    ((), (), (), ("slip",), 0.0, 0.2, 1.2, "unexplained"),
    ((), (), (), (), 0.0, 0.6, 1.2, "unexplained"),
    ((), (), (), (), 0.0, 0.2, 2.1, "unexplained"),
    (("friction",), ("friction",), (), ("friction",), 1.0, 0.2, 1.2, "explained"),
    (("friction",), ("friction",), (), ("friction",), 0.8, 0.6, 1.2, "explained in the main"),
    (("friction",), ("friction",), (), ("friction",), 0.8, 0.2, 2.1, "explained in the main"),
    (("friction",), ("friction",), (), ("friction",), 0.4, 0.6, 1.2, "unexplained"),
    (("friction",), ("friction",), (("friction", "drag"),), ("friction",), 1.0, 0.2, 1.2, "ambiguous"),
    (("cubic",), (), (), ("cubic",), 0.1, 0.4, 1.5, "ambiguous"),
    (("cubic",), (), (), (), 0.1, 0.4, 1.5, "ambiguous"),
    (("cubic",), (), (), ("cubic",), 0.1, 0.6, 1.5, "unexplained"),
]


def judged(effects, named, groups, likeliest, share, unlisted, misfit, *, lost=False):
    view = SimpleNamespace(fit=SimpleNamespace(effects=effects), noise=SimpleNamespace(misfit=misfit))
    search = SimpleNamespace(subject=SimpleNamespace(loses=lambda _: lost))
    return _verdict(search, view, share, unlisted, named, groups, frozenset(likeliest))


@pytest.mark.parametrize("row", LADDER)
def test_law_every_step_of_the_verdict(row):
    assert judged(*row[:-1]) == row[-1]


@pytest.mark.parametrize("row", LADDER)
def test_law_a_lost_motion_is_not_finished_whatever_is_named(row):
    assert judged(*row[:-1], lost=True) == "not finished"
