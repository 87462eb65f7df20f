"""What was checked in a report, and how it came out, in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

State = Literal["good", "failed", "not checked"]


@dataclass(frozen=True)
class Check:
    """One thing that was looked at: a role, or ``file``, ``inputs``, ``results``, ``pages``."""

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
    def good(self) -> bool:
        """Whether nothing failed."""
        return all(check.state != "failed" for check in self.checks)


def good(subject: str, sentence: str) -> Check:
    """A check that came out well."""
    return Check(subject, "good", sentence)


def failed(subject: str, sentence: str) -> Check:
    """A check that did not."""
    return Check(subject, "failed", sentence)
