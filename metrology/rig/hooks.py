"""What the files of `metrology.effects` add to the motion, composed into one function a place.

The kernel calls one function for each place (a force on the module, a tension of the line …), which is written here, as
source, from all effects that have a term there: a term is called where one of its effect's sizes is off its null, with
what it asks for by the names of its arguments. Where it does not act it costs a comparison, and vanishes exactly.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any

from metrology.effect import Effect, Term
from metrology.rig.parameters import EFFECTS, INDEX, PARAMETERS

Function = Callable[..., Any]
_GIVEN = {
    "force": {
        "t": "y[at[TIME]]", "x": "y[X] + p[TAUT] + p[SLIP] * r[SLIPPED]", "v": "y[V]", "e": "excess(y, at)[0]",
        "T": "T", "way": "r[SLIDE]",
    },
    "tension": {"e": "e"},
    "slope": {"e": "e"},
    "damping": {"e": "e", "rate": "rate", "side": "r[SIDE]", "way": "r[TURN_SIDE]"},
}  # fmt: skip
"""Term → argument → what the kernel gives for it."""
_PLACES = {
    "added_force": ("force", "y, T, r, p, at"),
    "added_tension": ("tension", "e, p"),
    "added_slope": ("slope", "e, p"),
    "added_damping": ("damping", "e, rate, r, p"),
}
"""Function of the kernel → the terms that it adds up, and its arguments."""
READ = frozenset(one.name for effect in EFFECTS if effect.readings for one in effect.parameters)
"""Parameters that change readings alone, by a term that needs no motion."""


@lru_cache(maxsize=1024)
def asked(term: Term) -> tuple[str, ...]:
    """Names of a term's arguments."""
    return tuple(inspect.signature(term).parameters)


def sizes(effect: Effect, *, curved: bool = False) -> list[str]:
    """Names of the sizes of an effect, or of those with which the equation of motion is not linear."""
    return [one.name for one in effect.parameters[: effect.sizes] if not (curved and one.linear)]


def timed() -> list[str]:
    """Sizes of effects whose force asks for the time, which is then a state of the motion."""
    return [name for one in EFFECTS if one.force and "t" in asked(one.force) for name in sizes(one)]


def _acts(names: Iterable[str]) -> str:
    tests = [f"p[{INDEX[name]}] != {PARAMETERS[name].null!r}" for name in names]
    return " or ".join(tests) or "False"


