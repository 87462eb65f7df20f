"""Names of causes: one that a single component names, and one that means another thing elsewhere."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.errors import MetrologyError
from metrology.report.results import files

HEAD = "format: metrology-campaign/1\nid: {id}\ntitle: Causes\n"
THERE = """\
causes:
  mic: {standard: 1 um, source: certificate M-1}
quantities:
  a: {value: 10.000 mm, uncertainty: [{cause: mic}]}
  b: {value: 4.000 mm, uncertainty: [{cause: mic, standard: 2 um}]}
derived:
  - {quantity: d, expression: a + b, unit: mm}
"""


def campaign(folder: Path, name: str, text: str):
    path = folder / f"{name}.yaml"
    path.write_text(HEAD.replace("{id}", name) + text, encoding="utf-8")
    return load(path)


def test_law_a_cause_that_one_component_names_is_said(tmp_path):
    alone = THERE.replace("cause: mic, standard: 2 um", "standard: 2 um, source: certificate M-1")
    said = [" ".join(chain.evaluate(campaign(tmp_path, "one", text), coverage=False).warnings)
            for text in (alone, THERE)]  # fmt: skip
    assert ["one component alone names this cause" in each for each in said] == [True, False]


@pytest.mark.parametrize(
    ("own", "fits"),
    [
        ("{standard: 3 um, source: certificate M-1}", True),
        ("{description: the micrometer}", True),
        ("{half_width: 1 um, distribution: rectangular, source: another micrometer}", False),
        ("{standard: 1 um, dof: 3, source: another micrometer}", False),
    ],
)
def test_refusal_an_imported_cause_of_another_distribution(own, fits, tmp_path):
    """Two unknowns of one name were one: u was a tenth too small."""
    found = chain.evaluate(campaign(tmp_path, "there", THERE), coverage=False)
    raw = files(found)["results.json"]
    (tmp_path / "results.json").write_bytes(raw)
    here = (
        f"causes:\n  mic: {own}\nquantities:\n"
        f"  d: {{from: results.json, result: d, sha256: {sha256(raw).hexdigest()}}}\n"
        "  c: {value: 1.000 mm, uncertainty: [{cause: mic, standard: 1 um}]}\n"
        "derived:\n  - {quantity: s, expression: c + d, unit: mm}\n"
    )
    if fits:
        campaign(tmp_path, "here", here)
        return
    with pytest.raises(MetrologyError, match="give one of the two another name"):
        campaign(tmp_path, "here", here)
