"""A draft campaign from files of readings that nobody described, with every guess marked as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from metrology.draft.pairs import paired
from metrology.draft.runs import found_in
from metrology.draft.survey import NO_PARTS, Survey
from metrology.draft.writing import Draft, write
from metrology.errors import Fault, MetrologyError

__all__ = ["Draft", "Drafter", "draft", "place"]


@dataclass
class Drafter:
    """Files of readings, and drafts of a campaign from them by what is given; each file is read once a decimal mark.

    Parameters
    ----------
    files : sequence of Path
        Files of readings of one test, all in one folder or below it; each may hold several runs.
    output : Path, optional
        The campaign file; beside the first file and named after it where nothing is said.
    parts : mapping of str to str
        What of each file is read, its `member`, `sheet`, `group`, `dataset` or `channel`; the whole where nothing is
        said.
    """

    files: Sequence[Path]
    output: Path | None = None
    parts: Mapping[str, str] = field(default_factory=dict)
    _read: dict[str, list[Survey]] = field(default_factory=dict)

    @property
    def path(self) -> Path:
        """Where the draft goes."""
        return self.output or self.files[0].with_name(f"{self.files[0].name.partition('.')[0]}.yaml")

    def draft(self, given: Mapping[str, str]) -> Draft:
        """Return a draft; nothing is written.

        Parameters
        ----------
        given : mapping of str to str
            Values that the files do not have, such as ``mass``.

        Raises
        ------
        MetrologyError
            For a file that cannot be read, that holds nothing known, or that lies outside the folder of the campaign
            file.
        """
        decimal = given.get("decimal", "")
        if decimal not in ("", "point", "comma"):
            raise MetrologyError(Fault("--set decimal", f"'{decimal}'", "'point' or 'comma'"))
        if decimal not in self._read:
            self._read[decimal] = self._surveyed({**self.parts, **({"decimal": decimal} if decimal else {})})
        return write(self._read[decimal], self.path, given)

    def _surveyed(self, parts: Mapping[str, str]) -> list[Survey]:
        for file in self.files:
            if wrong := sorted(set(file.name) & set(":\\")):
                got, expected = f"'{wrong[0]}' in the name of a file", "a name that a campaign can have"
                raise MetrologyError(Fault(str(file), got, expected, "rename the file"))
            if not file.resolve().is_relative_to(self.path.parent.resolve()):
                expected = f"a file in {self.path.parent}, the folder of the campaign file, or below it"
                raise MetrologyError(Fault(str(file), "a file elsewhere", expected, "copy it there"))
        return paired([run for file in self.files for run in found_in(file, parts)])


def draft(
    files: Sequence[Path], given: Mapping[str, str], output: Path | None = None, parts: Mapping[str, str] = NO_PARTS
) -> tuple[Path, Draft]:
    """Look at files and return where a draft campaign goes, and the draft, as a `Drafter` makes it."""
    drafter = Drafter(files, output, parts)
    return drafter.path, drafter.draft(given)


def place(path: Path, made: Draft) -> None:
    """Write a draft where no file stands.

    Raises
    ------
    MetrologyError
        Where there is one.
    """
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(made.text)
    except FileExistsError:
        fix = "name another with --output"
        raise MetrologyError(Fault(str(path), "a file that exists", "a new one: nothing is overwritten", fix)) from None
    except OSError as error:
        raise MetrologyError(Fault(str(path), f"no place to write ({error.strerror})", "a folder")) from None
