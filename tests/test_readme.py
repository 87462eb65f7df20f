"""What the README shows runs as shown."""

from __future__ import annotations

import re
from pathlib import Path

from metrology import chain
from metrology.campaign.load import load

ROOT = Path(__file__).parents[1]


def block(kind):
    (text,) = re.findall(rf"```{kind}\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    return text


def test_campaign_of_the_readme_runs_and_passes(tmp_path):
    (tmp_path / "campaign.yaml").write_text(block("yaml"), encoding="utf-8")
    (tmp_path / "wire.csv").write_text(block("csv"), encoding="utf-8")
    assert len(block("yaml").splitlines()) <= 20
    findings = chain.evaluate(load(tmp_path / "campaign.yaml"))
    (k,) = [result for result in findings.results if result.name == "pull.k"]
    assert abs(k.value - 2 * 9.8065 / 0.98e-3) < 2 * k.u
    assert [entry.verdict for entry in findings.conformity] == ["pass"]


def test_links_of_the_documents_lead_somewhere():
    for path in (ROOT / "README.md", *ROOT.glob("docs/**/*.md")):
        for target in re.findall(r"\]\(([^)#:]+?)(?:#[^)]*)?\)", path.read_text(encoding="utf-8")):
            assert (path.parent / target).exists(), f"{path.name}: {target}"
