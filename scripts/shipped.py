"""What comes with the package: docs/licences.md, and for a release the software bill of materials.

python scripts/shipped.py licences
python scripts/shipped.py sbom FILE
python scripts/shipped.py requirements FILE
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from metrology import __version__

ROOT = Path(__file__).parents[1]
VENV = ROOT / ".venv"
"""With the locked versions, as `make setup` installs them."""
PYTHON = str(VENV / "bin" / "python")
ASIDE = ("dev", "docs", "bench", "fuzz")
"""Extras for work on the package itself, which nobody installs with it."""
HEAD = """# Licences

metrology is under the MIT licence. The Python packages that come with it are listed below with the licences that their
own metadata state; `make docs` writes this page from the locked versions on Linux. Those of `always` are installed with
the package, the others with the extras named.

Not from Python: the fonts in the package are DejaVu (Bitstream Vera licence); the plots of `report.html` that can be
zoomed use uPlot 1.6.32 (MIT), unmodified, in `templates/vendor/`. Pango (LGPL) and HarfBuzz (MIT) are libraries of the
system.

| package | licence | comes with |
|---|---|---|
"""


def shipped() -> dict[str, set[str]]:
    """Names of the packages, each with the extras that bring it; `always` without an extra."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = {"always": project["dependencies"], **project["optional-dependencies"]}
    found: dict[str, set[str]] = {}
    for group, requirements in groups.items():
        for name in _closure(requirements) if group not in ASIDE else ():
            found.setdefault(name, set()).add(group)
    return {name: {"always"} if "always" in found[name] else found[name] for name in sorted(found)}


def _closure(requirements: list[str]) -> set[str]:
    """Names of what these requirements bring, directly or not, on this platform."""
    installed = _installed()
    todo = [(Requirement(one), "") for one in requirements]
    seen: set[tuple[str, frozenset[str]]] = set()
    while todo:
        one, extra = todo.pop()
        key = (canonicalize_name(one.name), frozenset(one.extras))
        if key in seen or (one.marker and not one.marker.evaluate({"extra": extra})):
            continue
        seen.add(key)
        for text in installed[canonicalize_name(one.name)]:
            todo += [(Requirement(text), inner) for inner in ("", *one.extras)]
    return {name for name, _ in seen}


def _installed() -> dict[str, list[str]]:
    """What every package that is installed there requires."""
    places = [str(path) for path in VENV.glob("lib/python*/site-packages")]
    return {canonicalize_name(one.name): one.requires or [] for one in distributions(path=places)}


def licences(found: Mapping[str, set[str]]) -> str:
    """The page: a row for each package."""
    listed = json.loads(_output("piplicenses", f"--python={PYTHON}", "--format=json", "--packages", *found))
    said = {canonicalize_name(one["Name"]): (one["Name"], one["License"]) for one in listed}
    rows = [f"| {said[name][0]} | {_short(said[name][1])} | {', '.join(sorted(found[name]))} |" for name in found]
    return HEAD + "\n".join(rows) + "\n"


def _short(licence: str) -> str:
    """A licence in a cell of a table: of a package that states the whole text, its first line."""
    return licence.splitlines()[0].replace("|", "/")


def sbom(found: Mapping[str, set[str]]) -> str:
    """CycloneDX: packages with versions, licences, the hashes of the lock, and who brings whom; without addresses."""
    bill = _without_addresses(
        json.loads(_output("cyclonedx_py", "environment", PYTHON, "--pyproject", "pyproject.toml"))
    )
    bill["metadata"]["component"]["version"] = __version__
    bill["components"] = [one for one in bill["components"] if canonicalize_name(one["name"]) in found]
    hashes = _hashes()
    for one in bill["components"]:
        one["hashes"] = [
            {"alg": "SHA-256", "content": value} for value in hashes[canonicalize_name(one["name"]), one["version"]]
        ]
    kept = {one["bom-ref"] for one in (bill["metadata"]["component"], *bill["components"])}
    bill["dependencies"] = [_among(one, kept) for one in bill["dependencies"] if one["ref"] in kept]
    return json.dumps(bill, indent=2) + "\n"


def _without_addresses(bill: Any) -> Any:
    """The same without references to elsewhere: where a package was fetched from is no property of it."""
    if isinstance(bill, list):
        return [_without_addresses(one) for one in bill]
    if isinstance(bill, dict):
        return {key: _without_addresses(one) for key, one in bill.items() if key != "externalReferences"}
    return bill


def _among(dependency: dict[str, Any], kept: set[str]) -> dict[str, Any]:
    return {**dependency, "dependsOn": [one for one in dependency.get("dependsOn", ()) if one in kept]}


def _hashes() -> dict[tuple[str, str], list[str]]:
    """SHA-256 of the files of each package of the lock, by name and version."""
    found = ((name, re.split("==|[ ;]", entry)[1], entry) for name, entry in _locked())
    return {(name, number): re.findall(r"sha256:(\w+)", entry) for name, number, entry in found}


def _locked() -> Iterator[tuple[str, str]]:
    """Name and entry of every package of the lock, as it stands there."""
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    for entry in re.findall(r"^[\w.-]+(?:\[.*\])?==(?:.*\\\n)*.*$", lock, re.MULTILINE):
        yield canonicalize_name(re.split(r"[\[=]", entry)[0]), entry


def requirements(found: Mapping[str, set[str]]) -> str:
    """The part of the lock that is installed with the package, hashes and all."""
    return "\n".join(entry for name, entry in _locked() if name in found) + "\n"


def _output(module: str, *arguments: str) -> str:
    command = [sys.executable, "-m", module, *arguments]
    return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout


if __name__ == "__main__":
    what, *rest = sys.argv[1:]
    if what == "licences":
        (ROOT / "docs" / "licences.md").write_text(licences(shipped()), encoding="utf-8")
    else:
        made = {"sbom": sbom, "requirements": requirements}[what](shipped())
        Path(rest[0]).write_text(made, encoding="utf-8")
