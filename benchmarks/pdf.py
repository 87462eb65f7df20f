"""A report of four samples with twelve plots: laid out as PDF and HTML, signed by three, verified; warm, with sizes.

The campaign is written here: each of four lines is pulled by dead loads and held to a requirement, so that the report
has its line, the density of its k and its verdict, twelve plots in all. Verified twice: the signatures and what is
attached, and then all, its inputs evaluated and the report laid out again. Beside it the fullest report there is: four
samples of made-up findings (`tests/report/findings_sample.py`), every section and over forty plots.

Each line ends with the processor's time of one turn, which other work on the machine disturbs less. Some 80 s in all.

python benchmarks/pdf.py
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from time import process_time
from typing import TYPE_CHECKING

from side_by_side import ROOT, Case, main

if TYPE_CHECKING:
    from metrology.findings import Findings

ROLES = ("author", "reviewer", "approver")
STIFFNESS = {"steel": 21.4, "nylon": 1.29, "aramid": 8.75, "glass": 11.2}
"""Sample → k in N/mm."""
HEAD = """\
format: metrology-campaign/1
id: four
title: Stiffness of four lines
report:
  number: TR-1
  issued: 2026-11-20
  authorised_by: The approver
  signatures:
    author: {name: The author, function: staff}
    reviewer: {name: The reviewer, function: staff}
    approver: {name: The approver, function: staff}
laboratory: {name: Laboratory, address: "1 Station Road, Exampletown", contact: The approver}
customer: {name: Customer, address: "2 Station Road, Exampletown", contact: A. Customer}
purpose: to measure how long a report takes
place: laboratory
sampling: none
provided: none
deviations: none
opinions: none
diagnosis: {off: true}
instruments:
  indicator: {kind: dial indicator, resolution: 0.01 mm}
"""
SAMPLE = """\
  {name}:
    material: {name}
    condition: as received
    received: 2026-10-01
    length: 2.000(1) m
"""
TEST = """\
  {name}-pull:
    method: elongation
    sample: {name}
    date: 2026-10-12
    procedure: P-1, edition 1
    environment: {{temperature: 21.5(5) degC}}
    instruments: {{extension: indicator}}
    gravity: 9.8065(3) m/s^2
    loads:
      A: {{mass: 1.0000(1) kg}}
      B: {{mass: 2.0000(1) kg}}
      C: {{mass: 3.0000(2) kg}}
      D: {{mass: 4.0000(2) kg}}
    readings: {name}.csv
"""
RULE = """\
  - id: {name}
    quantity: {name}-pull.k
    limits: {{lower: 1 kN/m}}
    source: specification 1
    decision: {{rule: guard band, agreed: 2026-10-01}}
"""


def campaign(home: Path) -> Path:
    """Write the campaign file and its readings."""
    parts = {"samples": SAMPLE, "tests": TEST, "requirements": RULE}
    text = HEAD + "".join(f"{key}:\n" + "".join(part.format(name=n) for n in STIFFNESS) for key, part in parts.items())
    (home / "campaign.yaml").write_text(text)
    for name, k in STIFFNESS.items():
        rows = [
            f"{load},{repeat},{way},{mass * 9.8065 / k + 0.01 * ((7 * mass + 5 * repeat + len(way)) % 3 - 1):.2f}"
            for repeat in (1, 2, 3)
            for way, loads in (("loading", "ABCD"), ("unloading", "CBA"))
            for load in loads
            for mass in ("ABCD".index(load) + 1,)
        ]
        (home / f"{name}.csv").write_text("load,repeat,direction,reading / mm\n" + "\n".join(rows) + "\n")
    return home / "campaign.yaml"


@cache
def evaluated() -> tuple[Findings, dict[str, bytes]]:
    """Findings of the campaign, and the files that went in."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from metrology import chain
    from metrology.campaign.load import load

    home = Path(mkdtemp())
    findings = chain.evaluate(load(campaign(home)))
    return findings, {file.path: (home / file.path).read_bytes() for file in findings.inputs}


def full() -> Findings:
    sys.path.insert(0, str(ROOT / "tests" / "report"))
    import findings_sample

    findings = findings_sample.build(4, records=1)
    return replace(findings, campaign=replace(findings.campaign, checklists=()))


@cache
def report() -> bytes:
    """The PDF of the campaign."""
    from metrology import report

    findings, sources = evaluated()
    return report.make(findings, sources=sources)["report.pdf"]


def size(content: bytes) -> str:
    return f"{len(content) / 1e6:.2f} MB"


def timed(work: Callable[[], str]) -> Case:
    """Tell the processor's time of the work beside what it tells."""

    def told(_: int) -> str:
        start = process_time()
        words = work()
        return f"{words}; {process_time() - start:.2f} s of processor"

    return told


def lay_out(given: Callable[[], tuple[Findings, dict[str, bytes] | None]]) -> Case:
    from metrology.report import figures, make

    findings, sources = given()
    plots = len(figures.draw(findings))

    def work() -> str:
        files = make(findings, sources=sources)
        return f"{plots} plots, PDF {size(files['report.pdf'])}, HTML {size(files['report.html'])}"

    return timed(work)


def signed(home: Path) -> Path:
    """Sign the report by three."""
    from metrology import signoff

    path = home / "report.pdf"
    path.write_bytes(report())
    for role in ROLES:
        signoff.sign(path, role, signoff.from_file(home / "keys" / f"{role}.p12", None, lambda: b"test"))
    return path


def sign() -> Case:
    from metrology import signoff

    home = Path(mkdtemp())
    signoff.create_authority(home / "keys")
    report()
    return timed(lambda: f"three signatures, {size(signed(home).read_bytes())}")


def verify(*, rebuild: bool) -> Case:
    from metrology import signoff
    from metrology.signoff.keys import read_certificates

    home = Path(mkdtemp())
    trusted = read_certificates(signoff.create_authority(home / "keys")[0])
    path = signed(home)

    def work() -> str:
        verdict = signoff.verify(path, trusted, rebuild=rebuild)
        return f"{sum(check.state == 'good' for check in verdict.checks)} checks good of {len(verdict.checks)}"

    return timed(work)


if __name__ == "__main__":
    main(
        __file__,
        "A report of four samples, warm: layout, three signatures, verification; and the layout of the fullest report",
        {
            "metrology layout": lambda: lay_out(evaluated),
            "metrology sign": sign,
            "metrology verify": lambda: verify(rebuild=False),
            "metrology verify, rebuilt": lambda: verify(rebuild=True),
            "metrology fullest layout": lambda: lay_out(lambda: (full(), None)),
        },
        1,
        2,
        1,
    )
