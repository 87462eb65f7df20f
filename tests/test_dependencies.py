"""What pyproject.toml declares is what the package imports, and the other way round; the version stands once."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import metrology

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
ASIDE = ("dev", "docs", "bench", "fuzz")
"""Extras for work on the package itself."""
BROUGHT = {
    "asn1crypto": "pyhanko",
    "cryptography": "pyhanko",
    "fonttools": "weasyprint",
    "lsprotocol": "pygls",
    "markupsafe": "jinja2",
    "pydantic-core": "pydantic",
    "pydyf": "weasyprint",
    "pyhanko-certvalidator": "pyhanko",
    "python-pkcs11": "pyhanko",
}
"""Imported, and part of the interface of a package that is declared, which brings it."""


def canonical(requirement: str) -> str:
    return re.sub(r"[-_.]+", "-", re.split(r"[\[><=;! ]", requirement)[0]).lower()


def imported() -> set[str]:
    """Packages that the modules of `metrology` import, anywhere in them."""
    homes = packages_distributions()
    return {canonical(home) for name in names() if name in homes for home in homes[name]}


def names() -> set[str]:
    found = {name.split(".")[0] for path in (ROOT / "metrology").rglob("*.py") for name in of(path)}
    return found - {*sys.stdlib_module_names, "metrology"}


def of(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module


def declared() -> set[str]:
    extras = PROJECT["optional-dependencies"]
    groups = [PROJECT["dependencies"], *(extras[name] for name in extras if name not in ASIDE)]
    return {canonical(one) for group in groups for one in group}


@pytest.mark.long
def test_twice_what_is_declared_is_imported_and_what_is_imported_is_declared() -> None:
    assert not names() - packages_distributions().keys(), "imported, and not installed"
    needed = {BROUGHT.get(name, name) for name in imported()}
    assert declared() - needed == set(), "declared, and imported nowhere: move it to the extra dev, or drop it"
    assert needed - declared() == set(), "imported, and declared nowhere"


@pytest.mark.long
def test_law_every_package_that_is_brought_is_imported() -> None:
    assert BROUGHT.keys() <= imported()


def test_law_the_version_of_the_citation_is_that_of_the_package() -> None:
    assert PROJECT["dynamic"] == ["version"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (.*)$", citation, re.MULTILINE) == [metrology.__version__]
    released = re.findall(r"^## \[(\d.*?)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert released[0] == metrology.__version__
