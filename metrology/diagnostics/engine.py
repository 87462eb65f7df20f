"""The engine: fit the stated model, search the set of effects with the most evidence, judge it, measure the gain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from metrology.diagnosis import Diagnosis, Gain
from metrology.diagnostics import heldout, verdict
from metrology.diagnostics.judgement import judge, unextended
from metrology.diagnostics.search import Search
from metrology.diagnostics.subject import Subject
from metrology.message import said

BUDGET = 40
"""Fits of sets of effects at most: they are counted, not timed, so that a diagnosis repeats."""

WORSE = (
    "The model with the most evidence predicts the blocks that were left out worse than the stated one, by a factor of "
    "{ratio:.3g}: it is not taken."
)


def rank(
    subject: Subject, *, rng: np.random.Generator, test: str = "", budget: int = BUDGET, workers: int = 2,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:  # fmt: skip
    """Diagnosis of a model: whether anything is missing, what, how sure, and what it is worth.

    1. The stated model is fitted inside the priors of all known inputs.
    2. The noise of every channel is whitened, and what even the full list of effects leaves enters the covariance
       (`likelihood`, `misfit`). On the straight line through the fit the evidence of every set of effects is
       closed-form (`line`, `table`).
    3. The sets that promise most are fitted; the straight line is laid through the best one; and so on until none
       promises more, or the budget is spent (`search`).
    4. A smooth force or a curved reading of any form, beside the model and in the place of each of its effects, tells
       whether the law is complete and the names are sure (`laws`, `unlisted`, `judgement`).
    5. Each block is predicted from the others, with the stated and with the extended model (`heldout`). An extension
       that predicts them worse follows what is no part of it, such as a step in the readings of one run: it is not
       taken.

    Parameters
    ----------
    subject : Subject
        A model, its candidate effects, some data.
    rng : Generator
        For bootstrap intervals.
    test : str
        Id of the test, for the result.
    budget : int
        Fits of sets at most.
    workers : int
        Fits at a time.
    progress : callable, optional
        Takes one line of text now and then.

    Returns
    -------
    Diagnosis
        Also where a fit fails: the verdict and `failures` say so.
    """
    say = progress or (lambda _text: None)
    say("fitting the base model")
    base = subject.fit((), [{}])
    if base is None:
        return verdict.failed(subject, test)
    search = Search(subject, budget, workers, say)
    first = search.view(base)
    base = first.fit
    view = search.run(base, first)
    judged = judge(search, base, first, view)
    gain: dict[str, Gain] = {}
    # One block alone can be left out of nothing.
    if judged.is_extended and len(base.problem.blocks) > 1:
        before, after = (heldout.predict(one, thorough=True) for one in (judged.base, judged.last))
        gain, whole = heldout.gains(judged.last, before, after, rng)
        if whole is not None and whole.high < 1:
            judged, gain = unextended(search, base, first, said(WORSE, ratio=float(1 / whole.ratio))), {}
    pictures = subject.pictures(base, judged.last if judged.last.effects else None)
    return replace(verdict.worded(judged, subject, gain, test), pictures=pictures)
