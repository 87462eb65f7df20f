"""What a method answers to a case, as it stands in its JSON."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from typing import Any

from .names import NAMES, STEPS


@dataclass(frozen=True)
class Answer:
    """An answer. `named`: causes that are given, the most probable first; `groups`: of which one each is given.

    `probabilities` by name, 0 where a name is absent. `k`, `c`: value, low and high end of the 95 % interval, SI.
    `held_out`: residuals over noise in runs or records left out, of the model as stated and with the causes that are
    given. `failure`: why there is no answer.
    """

    verdict: str
    named: tuple[str, ...] = ()
    groups: tuple[tuple[str, ...], ...] = ()
    probabilities: dict[str, float] = field(default_factory=dict)
    k: tuple[float, float, float] | None = None
    c: tuple[float, float, float] | None = None
    held_out: tuple[float, float] | None = None
    failure: str = ""

    def text(self) -> str:
        """As JSON."""
        return json.dumps(asdict(self))

    @property
    def possible(self) -> set[str]:
        """Every name that is given, alone or in a group."""
        return set(self.named) | {name for group in self.groups for name in group}

    @property
    def top(self) -> str | None:
        """The most probable of the names that are given."""
        order = [*self.named, *(name for group in self.groups for name in group)]
        return max(order, key=lambda name: self.probabilities.get(name, 0.0), default=None)


def read(text: str, method: str) -> Answer:
    """Answer of a program, checked.

    Raises
    ------
    ValueError
        Where it is not one, with the reason.
    """
    found: dict[str, Any] = json.loads(text)
    if found.get("verdict") not in STEPS:
        raise ValueError(f"verdict: got {found.get('verdict')!r}; expected one of {', '.join(STEPS)}")
    answer = Answer(
        found["verdict"],
        tuple(found.get("named", ())),
        tuple(tuple(group) for group in found.get("groups", ())),
        {name: float(p) for name, p in found.get("probabilities", {}).items()},
        _interval(found.get("k")),
        _interval(found.get("c")),
        _pair(found.get("held_out")),
        str(found.get("failure", "")),
    )
    unknown = (answer.possible | set(answer.probabilities)) - set(NAMES[method])
    if unknown:
        raise ValueError(f"names that {method} has not: {', '.join(sorted(unknown))}")
    if any(not 0 <= p <= 1 for p in answer.probabilities.values()):
        raise ValueError("a probability outside of 0 to 1")
    return answer


def _interval(found: Any) -> tuple[float, float, float] | None:
    return None if found is None else (float(found[0]), float(found[1]), float(found[2]))


def _pair(found: Any) -> tuple[float, float] | None:
    return None if found is None else (float(found[0]), float(found[1]))
