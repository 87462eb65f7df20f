"""Who may import whom: arrows between the rooms only go down."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "metrology"

LAYERS = (
    {"__main__"},
    {"cli"},
    {"api"},
    {"batch", "draft", "export", "signoff"},
    {"summary", "chain", "report"},
    {"language"},
    {"checklist", "published"},
    {"findings"},
    {"identification", "tested"},
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
    {"effect", "raw"},
    {"audit_trail", "check", "noise", "sample", "slip", "timeseries"},
    {"gum"},
    {"expression"},
    {"units"},
    {"consensus", "diagnosis", "errors", "jsontext", "references"},
    {"coordinate", "doc"},
    {"__init__"},
)
"""Rooms from top to bottom; a room imports from rooms below its own layer only."""

FORBIDDEN = {("rig", "gum"), ("estimation", "verify")}
"""Down, and yet not to be drawn: the rig knows no uncertainty, and the judge does not sit in the fit."""


def room(path: Path) -> str:
    """First folder or file name below the package."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def arrows() -> set[tuple[str, str]]:
    found = set()
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            found |= {(room(path), name.split(".")[1]) for name in names if name.startswith("metrology.")}
    return {(source, target) for source, target in found if source != target and target != "__version__"}


def height(name: str) -> int:
    return next(level for level, rooms in enumerate(reversed(LAYERS)) if name in rooms)


def test_every_room_has_a_place():
    rooms = {room(path) for path in PACKAGE.rglob("*.py")}
    assert rooms - set().union(*LAYERS) == set()


@pytest.mark.parametrize(("source", "target"), sorted(arrows()))
def test_arrows_go_down(source, target):
    assert (source, target) not in FORBIDDEN
    assert height(source) > height(target)
