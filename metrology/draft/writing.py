"""A draft campaign out of what files were found to hold: every guess is marked as one."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from metrology import units
from metrology.draft import decay, elongation, line, machine, response
from metrology.draft.parts import Writer, quote
from metrology.draft.recognition import held, load_of, method, read_again
from metrology.draft.runs import remarks
from metrology.draft.survey import Survey
from metrology.draft.vocabulary import dimension_of
from metrology.errors import Fault, MetrologyError, printable


@dataclass(frozen=True)
class Kind:
    """What files may become: its lines, its title, and whether several files make one test."""

    write: Callable[[Writer], Iterator[str]]
    title: str
    several: bool = True


KINDS = {
    "elongation": Kind(elongation.write, "Elongation under dead loads", several=False),
    "decay": Kind(decay.write, "Free decay"),
    "response": Kind(response.write, "Response to thrust"),
    "tension": Kind(machine.tension, "Tension"),
    "relaxation": Kind(machine.relaxation, "Relaxation"),
    "line": Kind(line.write, "Force against extension", several=False),
}


@dataclass
class Draft:
    """A campaign file as text, and what only the laboratory knows: its name, and what it is.

    `remarks`: what is to be known of it before it is used.
    """

    text: str = ""
    missing: dict[str, str] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)


def write(surveys: Sequence[Survey], path: Path, given: Mapping[str, str]) -> Draft:
    """Return a draft of the campaign file `path` for files in its folder.

    Parameters
    ----------
    surveys : sequence of Survey
        What the files hold; all of one kind.
    path : Path
        Where the campaign file will stand.
    given : mapping of str to str
        Values that the user states, by the names of `Draft.missing` and of the guesses.

    Raises
    ------
    MetrologyError
        Where no method was recognised, and for a value under a name that the draft does not have.
    """
    writer = Writer(surveys, path.parent, given)
    kind = _kind(surveys)
    writer.remarks.extend(remarks(surveys))
    lines = [*_head(writer, path, kind), *KINDS[kind].write(writer)]
    if unknown := sorted(set(given) - set(writer.known)):
        got, expected = f"'{unknown[0]}', which this draft does not have", f"one of {', '.join(writer.known)}"
        raise MetrologyError(Fault(f"--set {unknown[0]}", got, expected))
    return Draft("\n".join(lines) + "\n", writer.missing, list(dict.fromkeys(writer.remarks)))


def _kind(surveys: Sequence[Survey]) -> str:
    """What the files are; those of several kinds, or of none, are refused."""
    for one in surveys:
        if (times := read_again(one)) and (load := load_of(one)):
            way = one.first("direction")
            got = f"loads under '{load.heading}' that were read up to {times} times{' a direction' if way else ''}"
            asked = "a column 'repeat' that numbers the repeats"
            more = "" if way else ", and a column 'direction' (loading, unloading) where loads were taken off, too"
            raise MetrologyError(Fault(str(one.path), got, asked, f"add it to the file{more}; then import it again"))
    kinds = {(method(one), held(one) if method(one) == "relaxation" else "") for one in surveys}
    kind = next(iter(kinds))[0]
    if len(kinds) == 1 and kind and (len(surveys) == 1 or KINDS[kind].several):
        return kind
    one = next((one for one in surveys if not method(one)), surveys[0])
    had = "; ".join(f"'{column.heading}' looks like {column.role or 'nothing known'}" for column in one.columns[:12])
    bare = [f"'{column.heading}'" for column in one.columns[:12] if not column.unit and column.values is not None]
    without = f"; no unit is read of {', '.join(bare)}" if bare else ""
    got = f"columns of no known test ({had}{without})"
    if not any(name == "" for name, _ in kinds):
        kinds_of = ", ".join(f"{each.path.name}: {method(each)}" for each in surveys[:6])
        got = f"files of several kinds ({kinds_of})" if len(kinds) > 1 else f"{len(surveys)} files of one {kind}"
    expected = (
        "load and reading; time and displacement, a file a release; time, position and thrust, a file a run; "
        "force and extension, a file a specimen"
    )
    fix = "write 'readings:' by hand (docs/readings.md)"
    volts = [column.heading for column in one.columns if dimension_of(column.unit) == units.dimension("V")]
    if volts:
        fix = f"multiply '{volts[0]}' by the sensitivity of its sensor, so that it has the unit of what it senses"
    elif stress := one.first("stress"):
        fix = (
            f"a test reads a force: write '{stress.heading}' times the area of the section as a column such as "
            "'force / N', with the strain or the extension; state the section in the draft"
        )
    elif bare:
        fix = f"write names and units in the headings, such as 'force / N' or 'extension_mm'; or {fix}"
    raise MetrologyError(Fault(str(one.path), got, expected, fix))


def _head(writer: Writer, path: Path, kind: str) -> Iterator[str]:
    first = writer.surveys[0]
    yield "# A draft, made by `metrology import`. What is marked as a guess is to be confirmed or corrected."
    yield "# Every key is explained in docs/campaign.md."
    yield printable(f"# Check it with:   {command('check', path)}")
    yield printable(f"# Its report:      {command('report', path)}")
    files = dict.fromkeys(
        f"# {one.path.name}: {one.title}{f' by {one.found.maker}' if one.found.maker else ''}"
        f"{''.join(f'; {text}' for text in one.notices)}"
        for each in writer.surveys
        for one in (each, *each.beside)
    )
    yield from map(printable, files)
    yield from (printable(f"# {remark}") for remark in writer.remarks)
    yield "format: metrology-campaign/1"
    stem = re.sub(r"[^\w-]+", "-", first.path.name.partition(".")[0]).strip("-_") or "campaign"
    stem = stem if stem[0].isalpha() else f"campaign-{stem}"
    yield f"id: {writer.take('id', stem[:64], 'the name of the file')}"
    words = "Creep" if kind == "relaxation" and held(first) == "load" else KINDS[kind].title
    title = quote(f"{words}, {writer.common('sample') or first.path.name.partition('.')[0]}")
    yield f"title: {writer.take('title', title, 'what the columns look like')}"
    yield ""


def command(name: str, path: Path) -> str:
    """A command with a campaign file, as a shell takes it.

    Examples
    --------
    >>> command("check", Path("-x.yaml")), command("check", Path("my run.yaml"))
    ('metrology check ./-x.yaml', "metrology check 'my run.yaml'")
    """
    text = f"./{path}" if str(path).startswith("-") else str(path)
    plain = re.fullmatch(r"[\w@%+=:,./-]+", text)  # letters beyond ASCII need no quotation marks
    return f"metrology {name} {text if plain else shlex.quote(text)}"