class _Put(ast.NodeTransformer):
    """Puts what is given in the place of a term's arguments."""

    def __init__(self, given: dict[str, str]) -> None:
        self.given = {name: ast.parse(text, mode="eval").body for name, text in given.items()}
        self.unknown = False

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Replace an argument; note a name that the kernel does not have."""
        self.unknown |= node.id not in (*self.given, "np", "math", "abs", "min", "max")
        return self.given.get(node.id, node)


@lru_cache(maxsize=256)
def _body(term: Term) -> str:
    """Expression that a term returns, where it is no more than that: written in place, it costs no call."""
    if term.__name__ == "<lambda>":
        return ""
    (function,) = ast.parse(textwrap.dedent(inspect.getsource(term))).body
    lines = [one for one in getattr(function, "body", []) if not isinstance(one, ast.Expr)]
    return (
        ast.unparse(lines[0].value) if len(lines) == 1 and isinstance(lines[0], ast.Return) and lines[0].value else ""
    )


def _put(term: Term, given: dict[str, str]) -> str:
    """Expression of a term with what is given for its arguments; empty where it has names of its own."""
    put = _Put(given)
    found = put.visit(ast.parse(_body(term) or "None", mode="eval"))
    return "" if put.unknown or not _body(term) else ast.unparse(found)


def _called(effect: Effect, place: str, **instead: str) -> str:
    given = {**_GIVEN[place], **instead}
    values = {one.short: one.name for one in effect.parameters}
    term: Term = getattr(effect, place)
    found = {one: given[one] if one in given else f"p[{INDEX[values.get(one, one)]}]" for one in asked(term)}
    return _put(term, found) or f"term_{effect.name}_{place}({', '.join(found.values())})"


def _composed(name: str) -> str:
    place, arguments = _PLACES[name]
    lines = [f"def {name}({arguments}):", "    total = 0.0"]
    for effect in EFFECTS:
        if getattr(effect, place):
            lines += [f"    if {_acts(sizes(effect))}:", f"        total += {_called(effect, place)}"]
    return "\n".join([*lines, "    return total"])


def _stiffness() -> str:
    """Function of the kernel for the stiffness of what pulls on the module in proportion to its position."""
    lines = ["def added_stiffness(p):", "    total = 0.0"]
    still = {"v": "0.0", "way": "0"}
    for effect in EFFECTS:
        linear = [one.name for one in effect.parameters[: effect.sizes] if one.linear]
        if effect.force and linear and "x" in asked(effect.force):
            here, there = (_called(effect, "force", x=x, **still) for x in ("0.0", "1.0"))
            lines += [f"    if {_acts(linear)}:", f"        total += ({here}) - ({there})"]
    return "\n".join([*lines, "    return total"])


def _whether(name: str, arguments: str, condition: str) -> str:
    return f"def {name}({arguments}):\n    return {condition}"


def _source() -> str:
    by = {place: [one for one in EFFECTS if getattr(one, place)] for place in _GIVEN}
    line = {one.name: one for one in (*by["tension"], *by["damping"])}.values()
    turning = [one for one in by["force"] if "way" in asked(one.force or max)]
    sided, turned = ([one for one in by["damping"] if name in asked(one.damping or max)] for name in ("side", "way"))
    moving: list[str] = []
    always: list[str] = []
    for one in by["force"]:
        # By the time or the line, a force changes while the module sticks, and what is watched there with it.
        inside = {"t", "e", "T"} & set(asked(one.force or max))
        (always if inside else moving).extend(sizes(one, curved=True))
    curved = f"({_acts(always)}) or (r[SLIDE] != 0 and r[HELD] == 0 and ({_acts(moving)}))"
    return "\n\n\n".join(
        [
            *map(_composed, _PLACES),
            _stiffness(),
            _whether("has_tension", "p", _acts(name for one in by["tension"] for name in sizes(one))),
            _whether("is_curved_line", "p", _acts(name for one in line for name in sizes(one, curved=True))),
            _whether("is_curved_force", "r, p", curved),
            _whether("turns", "p", _acts(name for one in turning for name in sizes(one, curved=True))),
            _whether("has_sides", "p", _acts(name for one in sided for name in sizes(one))),
            _whether("has_ways", "p", _acts(name for one in turned for name in sizes(one))),
        ]
    )


SOURCE = _source()
"""Source of the composed functions, for reading and for the key of the compiled copy."""
NAMES = (
    *_PLACES,
    "added_stiffness",
    "has_tension",
    "is_curved_line",
    "is_curved_force",
    "turns",
    "has_sides",
    "has_ways",
)


def is_small(function: Function) -> bool:
    """Whether a function of the kernel is one of these, or a term: to be written into those that call it."""
    return function.__name__ in NAMES or function.__module__.startswith("metrology.effects.")


def terms() -> dict[str, Term]:
    """Terms that the composed functions call, by the names under which they do so."""
    places = {f"term_{effect.name}_{place}": getattr(effect, place) for effect in EFFECTS for place in _GIVEN}
    return {name: term for name, term in places.items() if f"{name}(" in SOURCE}


def key() -> bytes:
    """All of the effects that goes into a compiled motion: places of parameters, what is composed, and the terms."""
    places = {name: at for name, at in INDEX.items() if name not in READ}
    files = sorted({str(inspect.getsourcefile(term)) for term in terms().values()})
    return repr((places, SOURCE)).encode() + b"".join(Path(file).read_bytes() for file in files)


def installed(names: dict[str, Any]) -> tuple[Function, ...]:
    """Put the terms and the composed functions into the kernel's own names, which they use; give the functions."""
    names.update(terms())
    exec(SOURCE, names)  # noqa: S102 - source of our own, written above
    return tuple(names[name] for name in NAMES)
