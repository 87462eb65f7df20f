"""A campaign file to its report, warm: ours (`tapes`, PDF and HTML) and suncal (YAML to HTML).

Ours reads 2 samples, 4 tests with 10 decay records, evaluates 12 results and lays out the PDF beside the HTML. The
reader of YAML that suncal brings needs a later Python than this project; its model is built here from YAML text. It is
given k, ζ and the sections as inputs with their uncertainties, since it evaluates no readings, and derives E and c of
both tapes by law and 10⁶ trials.

python benchmarks/report.py --peer-python PATH
"""

from __future__ import annotations

import os
import time
from pathlib import Path
from tempfile import mkdtemp

from side_by_side import ROOT, Case, main

TRIALS = 1_000_000
SUNCAL = """
functions:
  - E_a = k_a*L_a/(w*t)
  - c_a = 2*z_a*sqrt(k_a*m)
  - E_p = k_p*L_p/(w*t)
  - c_p = 2*z_p*sqrt(k_p*m)
inputs:
  k_a: {mean: 24734.25, std: 335.52}
  k_p: {mean: 1810.91, std: 7.53}
  z_a: {mean: 0.14, std: 0.0007}
  z_p: {mean: 0.00398, std: 0.000023}
  L_a: {mean: 2.990, std: 0.00058}
  L_p: {mean: 3.000, std: 0.00058}
  w: {mean: 0.025, std: 0.0000058}
  t: {mean: 0.00005, std: 0.0000027}
  m: {mean: 1.196, std: 0.0003}
"""


def ours() -> Case:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from metrology import chain, report
    from metrology.campaign.load import load

    folder = Path(mkdtemp()) / "tapes"

    def work(_: int) -> str:
        start = time.perf_counter()
        findings = chain.evaluate(load(ROOT / "campaigns" / "tapes" / "campaign.yaml"))
        computed = time.perf_counter()
        report.write(findings, folder)
        end = time.perf_counter()
        share = (computed - start) / (end - start)
        size = sum(path.stat().st_size for path in folder.iterdir()) / 1e6
        return f"{len(findings.results)} results, computing {share:.0%} of the time, {size:.1f} MB"

    return work


def suncal() -> Case:
    import suncal as peer
    import yaml

    def work(_: int) -> str:
        stated = yaml.safe_load(SUNCAL)
        model = peer.Model(*stated["functions"])
        for name, known in stated["inputs"].items():
            model.var(name).measure(known["mean"]).typeb(std=known["std"])
        text = model.calculate(samples=TRIALS).report.all().get_html()
        return f"{len(stated['functions'])} results, {len(text) / 1e6:.1f} MB"

    return work


if __name__ == "__main__":
    main(
        __file__,
        "Campaign to report, warm: ours from readings to PDF and HTML, suncal from stated inputs to HTML",
        {"metrology": ours, "suncal": suncal},
        1,
        3,
    )
