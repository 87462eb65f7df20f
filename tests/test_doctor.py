"""`metrology doctor` names what is there and what is not, as pyproject.toml has it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from metrology.cli import doctor, main
from metrology.report import pango

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def names(requirements: list[str]) -> set[str]:
    return {re.split(r"[\[>=<]", one)[0].casefold() for one in requirements}


def test_twice_packages_and_extras_are_those_of_the_project() -> None:
    assert {name.casefold() for name in doctor.NEEDED} <= names(PROJECT["dependencies"])
    inside = PROJECT["optional-dependencies"].keys() - {"dev", "docs", "bench", "fuzz"}
    assert doctor.EXTRAS.keys() == doctor.PURPOSES.keys() == inside
    for extra, packages in doctor.EXTRAS.items():
        assert {name.casefold() for name in packages} == names(PROJECT["optional-dependencies"][extra])


def test_law_what_is_installed_is_said_with_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"^ok      numpy: \d", said, re.MULTILINE)
    assert re.search(r"^ok      Pango: ", said, re.MULTILINE)


def test_limit_without_pango_the_way_to_get_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(_name: str) -> object:
        raise OSError

    for system, words in (("Linux", "libpangoft2-1.0-0"), ("Darwin", "brew install pango"), ("Windows", "MSYS2")):
        monkeypatch.setattr(pango.platform, "system", lambda system=system: system)
        found = doctor._pango(fails)
        assert (found.there, found.needed) == (False, True)
        assert words in found.text


def test_limit_without_an_extra_its_purpose_and_command_are_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor, "EXTRAS", {"files": ("no-such-package-at-all",)})
    assert main(["doctor"]) == 0
    assert "absent  extra files: readings from Excel" in (said := capsys.readouterr().out)
    assert "pip install 'tether-metrology[files]'" in said
