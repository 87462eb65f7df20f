"""Evaluation of a measurement model by the GUM uncertainty framework and by Monte Carlo, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil, inf, isfinite, nan

from metrology.errors import Fault, MetrologyError
from metrology.gum.advice import advise
from metrology.gum.budget import budget
from metrology.gum.checks import check
from metrology.gum.evaluation import Estimate, Evaluation, Measurand, MonteCarlo
from metrology.gum.inputs import Floats, Knowledge
from metrology.gum.law import Law, propagate
from metrology.gum.monte_carlo import Plan, Trials, run, sufficient
from metrology.gum.output import Analytic, Empirical, Output, without_moments
from metrology.gum.sampling import sampler
from metrology.gum.sufficiency import chosen, claims, shortfall
from metrology.gum.verdict import judge
from metrology.message import said

UNCONFIRMED = said("No Monte Carlo trials were made.")
MEMORY = 2**30
"""Bytes for the draws of all outputs."""
COUNTED = 100
"""Draws beyond a limit that a risk is to be judged by: it is then known to a tenth (JCGM 101, 7.9.4 b)."""


def evaluate(
    measurands: Sequence[Measurand],
    knowledge: Knowledge,
    *,
    probability: float = 0.95,
    seed: int,
    digits: int = 2,
    max_trials: int = 1_000_000,
    risk: float = 1.0,
) -> Evaluation:
    """Estimates of all measurands with budget, coverage, Monte Carlo, verdict on the law, advice and correlations.

    Parameters
    ----------
    measurands : sequence of Measurand
        In order: each may read the inputs and the measurands before it.
    knowledge : Knowledge
        The inputs, in SI.
    probability : float
        Coverage probability, above 0 and below 1.
    seed : int
        Zero or more; the same seed gives the same draws on any number of threads.
    digits : int
        Significant digits of u to which Monte Carlo is to be stable and the law is judged, 1 to 4.
    max_trials : int
        Trials after which the adaptive procedure gives up, at least 1000.
    risk : float
        Smallest probability that is judged by the draws: 100/risk trials are made, or as many as are allowed.

    Returns
    -------
    Evaluation
        Estimates by name, correlations of results, and the state of every Monte Carlo evaluation.

    Raises
    ------
    MetrologyError
        Knowledge or arguments that cannot be used; every fault at once.

    Notes
    -----
    JCGM 100:2008 5; JCGM 101:2008 7, 8; JCGM 102:2011 6, 7.

    Examples
    --------
    >>> from metrology.gum.distributions import Normal
    >>> from metrology.gum.inputs import Component, Input
    >>> inputs = {x: Input(x, 0.0, (Component("source", Normal(1.0)),)) for x in ("X1", "X2", "X3", "X4")}
    >>> sum_of_four = Measurand("Y", lambda q: q["X1"] + q["X2"] + q["X3"] + q["X4"])
    >>> evaluate([sum_of_four], Knowledge(inputs), seed=1).estimates["Y"].u
    2.0
    """
    plan = Plan(probability, seed, digits, max_trials, least_trials=ceil(COUNTED / risk))
    _check_plan(plan)
    check(measurands, knowledge)
    law = propagate(measurands, knowledge)
    return _evaluation(law, knowledge, simulate(law, knowledge, plan))


def evaluate_law(measurands: Sequence[Measurand], knowledge: Knowledge, *, probability: float) -> Evaluation:
    """Estimates of all measurands by the GUM uncertainty framework alone, which nothing has confirmed.

    Parameters
    ----------
    measurands : sequence of Measurand
        In order: each may read the inputs and the measurands before it.
    knowledge : Knowledge
        The inputs, in SI.
    probability : float
        Coverage probability, above 0 and below 1.

    Returns
    -------
    Evaluation
        As `evaluate` gives it; the Monte Carlo figures are NaN, from no trials.

    Raises
    ------
    MetrologyError
        Knowledge that cannot be used; every fault at once.

    Notes
    -----
    JCGM 100:2008 5.
    """
    check(measurands, knowledge)
    law = propagate(measurands, knowledge)
    return _evaluation(law, knowledge, [_unconfirmed(law, row, probability) for row in range(len(law.linear))])


def _unconfirmed(law: Law, row: int, probability: float) -> tuple[MonteCarlo, Output | None]:
    """The law's distribution where it has one, beside a Monte Carlo result that nobody has made."""
    value, u = law.linear[row].value, law.u(row)
    usable = isfinite(value) and isfinite(u)
    made = MonteCarlo(
        *(nan,) * 6, probability, trials=0, converged=False, law_valid=usable, verdict=UNCONFIRMED, tolerance=nan,
        d_low=None, d_high=None, edges=(), density=(),
    )  # fmt: skip
    return made, Analytic(value, u, law.dof(row)[0] or inf) if usable else None


