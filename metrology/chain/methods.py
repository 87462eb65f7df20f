"""The tests of a campaign, each by its method: what it puts into the measurement model, and what it shows."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from metrology import raw
from metrology.chain import diagnosis
from metrology.chain.items import test_items
from metrology.errors import Fault, MetrologyError, faults_at
from metrology.message import said
from metrology.method import Task
from metrology.methods import METHODS

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.chain.plan import Plan
    from metrology.diagnosis import Diagnosis
    from metrology.method import Analysed, Finding

Progress = Callable[[str], None]


def add_tests(plan: Plan, campaign: Campaign, progress: Progress) -> None:
    """Add every test, each method after those whose results it takes."""
    items = {item.id: item for item in test_items(campaign)}
    for method in METHODS:
        for name, test in campaign.tests.items():
            if test.method == method:
                items[name] = items[name].showing(add_test(plan, campaign, name, progress))
    plan.tests.extend(items.values())


def add_test(plan: Plan, campaign: Campaign, name: str, progress: Progress) -> Finding:
    """Add a test and its diagnosis to the plan, and return what it showed.

    Raises
    ------
    MetrologyError
        For readings that the method cannot use, and for a method that gives neither a result that it promises nor a
        sentence why.
    """
    test = campaign.tests[name]
    method = METHODS[test.method]
    task = Task(plan, campaign, name, test, method, progress)
    failed = len(plan.failures)
    with faults_at(campaign.at("tests", name)):
        analysed = method.analyse(task)
    if len(plan.failures) == failed:
        _check_results(plan, campaign, task)
    plan.ready[name] = analysed.ready
    found = None
    if any(check.name == raw.NAME and check.passed is False for check in getattr(analysed.finding, "checks", ())):
        text = "{name} was not diagnosed: a model cannot explain what its recorder did."
        plan.warnings.append(said(text, name=name))
    else:
        found = diagnosis.add(task, analysed.ready, off=campaign.diagnosis.off)
    if found is not None and found.supported is not None:
        _correct(plan, task, analysed, found)
    return analysed.finding


def _correct(plan: Plan, task: Task[Any], analysed: Analysed[Any], found: Diagnosis) -> None:
    """Let the results of a test come from the model that the data support."""
    stated, corrected = analysed.stated, task.method.corrected
    if stated is None or corrected is None or not stated.measurands:
        return
    try:
        new = corrected(task, analysed.ready, stated, found)
    except (ArithmeticError, ValueError) as error:
        # An oscillator that no longer swings, say: the diagnosis stands, and its model gives no result.
        text = "{name} has no result by the model of its diagnosis ({error:quoted})."
        plan.undiagnosed[task.name] = said(text, name=task.name, error=str(error))
        plan.warnings.append(plan.undiagnosed[task.name])
        return
    if new is stated:
        return
    plan.exchange(stated, new)
    for name in {one.name for one in stated.measurands} - {one.name for one in new.measurands}:
        del plan.identities[name]
    for measurand in new.measurands:
        plan.identities.setdefault(measurand.name, task.identity(measurand, headline=False))
    plan.corrected[task.name] = (stated, new)


def _check_results(plan: Plan, campaign: Campaign, task: Task[Any]) -> None:
    promised = task.method.yields(campaign, task.test)
    lacking = [result for result in promised if f"{task.name}.{result}" not in plan.identities]
    if lacking:
        got = f"no result {', '.join(lacking)} by method '{task.test.method}', and no failure"
        fix = f"'analyse' of metrology.methods.{task.test.method} has to add what its 'yields' promises"
        raise MetrologyError(Fault(campaign.at("tests", task.name), got, f"all of {', '.join(promised)}", fix))
