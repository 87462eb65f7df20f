"""ISO/IEC 17025:2017, clause 7.8, for a test report: 7.8.2, 7.8.3 and 7.8.5 to 7.8.8; the words are our own."""

from __future__ import annotations

from metrology.checklist.item import Item
from metrology.checklist.places import campaign, deviations, each, requirements, results, stated, together, without
from metrology.checklist.record import Record
from metrology.message import said

_NO_TEST = said("no test was declared; the equations stand under Methods")
_NO_ITEM = said("no item was declared")
_NO_REQUIREMENT = said("no requirement was stated, so no statement of conformity is made")


def _sampled(record: Record) -> str:
    nobody = record.campaign.sampling.casefold() == "none"
    return said("the laboratory did not sample; it tested what it was given") if nobody else ""


def _first_issue(record: Record) -> str:
    return "" if record.campaign.replaces else said("a first issue: the report replaces none")


def _no_opinion(record: Record) -> str:
    opinions, is_stated = record.campaign.opinions, "opinions" in record.campaign.stated
    return said("the report holds no opinion") if is_stated and not opinions else ""


def _nothing_asked(record: Record) -> str:
    return "" if record.campaign.remarks else said("neither method nor customer asked for more")


ITEMS = (
    Item("7.8.2.1 a", "a title", "", "cover"),
    Item(
        "7.8.2.1 b",
        "name and address of the laboratory",
        "laboratory",
        "cover",
        campaign("laboratory.name", "laboratory.address"),
    ),
    Item("7.8.2.1 c", "where the tests were made", "place", "scope", campaign("place")),
    Item(
        "7.8.2.1 d",
        "one identification on every page, pages numbered, the end marked",
        "report.number",
        "page",
        campaign("report_number=report.number"),
    ),
    Item(
        "7.8.2.1 e",
        "name and contact of the customer",
        "customer",
        "cover",
        campaign("customer.name", "customer.contact"),
    ),
    Item(
        "7.8.2.1 f",
        "which method was used, with its edition",
        "tests.*.procedure",
        "methods",
        each("tests", "procedure"),
        without("tests", _NO_TEST),
    ),
    Item(
        "7.8.2.1 g",
        "description, identification and condition of each item",
        "samples.*.material, condition",
        "samples",
        each("samples", "material", "condition"),
        without("samples", _NO_ITEM),
    ),
    Item(
        "7.8.2.1 h",
        "when the items were received, and sampled where it matters",
        "samples.*.received",
        "samples",
        each("samples", "received"),
        without("samples", _NO_ITEM),
    ),
    Item(
        "7.8.2.1 i",
        "when the tests were made",
        "tests.*.date",
        "environment",
        each("tests", "date"),
        without("tests", _NO_TEST),
    ),
    Item("7.8.2.1 j", "when the report was issued", "report.issued", "cover", campaign("issued=report.issued")),
    Item("7.8.2.1 k", "sampling plan and method", "sampling", "scope", campaign("sampling")),
    Item("7.8.2.1 l", "that the results relate only to the items tested", "", "page"),
    Item("7.8.2.1 m", "the results, with their units", "tests, derived", "cover", results),
    Item(
        "7.8.2.1 n",
        "additions to, deviations and exclusions from the method, also that there are none",
        "deviations, tests.*.deviations",
        "deviations",
        deviations,
        without("tests", _NO_TEST),
    ),
    Item(
        "7.8.2.1 o",
        "who authorises the report",
        "report.authorised_by",
        "cover",
        campaign("authorised_by=report.authorised_by"),
    ),
    Item("7.8.2.1 p", "which results are those of external providers", "provided", "scope", stated("provided")),
    Item(
        "7.8.2.2",
        "which data the customer supplied, with a disclaimer where they bear on the results",
        "provided",
        "scope",
        stated("provided"),
    ),
    Item(
        "7.8.3.1 a",
        "conditions of the test, such as those of the environment",
        "tests.*.environment",
        "environment",
        each("tests", "environment"),
        without("tests", _NO_TEST),
    ),
    Item(
        "7.8.3.1 b",
        "a statement of conformity with requirements, where one is relevant",
        "requirements",
        "conformity",
        spared=without("demands", _NO_REQUIREMENT),
    ),
    Item("7.8.3.1 c", "uncertainties in the unit of the result", "tests, derived", "budgets", results),
    Item(
        "7.8.3.1 d",
        "opinions and interpretations, where appropriate",
        "opinions",
        "opinions",
        stated("opinions"),
        _no_opinion,
    ),
    Item(
        "7.8.3.1 e", "what else the method or the customer asks for", "report.remarks", "cover", spared=_nothing_asked
    ),
    Item(
        "7.8.3.2, 7.8.5",
        "what matters of the sampling, where the laboratory is responsible for it",
        "sampling",
        "scope",
        campaign("sampling"),
        _sampled,
    ),
    Item(
        "7.8.4",
        "what a calibration certificate says beyond a test report",
        "",
        "instruments",
        spared=lambda _record: said("a test report, not a calibration certificate"),
    ),
    Item(
        "7.8.6.1",
        "the decision rule with its risk, agreed before the test",
        "requirements.*.decision.agreed",
        "conformity",
        requirements("agreed", "decision.agreed"),
        without("demands", _NO_REQUIREMENT),
    ),
    Item(
        "7.8.6.2",
        "to which result a verdict applies, which specification is met or not, by which rule",
        "requirements.*.source",
        "conformity",
        requirements("source", "source"),
        without("demands", _NO_REQUIREMENT),
    ),
    Item(
        "7.8.7",
        "opinions distinguished from results, with their basis and whose they are",
        "opinions",
        "opinions",
        stated("opinions"),
        _no_opinion,
    ),
    Item(
        "7.8.8",
        "of an amended report: which one it replaces, what was changed and why",
        "report.replaces",
        "cover",
        together(),
        _first_issue,
    ),
)
"""Every item of the clause, in its order."""
