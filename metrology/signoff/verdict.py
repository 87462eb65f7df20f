"""What was checked in a report, and how it came out, in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

State = Literal["good", "failed", "not checked", "note"]
Outcome = Literal["good", "failed", "incomplete"]


@dataclass(frozen=True)
class Check:
    """One thing that was checked: a role, ``file``, ``inputs``, ``results``, ``pages``; a ``note`` decides nothing."""

    subject: str
    state: State
    sentence: str


@dataclass(frozen=True)
class Verdict:
    """All checks of one report, in reading order."""

    report: str
    number: str
    title: str
    checks: tuple[Check, ...]

    @property
    def outcome(self) -> Outcome:
        """``failed`` where anything failed, else ``incomplete`` where anything could not be checked, else ``good``."""
        states = {check.state for check in self.checks}
        return "failed" if "failed" in states else "incomplete" if "not checked" in states else "good"

    @property
    def good(self) -> bool:
        """Whether everything was checked and nothing failed."""
        return self.outcome == "good"


def good(subject: str, sentence: str) -> Check:
    """A check that came out well."""
    return Check(subject, "good", sentence)


def failed(subject: str, sentence: str) -> Check:
    """A check that did not."""
    return Check(subject, "failed", sentence)


def unchecked(subject: str, sentence: str) -> Check:
    """A check that could not be made, and why."""
    return Check(subject, "not checked", sentence)
