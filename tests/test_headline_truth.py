"""What page 1 prints of the shipped campaigns against what their generators planted, and verdicts about it.

The generators (campaigns/**/reconstruct_*.py) integrate equations of their own, with more physics than the models.
"""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from metrology import chain
from metrology.campaign.load import load
from metrology.findings import Findings, Result

FOLDER = Path(__file__).parents[1] / "campaigns"
FAR = 2.5
"""Standard uncertainties within which the truth has to be."""
REQUIREMENT = """\
  - {{id: {id}, text: a limit beside the truth, quantity: {quantity}, limits: {{{side}: {limit!r} {unit}}},
     decision: {{rule: simple acceptance, agreed: 2026-01-05}}}}
"""


def script(name: str) -> ModuleType:
    path = next(FOLDER.rglob(f"{name}.py"))
    sys.path.insert(0, str(path.parent))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(path.parent))


def planted_damping() -> dict[str, float]:
    """Damping coefficient that the generator of the decays settles on, for each tape."""
    made, found = script("reconstruct_decay"), {}
    records = made.records

    def watched(tape, damping):
        found[f"{tape.name}-decay.c"] = damping
        return records(tape, damping)

    made.records = watched
    try:
        for tape in made.TAPES:
            made.adjusted(tape)
    finally:
        made.records = records
    return found


def planted_of_tapes() -> dict[str, float]:
    made = script("reconstruct_decay")
    static = {f"{tape.name}-elongation.k": tape.static for tape in made.TAPES}
    return static | {f"{tape.name}-decay.k": tape.dynamic for tape in made.TAPES} | planted_damping()


def planted_of_line(name: str) -> dict[str, float]:
    line = script("reconstruct_response").LINES[name]
    return {f"{name}-response.k": line.k, f"{name}-response.c": line.c}


def planted_of_static_lines() -> dict[str, float]:
    found = {}
    for line in script("reconstruct_lines").LINES:
        name = line.file.removesuffix(".csv")
        dynamic = script("reconstruct_response").LINES[name]
        assert (line.k, line.cubic) == (dynamic.k, dynamic.cubic)
        found[f"{name}-elongation.k"] = line.k
    return found


def planted_of_aramid() -> dict[str, float]:
    made = script("reconstruct_tension")
    return {"aramid-tension.k": made.EA / made.LENGTH}


def planted_of_polyester() -> dict[str, float]:
    made = script("reconstruct_relaxation")
    static = made.E_0 * (1 - sum(made.PARTS))
    return {"polyester-relaxation.E_0": made.E_0, "polyester-relaxation.E_inf": static}


def with_requirements(folder: Path, name: str, truth: dict[str, float], found: dict[str, Result]) -> Path:
    """The campaign with a lower and an upper limit on every result, five u on either side of the truth."""
    for path in (FOLDER / name).rglob("*"):
        if path.is_file():
            copy = folder / name / path.relative_to(FOLDER / name)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())
    text = (folder / name / "campaign.yaml").read_text(encoding="utf-8")
    asked = "requirements:\n"
    for at, (full, value) in enumerate(truth.items()):
        result = found[full]
        for side in ("lower", "upper"):
            for sign, word in ((-5, "below"), (5, "above")):
                asked += REQUIREMENT.format(
                    id=f"{side}-{word}-{at}", quantity=full, side=side, limit=value + sign * result.u,
                    unit=result.unit.replace("*", "·"),
                )  # fmt: skip
    own = re.search(r"^requirements:.*?(?=^\S|\Z)", text, flags=re.MULTILINE | re.DOTALL)
    text = text.replace(own[0], asked) if own else text + asked
    (folder / name / "campaign.yaml").write_text(text, encoding="utf-8")
    return folder / name / "campaign.yaml"


def judged(findings: Findings, truth: dict[str, float], found: dict[str, Result]) -> None:
    """A limit that the truth meets is never failed, one that it breaks never passed; unbarred ones are decided."""
    barred = {one.requirement for one in findings.withheld} | set(findings.unjudged)
    verdicts = {one.requirement: one.verdict for one in findings.conformity}
    right = {"lower-below": "pass", "lower-above": "fail", "upper-above": "pass", "upper-below": "fail"}
    for at, quantity in enumerate(truth):
        for limit, verdict in right.items():
            name = f"{limit}-{at}"
            assert name in barred or verdicts[name] == verdict, (quantity, name, verdicts[name])


def near(findings: Findings, truth: dict[str, float]) -> dict[str, Result]:
    found = {result.name: result for result in findings.results}
    for name, value in truth.items():
        result = found[name]
        assert result.headline
        assert abs(result.value - value) <= FAR * result.u, (name, result.value, result.u, value)
    return found


CASES = [
    pytest.param("aramid", planted_of_aramid, id="aramid"),
    pytest.param("lines", planted_of_static_lines, id="lines"),
    pytest.param("polyester", planted_of_polyester, id="polyester"),
    pytest.param("tapes", planted_of_tapes, id="tapes", marks=pytest.mark.study),
    pytest.param("nylon", lambda: planted_of_line("nylon"), id="nylon", marks=pytest.mark.study),
    pytest.param("spectra", lambda: planted_of_line("spectra"), id="spectra", marks=pytest.mark.study),
]


@pytest.mark.long
@pytest.mark.parametrize(("name", "planted"), CASES)
def test_planted_headline_values_hold_the_truth_and_verdicts_are_right(name, planted, tmp_path):
    truth = planted()
    found = near(chain.evaluate(load(FOLDER / name / "campaign.yaml")), truth)
    judged(chain.evaluate(load(with_requirements(tmp_path, name, truth, found))), truth, found)


@pytest.mark.study
def test_planted_the_table_alone_gives_stiffness_and_damping_of_peek():
    """The paper's claim: what elongation and free decay give is what the runs on the table give."""
    findings = chain.evaluate(load(FOLDER / "peek-table" / "campaign.yaml"))
    near(findings, planted_of_line("peek"))
    assert all(one.agrees for one in findings.comparisons)
    assert len(findings.comparisons) == 2
