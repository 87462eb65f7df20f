"""A report of four samples: laid out as PDF and HTML, signed by three, verified; warm, with the sizes of the files.

The findings are made up (`tests/report/findings_sample.py`): every section that a report can have, over a dozen plots.

python benchmarks/pdf.py
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

from side_by_side import ROOT, Case, main

ROLES = ("author", "reviewer", "approver")


@cache
def made() -> dict[str, bytes]:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.path.insert(0, str(ROOT / "tests" / "report"))
    import findings_sample

    from metrology import report
    from metrology.findings import Signatory

    findings = findings_sample.build(4, records=1)
    people = tuple(Signatory(role, f"The {role}", "staff") for role in ROLES)
    campaign = replace(findings.campaign, signatures=people, checklists=())
    return report.make(replace(findings, campaign=campaign))


def size(content: bytes) -> str:
    return f"{len(content) / 1e6:.2f} MB"


def lay_out() -> Case:
    def work(_: int) -> str:
        made.cache_clear()
        files = made()
        pictures = files["report.pdf"].count(b"/Figure")
        return f"PDF {size(files['report.pdf'])}, HTML {size(files['report.html'])}, {pictures} pictures"

    return work


def signed(home: Path) -> Path:
    """Sign the report by three."""
    from metrology import signoff

    path = home / "report.pdf"
    path.write_bytes(made()["report.pdf"])
    for role in ROLES:
        signoff.sign(path, role, signoff.from_file(home / "keys" / f"{role}.p12", None, lambda: b"test"))
    return path


def sign() -> Case:
    from metrology import signoff

    home = Path(mkdtemp())
    signoff.create_authority(home / "keys")
    made()
    return lambda _: f"three signatures, {size(signed(home).read_bytes())}"


def verify() -> Case:
    from metrology import signoff
    from metrology.signoff.keys import read_certificates

    home = Path(mkdtemp())
    trusted = read_certificates(signoff.create_authority(home / "keys")[0])
    path = signed(home)

    def work(_: int) -> str:
        verdict = signoff.verify(path, trusted, rebuild=False)
        return f"{sum(check.state == 'good' for check in verdict.checks)} checks good of {len(verdict.checks)}"

    return work


if __name__ == "__main__":
    main(
        __file__,
        "A report of four samples, warm: layout, three signatures, verification without evaluating again",
        {"metrology layout": lay_out, "metrology sign": sign, "metrology verify": verify},
        1,
        3,
    )
