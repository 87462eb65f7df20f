"""The same quantity of one sample by several tests: a consensus value, and what explains that they disagree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import replace
from itertools import combinations
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from metrology import ties
from metrology.campaign.copies import of_one_record
from metrology.chain import items
from metrology.chain.contradictions import BETWEEN, ELSEWHERE
from metrology.chain.exact import TENTH
from metrology.consensus import Consensus, Disagreement, Member
from metrology.gum import consensus as gum
from metrology.gum.output import expanded
from metrology.message import counted, said
from metrology.method import Loading
from metrology.methods import METHODS

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.chain.doubt import Doubt
    from metrology.chain.plan import Plan
    from metrology.gum.evaluation import Estimate, Evaluation

FAMILIES = {"k": ("k", "k_t", "k_0"), "E": ("E", "E_t", "E_0"), "c": ("c",)}
"""Quantity → results that are it: of each test the first that it gives, so that one record counts once. A relaxation is
taken at the stated time where there is one."""
SAME = 1 - 1e-6
"""Correlation from which on a result says nothing that the other one does not."""

Group = tuple[str, str, str]
"""Quantity, sample, unit."""


def groups(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> dict[Group, list[str]]:
    """Results of each quantity of a sample that two tests or more give, by name; k where it is of the whole sample."""
    found: dict[Group, dict[str, str]] = {}
    for quantity, symbols in FAMILIES.items():
        for symbol in symbols:
            for name, one in plan.identities.items():
                if one.quantity == symbol and one.test and one.sample and name in evaluation.estimates:
                    group = quantity, one.sample, evaluation.estimates[name].unit
                    if quantity == "k" and not loading(campaign, plan, evaluation, one.test).whole:
                        continue
                    found.setdefault(group, {}).setdefault(one.test, name)
    return {group: list(by_test.values()) for group, by_test in found.items() if len(by_test) > 1}


def pairs(campaign: Campaign, plan: Plan, evaluation: Evaluation) -> Iterator[tuple[str, str]]:
    """Names of every two results that are one quantity of one sample; E not where it says what k says."""
    found = groups(campaign, plan, evaluation)
    for group, names in found.items():
        if not follows(group, found, plan):
            yield from combinations(names, 2)


def follows(group: Group, found: Mapping[Group, Sequence[str]], plan: Plan) -> bool:
    """Whether a group is E of tests whose k are compared: with one section and one length it says nothing else."""
    quantity, sample, _ = group
    tests = {plan.identities[name].test for name in found[group]}
    by_k = {
        plan.identities[name].test for (of, whose, _), names in found.items() if (of, whose) == ("k", sample)
        for name in names
    }  # fmt: skip
    return quantity == "E" and tests <= by_k


def consensus(
    campaign: Campaign, plan: Plan, evaluation: Evaluation, doubts: Mapping[str, Sequence[Doubt]]
) -> tuple[tuple[Consensus, ...], tuple[Disagreement, ...]]:
    """Return the consensus of every quantity that several tests give, and what explains those that disagree.

    Parameters
    ----------
    doubts : mapping of str to sequence of Doubt
        By result: failed checks on its way.
    """
    found = groups(campaign, plan, evaluation)
    made: dict[Group, Consensus] = {}
    once = of_one_record(campaign) if found else set()
    for group, names in found.items():
        one = _combined(group, once, [_Result(campaign, plan, evaluation, name, doubts) for name in names])
        if one.consistent is False and follows(group, found, plan):
            also = said("The cause is sought in the results of k.")
            one = replace(one, sentence=said("{texts:space}", texts=(one.sentence, also)))
        made[group] = one
    sought = [group for group, one in made.items() if one.consistent is not None and not follows(group, found, plan)]
    parted = []
    for kind in dict.fromkeys((quantity, unit) for quantity, _, unit in sought):
        those = [made[group] for group in sought if (group[0], group[2]) == kind]
        if any(not one.consistent for one in those):
            parted.append(_explained(campaign, plan, evaluation, those))
    return tuple(made.values()), tuple(parted)


class _Result:
    """A result as a member of a consensus."""

    def __init__(
        self, campaign: Campaign, plan: Plan, evaluation: Evaluation, name: str, doubts: Mapping[str, Sequence[Doubt]]
    ) -> None:
        self.name, self.identity = name, plan.identities[name]
        self.estimate, self.evaluation = evaluation.estimates[name], evaluation
        self.loading = loading(campaign, plan, evaluation, self.identity.test)
        self.value, self.u = self.estimate.reported
        self.why_not = self._why_not(doubts.get(name, ()))

    def _why_not(self, doubts: Sequence[Doubt]) -> str:
        if not (isfinite(self.value) and isfinite(self.u) and self.estimate.output is not None):
            return said("it has no value with an uncertainty")
        if self.value <= 0 or self.estimate.value <= 0 or self.u > self.value:
            return said("it is not known to be above zero")
        if self.u == 0:
            return said("it has no uncertainty")
        # Whether a result fits others, and what is known from elsewhere, is what the consensus is asked.
        kept = [one for one in doubts if one.check != BETWEEN and not one.shape]
        kept = [one for one in kept if not (one.check == ELSEWHERE and one.covered)]
        barring = tuple(one.sentence for one in kept if one.bars("pass"))
        return said("{texts:space}", texts=barring) if barring else ""

    def with_(self, other: _Result) -> float:
        """Covariance by the GUM uncertainty framework; of a result with itself, (U/k_p)² of its reported interval.

        k_p is that of a normal distribution: few degrees of freedom count as a larger u, as they do in E_n. What two
        results share is in their covariance alone.
        """
        from scipy.special import ndtri

        if other is self:
            output, p = self.estimate.output, self.estimate.coverage.p
            assert output is not None
            return max(expanded(output, p) / float(ndtri((1 + p) / 2)), self.u, self.estimate.u) ** 2
        return correlation(self.evaluation, self.name, other.name) * self.estimate.u * other.estimate.u


def correlation(evaluation: Evaluation, a: str, b: str) -> float:
    """Correlation coefficient of two results; 0 of what is no result."""
    if a not in evaluation.names or b not in evaluation.names:
        return 0.0
    return evaluation.correlation[evaluation.names.index(a)][evaluation.names.index(b)] or 0.0


def loading(campaign: Campaign, plan: Plan, evaluation: Evaluation, name: str) -> Loading:
    """How a test loads its sample; an oscillation answers in 1/ω_n."""
    test = campaign.tests[name]
    finding = next(one.finding for one in plan.tests if one.id == name)
    stated = METHODS[test.method].loading
    if stated is not None:
        return stated(campaign, name, test, finding)
    omega: Estimate | None = evaluation.estimates.get(f"{name}.omega_n")
    return Loading(1 / omega.value if omega is not None and omega.value > 0 else None)


def _combined(group: Group, once: Set[frozenset[str]], results: Sequence[_Result]) -> Consensus:
    """Combine results, one of each record; `once`: pairs of tests that evaluate the same one."""
    quantity, sample, unit = group
    counted: list[_Result] = []
    for one in results:
        same = next((r for r in counted if abs(correlation(one.evaluation, one.name, r.name)) > SAME), None)
        if same is not None and not one.why_not:
            one.why_not = said("it has no uncertainty that {name} does not share", name=same.name)
        again = next((r for r in counted if frozenset((r.identity.test, one.identity.test)) in once), None)
        if again is not None and not one.why_not:
            one.why_not = said("it is of the same record as {name}", name=again.name)
        counted += [one] if not one.why_not else []
    first = results[0]
    bare = Consensus(
        sample, quantity, unit, first.identity.display_unit or unit, tuple(_member(one) for one in results), None, None,
        first.estimate.coverage.p, None, None, None, None, None, None, None, None,
        _too_few(len(counted), len(results)),
    )  # fmt: skip
    if len(counted) < 2:
        return bare
    covariance = np.array([[one.with_(other) for other in counted] for one in counted])
    made = gum.combine(np.array([one.value for one in counted]), covariance, probability=bare.p)
    at = {one.name: index for index, one in enumerate(counted)}
    each = dict(zip(at, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    members = tuple(
        # A weight is known to some per cent; rounded, it is the same on every processor.
        replace(one, weight=round(float(made.weights[at[one.result]]), 7), en=float(made.en[at[one.result]]))
        if one.result in at else one for one in bare.members
    )  # fmt: skip
    return replace(
        bare, members=members, value=made.value, u=made.u, low=made.low, high=made.high, dof=made.dof,
        consistent=made.consistent, statistic=made.statistic, p_value=made.p_value, birge=made.birge,
        between=made.between, sentence=_sentence(made, each),
    )  # fmt: skip


def _member(one: _Result) -> Member:
    return Member(
        one.name, one.identity.test, one.identity.method, one.value, one.u, one.loading.seconds, None, None, one.why_not
    )


def _too_few(count: int, whole: int) -> str:
    if not count:
        return said("None of {whole} results count: there is no consensus.", whole=whole)
    one = "{count} of {whole} results counts: there is no consensus."
    many = "{count} of {whole} results count: there is no consensus."
    return counted(one, many, count, whole=whole)


FEW = said(
    "Two results say little of the scatter between methods: the interval, far wider than ± 2u, is the one to use."
)
"""Of a consensus of two results that are not consistent."""


def _sentence(made: gum.Combined, of: Mapping[str, float]) -> str:
    """What is said of a consensus; `of`: standard uncertainty of each result, by its name."""
    n = len(of)
    freedom = counted("{count} degree of freedom", "{count} degrees of freedom", n - 1)
    test = said(
        "χ² = {statistic:.3g} with {freedom}, Birge ratio {birge:.2g}", statistic=made.statistic, freedom=freedom,
        birge=made.birge,
    )  # fmt: skip
    if made.consistent:
        text = "The {n} results are consistent ({test}): mean by generalised least squares with their joint covariance."
        sentence = said(text, n=n, test=test)
        best = min(of, key=lambda name: ties.level(of[name]))
        if of[best] > TENTH * made.u:
            return sentence
        alone = said("It rests on {name}, whose u is less than a tenth larger by itself.", name=best)
        return said("{texts:space}", texts=(sentence, alone))
    text = (
        "The {n} results differ by more than their uncertainties ({test}): mean with a scatter between the methods of "
        "{percent:.2g} %, interval by Student's t with {freedom}."
    )
    sentence = said(text, n=n, test=test, percent=100 * made.between, freedom=freedom)
    return said("{texts:space}", texts=(sentence, FEW)) if n == 2 else sentence


def _explained(campaign: Campaign, plan: Plan, evaluation: Evaluation, those: Sequence[Consensus]) -> Disagreement:
    from metrology.diagnostics.across import explain
    from metrology.diagnostics.single import Rows

    quantity = those[0].quantity
    members = [(one.sample, each) for one in those for each in one.members if not each.why_not]
    results = [_Result(campaign, plan, evaluation, each.result, {}) for _, each in members]
    values = np.array([one.value for one in results])
    covariance = np.array([[one.with_(other) for other in results] for one in results])
    tests = tuple(each.test for _, each in members)
    dates = [campaign.tests[test].date for test in tests]
    k = [_stiffness(evaluation, test) for test in tests]
    return explain(
        Rows(
            tests=tests, samples=tuple(sample for sample, _ in members),
            values=values, covariance=covariance / np.outer(values, values),
            seconds=np.array([np.nan if each.seconds is None else each.seconds for _, each in members]),
            rigs=tuple(_rig(campaign, one) for one in results),
            instruments=tuple(tuple(items.roles(campaign.tests[test]).values()) for test in tests),
            days=tuple(0 if date is None else date.toordinal() for date in dates),
            stiffness=np.array([np.nan if one is None else one for one in k]), damping=quantity == "c",
        ),
        quantity,
    )  # fmt: skip


def _stiffness(evaluation: Evaluation, test: str) -> float | None:
    found = (evaluation.estimates.get(f"{test}.{symbol}") for symbol in FAMILIES["k"])
    return next((one.value for one in found if one is not None and isfinite(one.value) and one.value > 0), None)


def _rig(campaign: Campaign, one: _Result) -> str:
    """What bears the sample: the stated configuration, else method and instruments; none where it does not give way."""
    test = campaign.tests[one.identity.test]
    if not one.loading.setup:
        return ""
    return test.setup or f"{test.method}: {test.instruments.model_dump()}"
