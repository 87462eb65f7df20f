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

from numpydoc.validate import validate

ROOT = Path(__file__).parents[1]
ENGINE = (
    *("decay", "effect", "elongation", "gum", "estimation", "method"),
    *("noise", "rig", "sample", "timeseries", "units", "verify"),
)

CHECKS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["numpydoc_validation"]["checks"]


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
        for name in {*_imported(tree).values(), *_attributes(tree)}:
            found = inspect.unwrap(one) if callable(one := _object(name)) else None
            if inspect.isfunction(found) and found.__module__.split(".")[1] in {*ENGINE} - {home}:
                yield found


def _imported(tree: ast.Module) -> dict[str, str]:
    """What a module imports from the package, by the name that it has there."""
    return {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("metrology")
        for alias in node.names
        if not alias.name.startswith("_")
    }


def _attributes(tree: ast.Module) -> Iterator[str]:
    """What is taken from an imported module: `regression.line` after `from metrology.gum import regression`."""
    homes = _imported(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in homes:
            yield f"{homes[node.value.id]}.{node.attr}"


def _object(name: str) -> object:
    """What a full name stands for; None for what is no name of a module, such as a method of a value."""
    module, _, last = name.rpartition(".")
    try:
        return getattr(import_module(module), last, None)
    except ImportError:
        return None


def lacking(name: str) -> Iterator[str]:
    """What is missing or wrong in the docstring of one name, and of the public methods of a class."""
    found = _object(name)
    methods = [key for key, one in vars(found).items() if inspect.isfunction(one)] if inspect.isclass(found) else []
    for full in (name, *(f"{name}.{key}" for key in methods if not key.startswith("_"))):
        said = [text for code, text in validate(full)["errors"] if code in CHECKS and "{'_" not in text]
        yield from (f"{full}: {text}" for text in said)
        if not inspect.isclass(found) and _raises(found) and "Raises\n" not in (inspect.getdoc(found) or ""):
            yield f"{full}: it raises, and has no Raises section"


def _raises(function: object) -> bool:
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))  # type: ignore[arg-type]
    return any(isinstance(node, ast.Raise) and node.exc is not None for node in ast.walk(tree))


def main() -> int:
    """Print what is missing; status 1 where anything is."""
    names = public()
    faults = [fault for name in names for fault in lacking(name)]
    print("\n".join(faults) or f"docstrings: {len(names)} public names, each with its sections")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
