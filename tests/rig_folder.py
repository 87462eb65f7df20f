"""Campaign folders of response tests on other rigs, and what comes out of one."""

from __future__ import annotations

import numpy as np

from metrology.campaign.load import load
from metrology.chain.methods import add_test
from metrology.chain.plan import Plan

PURPOSES = ("identification", "identification", "verification", "verification")
HEAD = """\
format: metrology-campaign/1
id: rig
title: A rig
diagnosis: {off: true}
samples: {line: {}}
instruments: {mocap: {kind: motion capture}}
tests:
  pull:
    method: response
    sample: line
    instruments: {position: mocap}
"""


def written(folder, stated, runs, head=HEAD):
    """Write the campaign: `stated` below the test, and runs as `run` gives them."""
    text = head + stated + "    runs:\n"
    for name, purpose, files, extra in runs:
        listed = []
        for number, (heading, columns) in enumerate(files):
            listed.append(f"{name}-{number}.csv")
            rows = [",".join("" if np.isnan(value) else f"{value:.9g}" for value in row) for row in columns.T]
            (folder / listed[-1]).write_text("\n".join([heading, *rows]) + "\n")
        text += f"      {name}: {{purpose: {purpose}, readings: [{', '.join(listed)}], {extra}}}\n"
    (folder / "campaign.yaml").write_text(text)
    return folder / "campaign.yaml"


def run(number, files, extra):
    """One of four runs, two for each purpose: pairs of heading and columns, a file each; thrust and start."""
    return f"r{number}", PURPOSES[number], [(heading, np.vstack(columns)) for heading, columns in files], extra


def shown(folder, stated, runs):
    """Finding of the test, and the plan that it went into."""
    loaded, plan = load(written(folder, stated, runs)), Plan()
    return add_test(plan, loaded, "pull", lambda _text: None), plan


def sought(finding):
    return {entry.name: entry for entry in finding.sought}


def assert_recovered(finding, plan, **true):
    """What was planted is found within 4 u, and the runs that the fit has not seen validate it."""
    for name, value in true.items():
        found = sought(finding)[name]
        assert abs(found.value - value) < 4 * found.u, f"{name} = {found.value} ± {found.u}, planted {value}"
    (judged,) = plan.verification
    assert judged["verdict"] == "validated within u_val", judged["sentence"]
