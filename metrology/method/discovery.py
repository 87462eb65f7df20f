"""Every method that there is, each checked for all that belongs to one: a half-added method is an error at import."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

from metrology.declaration.conduct import Test
from metrology.errors import Fault, MetrologyError
from metrology.method.record import Method
from metrology.references import REFERENCES

PACKAGE = Path(__file__).parents[1]
OPTIONAL = (
    "remark",
    "references",
    "entries",
    "takes",
    "whole",
    "diagnose",
    "corrected",
    "explain",
    "loading",
    "carried",
)
"""Fields that may be empty; they have to be stated all the same."""
_SHOWN = "docs/extend.md shows a whole method"


def templates() -> Path:
    """Folder of our own templates: in the package where it is installed, beside it in a checkout.

    Returns
    -------
    Path
        The folder.
    """
    inside = PACKAGE / "templates"
    return inside if inside.is_dir() else PACKAGE.parent / "templates"


def discover(path: Sequence[str], package: str) -> dict[str, Method[Any, Any]]:
    """Return the method of every module of a package by its name, each after those whose results it takes.

    Parameters
    ----------
    path : sequence of str
        Folders of the package, its ``__path__``.
    package : str
        Its name.

    Returns
    -------
    dict of str to Method
        By name of the module, each after those whose results it takes.

    Raises
    ------
    MetrologyError
        For a half-added method: everything that is missing, and where it goes.
    """
    faults: list[Fault] = []
    found: dict[str, Method[Any, Any]] = {}
    for info in sorted(pkgutil.iter_modules(path), key=lambda info: info.name):
        where = f"{package}.{info.name}"
        try:
            method = getattr(import_module(where), "METHOD", None)
        except TypeError as error:
            if not str(error).startswith("Method.__init__()"):
                raise
            faults.append(_incomplete(where, str(error)))
            continue
        if isinstance(method, Method):
            found[info.name] = method
            faults += _lacking(info.name, where, method)
        else:
            faults.append(Fault(where, "no METHOD", "METHOD = Method(…), the record of the method", _SHOWN))
    for name, method in found.items():
        faults += [_unknown(f"{package}.{name}", other, found) for other in method.takes if other not in found]
    if faults:
        raise MetrologyError(*faults)
    return _ordered(package, found)


def _incomplete(where: str, error: str) -> Fault:
    """The fields that a record lacks, each with what it holds."""
    texts = {name: text for name, text in _texts().items() if f"'{name}'" in error}
    return Fault(where, f"a METHOD without {', '.join(texts)}" if texts else error, _wanted(texts), _SHOWN)


def _texts() -> dict[str, str]:
    """What each field of a record holds."""
    return {one.name: one.metadata["doc"] for one in fields(Method)}


def _wanted(texts: Mapping[str, str]) -> str:
    return "; ".join(f"{name}: {text[0].lower()}{text[1:].rstrip('.')}" for name, text in texts.items())


def _lacking(name: str, where: str, method: Method[Any, Any]) -> Iterator[Fault]:
    """What belongs to a method and is not there."""
    empty = {key: text for key, text in _texts().items() if key not in OPTIONAL and not getattr(method, key)}
    if empty:
        yield Fault(where, f"a METHOD with an empty {', '.join(empty)}", _wanted(empty), _SHOWN)
    for key in sorted(set(method.references) - REFERENCES.keys()):
        yield Fault(f"{where} references", f"'{key}'", "a key of REFERENCES in metrology/references.py")
    yield from _classes(name, where, method)
    yield from _places(name)


def _classes(name: str, where: str, method: Method[Any, Any]) -> Iterator[Fault]:
    """What the class of the tests and that of the finding must have."""
    if not (isinstance(method.test, type) and issubclass(method.test, Test)):
        yield Fault(f"{where} test", repr(method.test), "a class derived from metrology.declaration.conduct.Test")
        return
    keys = method.test.model_fields
    if "method" not in keys or get_args(keys["method"].annotation) != (name,):
        yield Fault(f"{where} {method.test.__name__}", "no 'method' of its own", f'a field method: Literal["{name}"]')
    if "instruments" not in keys:
        got, expected = "no 'instruments'", "a field 'instruments', the instruments used by what they do"
        yield Fault(f"{where} {method.test.__name__}", got, expected)
    if "equations" not in getattr(method.finding, "__dataclass_fields__", {}):
        yield Fault(f"{where} finding", "no 'equations'", "equations: tuple[str, ...], as the report prints them")


def _places(name: str) -> Iterator[Fault]:
    """Files of the one-word name that are not there; documentation is looked for in a checkout only."""
    docs = PACKAGE.parent / "docs" / "methods"
    wanted = [
        (PACKAGE / "report" / "figures" / f"{name}.py", "how its plots are drawn: a function 'jobs'"),
        (templates() / f"{name}.html", "its part of the report"),
    ]
    wanted += [(docs / f"{name}.md", "its description")] if docs.is_dir() else []
    for path, what in wanted:
        if not path.is_file():
            yield Fault(str(path), "no such file", f"of method '{name}', {what}", _SHOWN)


def _unknown(where: str, other: str, found: Mapping[str, Method[Any, Any]]) -> Fault:
    return Fault(f"{where} takes", f"'{other}'", f"a method, one of {', '.join(found)}")


def _ordered(package: str, found: Mapping[str, Method[Any, Any]]) -> dict[str, Method[Any, Any]]:
    """The methods, each after those whose results it takes."""
    ordered: dict[str, Method[Any, Any]] = {}
    while len(ordered) < len(found):
        ready = [name for name, one in found.items() if name not in ordered and set(one.takes) <= ordered.keys()]
        if not ready:
            circle = ", ".join(sorted(found.keys() - ordered.keys()))
            raise MetrologyError(Fault(package, f"methods that take results of one another: {circle}", "no circle"))
        ordered |= {name: found[name] for name in ready}
    return ordered
