"""The public functions, and what is missing in their docstrings; `make lint` runs this, and nothing may be missing.

Public are the names of `metrology.__all__` with their public methods, and the functions without a leading underscore of
the engine's packages that another package of `metrology` imports.
"""

from __future__ import annotations

import ast
import inspect
import sys
import textwrap
import tomllib
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[1]
ENGINE = (
    *("decay", "effect", "elongation", "gum", "identify", "method"),
    *("noise", "rig", "sample", "timeseries", "units", "verify"),
)


def public() -> list[str]:
    """Full names of the public functions, classes and methods, in the order of their modules."""
    import metrology

    names = [f"metrology.{name}" for name in metrology.__all__ if not name.startswith("__")]
    return names + sorted({f"{one.__module__}.{one.__qualname__}" for one in _engine()})


def _engine() -> Iterator[Callable[..., object]]:
    """Functions of the engine that another package imports, by name or through their module."""
    for path in (ROOT / "metrology").rglob("*.py"):
        home = path.relative_to(ROOT / "metrology").with_suffix("").parts[0]
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for name in {*_imported(tree), *_attributes(tree)}:
            package = name.split(".")[1]
            if package in ENGINE and package != home and inspect.isfunction(found := _object(name)):
                yield found


def _imported(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("metrology"):
            yield from (f"{node.module}.{alias.name}" for alias in node.names if not alias.name.startswith("_"))


def _attributes(tree: ast.Module) -> Iterator[str]:
    """What is taken from an imported module: `regression.line` after `from metrology.gum import regression`."""
    homes = {name.rpartition(".")[2]: name for name in _imported(tree)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in homes:
            yield f"{homes[node.value.id]}.{node.attr}"


def _object(name: str) -> object:
    """What a full name stands for; None for what is no name of `metrology`, such as a method of a value."""
    module, _, last = name.rpartition(".")
    try:
        return getattr(_module(module), last, None)
    except ImportError:
        return None


def _module(name: str) -> ModuleType:
    return import_module(name)


if __name__ == "__main__":
    for n in public(): print(n)
