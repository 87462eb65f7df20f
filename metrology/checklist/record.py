"""What a checklist looks at: the declared part of a campaign, whether it was evaluated or not."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from metrology.findings import Conformity, Findings, TestItem, Withheld
from metrology.identification import CampaignItem, SampleItem


@dataclass(frozen=True)
class Demand:
    """A requirement as a checklist sees it: where it stands, when its rule was agreed, whether it is closed."""

    id: str
    source: str
    agreed: str
    close_out: str


@dataclass(frozen=True)
class Record:
    """The declared part of a campaign; `results` says whether there is a result, or will be one."""

    campaign: CampaignItem
    samples: tuple[SampleItem, ...]
    tests: tuple[TestItem, ...]
    demands: tuple[Demand, ...]
    results: bool


def of_findings(findings: Findings) -> Record:
    """Return the record of an evaluated campaign; of a requirement without a result nothing is known."""
    stated: tuple[Conformity | Withheld, ...] = (*findings.conformity, *findings.withheld)
    judged = tuple(Demand(v.requirement, v.source, v.agreed, v.close_out) for v in stated)
    known = {demand.id for demand in judged}
    return Record(
        findings.campaign,
        findings.samples,
        findings.tests,
        judged + tuple(Demand(name, "", "", "") for name in findings.unjudged if name not in known),
        any(isfinite(result.value) and isfinite(result.u) for result in findings.results),
    )
