"""Who may import whom: arrows between the rooms only go down."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "metrology"

LAYERS = (
    {"__main__"},
    {"cli"},
    {"api", "watch"},
    {"batch"},
    {"draft", "export", "lsp", "signoff"},
    {"summary", "chain", "report"},
    {"language"},
    {"checklist", "published"},
    {"findings"},
    {"identification", "judged", "tested"},
    {"campaign"},
    {"methods"},
    {"method", "readings"},
    {"declaration"},
    {"diagnostics"},
    {"response"},
    {"verify"},
    {"estimation"},
    {"decay", "elongation", "relaxation", "rig", "tension"},
    {"effects"},
    {"effect", "raw", "specimens"},
    {"audit_trail", "check", "noise", "sample", "slip", "timeseries"},
    {"gum"},
    {"expression"},
    {"units"},
    {"consensus", "diagnosis", "errors", "jsontext", "message", "references"},
    {"coordinate", "doc", "ties"},
    {"__init__"},
)
"""Rooms from top to bottom; a room imports from rooms below its own layer only."""

FORBIDDEN = {("rig", "gum"), ("estimation", "verify")}
"""Down, and yet not to be drawn: the rig knows no uncertainty, and the judge does not sit in the fit."""


def room(path: Path) -> str:
    """First folder or file name below the package."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(path: Path) -> set[str]:
    """Full names of what a module imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


def arrows() -> set[tuple[str, str]]:
    """Pairs of rooms, the first of which imports from the second."""
    found = {
        (room(path), name.split(".")[1])
        for path in PACKAGE.rglob("*.py")
        for name in imported(path)
        if name.startswith("metrology.")
    }
    return {(source, target) for source, target in found if source != target and target != "__version__"}


def height(name: str) -> int:
    return next(level for level, rooms in enumerate(reversed(LAYERS)) if name in rooms)


def test_every_room_has_a_place():
    rooms = {room(path) for path in PACKAGE.rglob("*.py")}
    assert rooms - set().union(*LAYERS) == set()


@pytest.mark.long
def test_arrows_go_down():
    every = arrows()
    assert len(every) > 100
    assert not every & FORBIDDEN
    assert not [(source, target) for source, target in every if height(source) <= height(target)]


LONGEST = 300
"""Lines of a file above which it has more than one job; none of the package needs more."""


def test_limit_no_file_is_long():
    long = {str(path.relative_to(PACKAGE)): text.count("\n") for path in PACKAGE.rglob("*.py")
            if (text := path.read_text(encoding="utf-8")).count("\n") > LONGEST}  # fmt: skip
    assert long == {}