def _evaluation(law: Law, knowledge: Knowledge, results: Sequence[tuple[MonteCarlo, Output | None]]) -> Evaluation:
    estimates = {
        line.measurand.name: _estimate(law, row, knowledge, results[row]) for row, line in enumerate(law.linear)
    }
    return Evaluation(estimates, tuple(estimates), law.coefficients(), tuple(law.joint.coefficients()))


def simulate(law: Law, knowledge: Knowledge, plan: Plan) -> tuple[tuple[MonteCarlo, Output | None], ...]:
    """Monte Carlo results of all measurands of `law`, each with its verdict on the law and the distribution used.

    Source: JCGM 101:2008 7.9, 8.
    """
    stated = claims(law, plan.probability)
    measurands = [line.measurand for line in law.linear]
    if not measurands:
        return ()
    plan = replace(plan, max_trials=min(plan.max_trials, MEMORY // (8 * len(measurands))))
    if knowledge.redrawn:
        plan = replace(plan, max_trials=min(plan.max_trials, sufficient(plan.probability)))

    def enough(trials: Trials) -> float:
        short = shortfall(stated, trials.batches, plan.digits)
        return short if short > 1 else chosen(stated, trials, plan)

    trials = run(measurands, sampler(knowledge, law.joint), plan, enough)
    found = [judge(claim, trials, row, plan) for row, claim in enumerate(stated)]
    return tuple((one, _output(law, row, one, trials.outputs)) for row, one in enumerate(found))


def _output(law: Law, row: int, found: MonteCarlo, outputs: Floats) -> Output | None:
    """Return the law's distribution where clause 8 confirms it, else that of the draws; None without numbers."""
    if found.law_valid:
        return Analytic(law.linear[row].value, law.u(row), law.dof(row)[0] or inf)
    if not isfinite(found.low):
        return None
    # A row of many is copied, so that the draws of the others are not kept with it.
    draws = outputs[row].copy() if len(outputs) > 1 else outputs[row]
    if isfinite(found.u):
        return Empirical(found.mean, found.u, draws)
    return without_moments(draws, found.p)


def _estimate(law: Law, row: int, knowledge: Knowledge, found: tuple[MonteCarlo, Output | None]) -> Estimate:
    monte_carlo, output = found
    line, u = law.linear[row], law.u(row)
    measurand = line.measurand
    dof, note = law.dof(row)
    rows = budget(law, row)
    return Estimate(
        name=measurand.name,
        value=line.value,
        u=u,
        unit=measurand.unit,
        dof=dof,
        dof_note=note,
        coverage=law.coverage(row, monte_carlo.p),
        monte_carlo=monte_carlo,
        budget=rows,
        advice=advise(measurand.name, u, measurand.unit, rows, knowledge),
        equation=measurand.equation,
        output=output,
    )


def _check_plan(plan: Plan) -> None:
    faults = []
    if not (isfinite(plan.probability) and 0 < plan.probability < 1):
        faults.append(Fault("probability", repr(plan.probability), "a probability above 0 and below 1, such as 0.95"))
    if plan.seed < 0:
        faults.append(Fault("seed", repr(plan.seed), "a whole number, zero or more"))
    if not 1 <= plan.digits <= 4:
        faults.append(Fault("digits", repr(plan.digits), "1, 2, 3 or 4 significant digits"))
    if plan.max_trials < 1000:
        faults.append(Fault("max_trials", repr(plan.max_trials), "at least 1000 trials"))
    if faults:
        raise MetrologyError(*faults)
