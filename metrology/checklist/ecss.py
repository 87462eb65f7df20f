"""ECSS-E-ST-10-02C Rev.1, Annex C: what a test report contains; the words are our own."""

from __future__ import annotations

from metrology.checklist.item import Item
from metrology.checklist.places import campaign, deviations, each, requirements, results, stated, together, without
from metrology.message import said

_NO_TEST = said("no test was declared")
_NO_REQUIREMENT = said("no requirement was stated")

ITEMS = (
    Item(
        "C.1.2",
        "configuration of the test article and of the set-up",
        "samples.*.configuration, tests.*.setup",
        "samples, environment",
        together(each("samples", "configuration"), each("tests", "setup")),
        without("tests", _NO_TEST),
    ),
    Item(
        "C.2.1 <1> a",
        "purpose and objective of the test, and the reason for it",
        "purpose",
        "scope",
        campaign("purpose"),
    ),
    Item(
        "C.2.1 <1> b",
        "open issues, assumptions and constraints",
        "assumptions, anomalies",
        "scope, deviations",
        stated("assumptions", "anomalies"),
    ),
    Item("C.2.1 <2> a", "applicable and reference documents", "documents", "references", stated("documents")),
    Item(
        "C.2.1 <2> b",
        "test procedure and test specification",
        "tests.*.procedure, specification",
        "methods, environment",
        each("tests", "procedure", "specification"),
        without("tests", _NO_TEST),
    ),
    Item("C.2.1 <3>", "definitions and abbreviations", "", "references"),
    Item("C.2.1 <4> a", "results with the data behind them", "tests", "tests", results),
    Item(
        "C.2.1 <4> a",
        "dates of execution",
        "tests.*.date",
        "environment",
        each("tests", "date"),
        without("tests", _NO_TEST),
    ),
    Item(
        "C.2.1 <4> a",
        "the procedure as it was run",
        "tests.*.as_run",
        "environment",
        each("tests", "as_run"),
        without("tests", _NO_TEST),
    ),
    Item(
        "C.2.1 <4> a",
        "results of the test facility: place, conditions, instruments",
        "place, tests.*.environment",
        "environment",
        together(campaign("place"), each("tests", "environment")),
        without("tests", _NO_TEST),
    ),
    Item("C.2.1 <4> b", "analysis of the data and its assessment", "tests, derived", "budgets", results),
    Item("C.2.1 <4> c", "a synthesis of the results", "tests, derived", "cover", results),
    Item(
        "C.2.1 <5> a",
        "deviations from the procedure",
        "deviations, tests.*.deviations",
        "deviations",
        deviations,
        without("tests", _NO_TEST),
    ),
    Item("C.2.1 <5> a", "nonconformances, failures and problems", "anomalies", "deviations", stated("anomalies")),
    Item(
        "C.2.1 <6> a 1 (a)",
        "the requirements to be verified, as the verification control document lists them",
        "requirements.*.source",
        "conformity",
        requirements("source", "source"),
        without("demands", _NO_REQUIREMENT),
    ),
    Item("C.2.1 <6> a 1 (b)", "traceability to the documents used", "documents", "references", stated("documents")),
    Item(
        "C.2.1 <6> a 1 (c)",
        "conformance or deviation, with signature and date",
        "report.authorised_by, issued",
        "cover",
        campaign("authorised_by=report.authorised_by", "issued=report.issued"),
    ),
    Item(
        "C.2.1 <6> a 2",
        "comparison with the requirements",
        "requirements",
        "conformity",
        spared=without("demands", _NO_REQUIREMENT),
    ),
    Item(
        "C.2.1 <6> a 3",
        "judgement whether the verification is closed",
        "requirements.*.close_out",
        "conformity",
        requirements("close_out", "close_out"),
        without("demands", _NO_REQUIREMENT),
    ),
    Item("C.2.1 <6> b", "open issues, stated and described", "anomalies", "cover", stated("anomalies")),
    Item("C.2.1 <6> c", "references to separate analyses", "documents", "references", stated("documents")),
)
"""Every item of the annex, in its order."""
