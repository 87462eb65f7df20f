"""The sections of a report: template, title and part of each, in order, and which of them a report has."""

from __future__ import annotations

from metrology.findings import Findings
from metrology.language import attention

SECTIONS = (
    ("methods", "Methods", "annex"),
    ("tests", "Results of each test", "annex"),
    ("diagnosis", "Diagnosis of the models", "annex"),
    ("fits", "Calibration lines and curves", "annex"),
    ("budgets", "Uncertainty of each result", "annex"),
    ("correlations", "Correlations of the results", "annex"),
    ("conformity", "Conformity with requirements", "annex"),
    ("comparisons", "Comparisons", "annex"),
    ("audit", "Audit of published and expected figures", "annex"),
    ("opinions", "Opinions and interpretations", "annex"),
    ("scope", "Purpose, place and sampling", "annex"),
    ("samples", "Items tested", "annex"),
    ("instruments", "Instruments and their calibration", "annex"),
    ("environment", "Dates, persons and conditions", "annex"),
    ("deviations", "Deviations, exclusions and anomalies", "annex"),
    ("references", "References", "annex"),
    ("metrics", "Records of the response tests", "quality"),
    ("candidates", "Records of the diagnosis", "quality"),
    ("sources", "Inputs and their sources", "quality"),
    ("trials", "Records of the Monte Carlo method", "quality"),
    ("notices", "Notices of the certificate, in full", "quality"),
    ("provenance", "Provenance", "quality"),
    ("checklist", "Checklists of the report", "quality"),
)
"""Template, title and part of every section after the certificate, in order."""


def sections(findings: Findings) -> list[tuple[str, str]]:
    """Template and title of the sections of the parts that the report has; without those that would be empty."""
    full = {
        "tests": findings.tests, "diagnosis": findings.diagnosis, "fits": findings.fits, "budgets": findings.results,
        "correlations": findings.correlations, "conformity": findings.conformity or findings.withheld,
        "comparisons": findings.comparisons or findings.consensus, "audit": findings.audit,
        "opinions": findings.campaign.opinions,
        "samples": findings.samples, "instruments": findings.instruments, "environment": findings.tests,
        "metrics": any(test.by == "response" for test in findings.tests), "candidates": findings.diagnosis,
        "sources": any(result.budget for result in findings.results),
        "trials": any(result.headline for result in findings.results), "notices": attention.attention(findings),
        "checklist": findings.campaign.checklists,
    }  # fmt: skip
    parts = findings.campaign.parts
    return [(name, title) for name, title, part in SECTIONS if part in parts and full.get(name, True)]


def first_record(findings: Findings) -> str:
    """The section with which the records of quality assurance begin."""
    records = {name for name, _, part in SECTIONS if part == "quality"}
    return next((name for name, _ in sections(findings) if name in records), "")
