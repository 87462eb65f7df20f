"""`metrology new NAME`: a commented campaign with its readings that runs at once."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from metrology.campaign import starter_relaxation
from metrology.errors import Fault, MetrologyError, printable

CAMPAIGN = """\
# A campaign: what was measured, with what, and what is to be made of it. Every key is explained in docs/campaign.md.
# Check it with:   metrology check {path}
# Its report:      metrology report {path}
format: metrology-campaign/1
id: {name}
title: Stiffness and modulus of a tape
reconstructed: Example readings, not measured.   # remove this line when the readings are yours
seed: 1                                          # the same seed gives the same report, to the byte

report: {{number: EX-1, issued: 2026-11-20, authorised_by: "J. Doe, head of laboratory"}}
laboratory: {{name: Example Laboratory, address: "1 Station Road, Exampletown"}}
customer: {{name: Example Customer, contact: A. Customer}}
# What a report by ISO/IEC 17025 says; "none" is a statement, an absent key leaves the report a draft.
# metrology check --for 17025 {path}
purpose: Acceptance of the tape before it is used
place: laboratory
sampling: none
provided: none
deviations: none
opinions: none

instruments:
  indicator:
    kind: dial indicator
    serial: 0123
    range: [0 mm, 25 mm]
    resolution: 0.01 mm
    certificate: {{number: C-123, date: 2026-03-01, due: 2027-03-01, expanded_uncertainty: 4 um, k: 2}}
  weights:
    kind: set of weights
    class: M1

samples:
  tape:
    material: aluminium
    condition: as received
    received: 2026-10-01
    # 0.0500(27) mm: value 0.0500 mm, standard uncertainty 0.0027 mm.
    section: {{shape: tape, width: 25.00(5) mm, thickness: 0.0500(27) mm}}
    # In pieces: a steel tape that is right within 2 mm, and nothing favours the middle.
    length:
      value: 2.990 m
      uncertainty:
        - {{half_width: 2 mm, distribution: rectangular, source: steel tape}}

tests:
  elongation:
    method: elongation
    sample: tape
    date: 2026-10-05
    operator: A. Smith
    procedure: SP-11, edition 2
    environment: {{temperature: 21.3(5) degC, humidity: 45(5) %}}
    instruments: {{extension: indicator, load: weights}}
    gravity: 9.8060(5) m/s^2
    loads:                       # at least three, each with three repeats in the file
      A: {{mass: 1.0000(2) kg}}
      B: {{mass: 2.0000(3) kg}}
      C: {{mass: 3.0000(5) kg}}
    readings: elongation.csv     # columns: load, repeat, direction, reading / mm
    # exclusions:
    #   - {{line: 14, reason: indicator knocked}}

# A measurement model of your own, over properties of samples, results of tests and free quantities.
quantities:
  F_max: {{value: 150 N, uncertainty: [{{expanded: 2 N, k: 2, source: specification}}], description: largest force}}

derived:
  - quantity: x_max
    description: elongation at the largest force
    expression: F_max / k
    where: {{k: elongation.k}}
    unit: mm

requirements:
  - id: R1
    text: The stiffness shall be at least 20 kN/m.
    source: specification TS-01, 3.1
    quantity: elongation.k
    limits: {{lower: 20 kN/m}}
    decision: {{rule: guard band, agreed: 2026-09-15}}     # w = U: a pass is wrong with at most 2.5 %
"""
#: Extensions in units of 0.01 mm by load, for each repeat, loading then unloading.
_READINGS = {
    "A": ((40, 40), (40, 41), (39, 40)),
    "B": ((79, 80), (79, 79), (80, 79)),
    "C": ((119, 119), (118, 119), (119, 120)),
}


def create(name: str, folder: Path, method: str = "elongation") -> Path:
    """Write a starter campaign and its readings to ``folder/name`` and return the path of its campaign file.

    Parameters
    ----------
    name : str
        Letters, digits and dashes, 64 at most; it begins with a letter.
    folder : Path
        Where the campaign's folder goes; made where it does not exist.
    method : {"elongation", "relaxation"}
        Method of its test.

    Raises
    ------
    MetrologyError
        For a name that is none, a folder that exists, and where it cannot be written.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9-]{0,63}", name):
        raise MetrologyError(
            Fault("NAME", repr(name), "letters, digits and dashes, at most 64, beginning with a letter")
        )
    home, (campaign, file, readings) = folder / name, STARTERS[method]
    try:
        home.mkdir(parents=True)
        (home / file).write_text(readings(), encoding="utf-8", newline="\n")
        path = home / "campaign.yaml"
        path.write_text(campaign.format(name=name, path=printable(path.as_posix())), encoding="utf-8", newline="\n")
    except FileExistsError:
        fix = "choose another name, or remove it"
        raise MetrologyError(
            Fault(str(home), "a folder that exists", "a new one: nothing is overwritten", fix)
        ) from None
    except OSError as error:
        raise MetrologyError(
            Fault(str(home), f"no place to write ({error.strerror})", "a folder that can be made")
        ) from None
    return path


def _readings() -> str:
    """Loading upwards, unloading downwards, three times."""
    lines = ["load,repeat,direction,reading / mm"]
    for repeat in range(3):
        for column, direction in enumerate(("loading", "unloading")):
            loads = list(_READINGS) if direction == "loading" else list(reversed(_READINGS))
            lines += [f"{load},{repeat + 1},{direction},{_READINGS[load][repeat][column] / 100:.2f}" for load in loads]
    return "\n".join(lines) + "\n"


STARTERS: dict[str, tuple[str, str, Callable[[], str]]] = {
    "elongation": (CAMPAIGN, "elongation.csv", _readings),
    "relaxation": (starter_relaxation.CAMPAIGN, starter_relaxation.READINGS, starter_relaxation.readings),
}
"""Campaign file, name of the file of readings, and what makes it, by method."""
