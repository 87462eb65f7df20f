"""What became of each campaign of a batch."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from metrology.errors import Fault

State = Literal["made", "up to date", "not made"]
REPORT = "report.html"


@dataclass(frozen=True)
class Outcome:
    """One campaign of a batch.

    Parameters
    ----------
    path : Path
        The campaign file.
    state : str
        Whether its report was made, was up to date, or was not made.
    identity, title : str
        Of the campaign; empty where they are not known.
    verdicts : mapping
        How many requirements got which verdict.
    reasons : tuple of str
        Why there is no report, or what could not be evaluated.
    report : bool
        Whether a report lies in the folder of this id, be it an older one.
    """

    path: Path
    state: State
    identity: str = ""
    title: str = ""
    verdicts: Mapping[str, int] = field(default_factory=dict)
    reasons: tuple[str, ...] = ()
    report: bool = True

    @property
    def failed(self) -> bool:
        """Whether there is no report, or something in it failed."""
        return self.state == "not made" or bool(self.reasons) or self.verdicts.get("fail", 0) > 0

    @property
    def judged(self) -> str:
        """The verdicts in words: ``2 pass, 1 fail``."""
        return ", ".join(f"{count} {verdict}" for verdict, count in self.verdicts.items())


def done(path: Path, state: State, results: bytes) -> Outcome:
    """Return the outcome of a campaign with these `results.json`."""
    stated = json.loads(results)
    campaign = stated["campaign"]
    verdicts = Counter(entry["verdict"] for entry in stated["conformity"])
    return Outcome(path, state, campaign["id"], campaign["title"], dict(verdicts), tuple(stated["failures"]))


def refused(path: Path, identity: str, reasons: Sequence[Fault | str], output: Path) -> Outcome:
    """Return the outcome of a campaign without a report, or with an older one only."""
    older = bool(identity) and (output / identity / REPORT).is_file()
    return Outcome(path, "not made", identity, reasons=tuple(str(reason) for reason in reasons), report=older)
