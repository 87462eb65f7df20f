"""A draft of a response test: a module on a line under thrust, a file a run."""

from __future__ import annotations

from collections.abc import Iterator

from metrology.draft.beginning import Line, begin_of, beginning, line_of, rest_of, tension
from metrology.draft.parts import Bound, Writer, stretch, times
from metrology.draft.recognition import driven, moved, pull
from metrology.draft.survey import Survey

DUE = {False: ("x", "v", "T", "F"), True: ("angle", "rate", "torque", "drive")}
"""Columns of a rig that moves along a line, and of one that turns: position, speed, tension, thrust."""


def write(writer: Writer) -> Iterator[str]:
    """Lines of the draft."""
    one = writer.surveys[0]
    columns, turns = _columns(one)
    pulled = tension(one)
    inert = "inertia" if turns else "mass"
    named = {"position": "sensor", **({"tension": "cell"} if pulled else {}), "thrust": "thrusters"}
    yield "instruments:"
    yield from writer.instrument("sensor", "motion capture", columns[0])
    if pulled:
        yield from writer.instrument("cell", "load cell", stretch("T", pulled), first=False)
    yield "  thrusters: {kind: thrusters}   # guess"
    yield ""
    yield from writer.sample()
    yield "tests:"
    yield "  response:"
    yield "    method: response"
    yield "    sample: sample"
    yield from writer.conduct()
    yield f"    instruments: {{{', '.join(f'{role}: {name}' for role, name in named.items())}}}"
    yield "    rig:"
    such = "0.120 kg*m^2" if turns else "25.00 kg"
    yield f"      {inert}: {writer.ask(inert, f'everything that moves, such as {such}')}"
    line = line_of(writer.surveys)
    yield f"      taut: {_guess(writer, 'taut', line, 'position at which the line is just taut, such as 1.500 m')}"
    yield "      # line_weight: catenary   # with length and linear_density of the sample"
    yield from _known(writer, line)
    yield "    identification:"
    yield "      free: [k, c]"
    yield "      start:"
    yield f"        k: {_guess(writer, 'k', line, 'stiffness at which the search begins, such as 150 N/m')}"
    yield "    runs:"
    for number, each in enumerate(writer.surveys, start=1):
        yield from _run(writer, each, number)


def _run(writer: Writer, one: Survey, number: int) -> Iterator[str]:
    files = [_columns(each) for each in (one, *one.beside)]
    columns, turns = files[0]
    last = number > 1 and number == len(writer.surveys)
    yield f"      run-{number}:"
    why = "the last run judges the model" if last else "what is not held out is fitted"
    yield f"        purpose: {'verification' if last else 'identification'}   # guess: {why}"
    yield "        readings:"
    for each, (bound, _) in zip((one, *one.beside), files, strict=True):
        lines = list(writer.readings(each, bound, indent=12))
        paired = "" if each is one else "   # guess: of this run, by its name and its times"
        yield f"          - {lines[0].strip()}{paired}"
        yield from lines[1:]
    found = [(each, seen) for each in (one, *one.beside) if (seen := driven(each))]
    source, thrust = found[0] if found else (one, None)
    if thrust is None:
        begin = writer.ask("thrust.from", "when the thrust begins, such as 1.0 s")
        unit, size = ("torque", "0.02 N*m") if turns else ("force", "0.38 N")
        yield f"        thrust: [{{from: {begin}, {unit}: {writer.ask(f'thrust.{unit}', f'thrust, such as {size}')}}}]"
    elif begin := begin_of(source, thrust):
        yield f"        held_until: {begin}   # guess: the thrust begins; leave it out where the module was free before"
    start = rest_of(one) or beginning(columns[0].seen)
    yield f"        start: {{position: {start.text}}}   # guess: {start.why}"


def _known(writer: Writer, line: Line | None) -> Iterator[str]:
    """What readings tell of the guesses above, and what the laboratory may add."""
    rests = [found for one in writer.surveys if (found := rest_of(one))]
    known = []
    if line is not None and "taut" not in writer.given:
        known.append(f"free_length: {{common: {line.spread}, source: line through tension and position}}")
    if len(rests) == len(writer.surveys) and len({one.unit for one in rests}) == 1:
        spread = max(one.scatter for one in rests)
        known.append(f"start_position: {{per_run: {spread:.1g} {rests[0].unit}, source: scatter of the rest}}")
    yield "    # known: {mass: {common: 25 g, source: …}, thrust_gain: {common: 1 %, source: …}}   # within what"
    if known:
        yield "    known:   # guess: what the readings tell; add what else is known only within an uncertainty"
        yield from (f"      {text}" for text in known)


def _columns(one: Survey) -> tuple[list[Bound], bool]:
    """Position first where the file has it, then time and what else there is; and whether the rig turns."""
    x = moved(one)
    turns = x is not None and x.role == "angle"
    position, speed, tension, thrust = DUE[turns]
    found = [*([stretch(position, x)] if x else []), *times(one)]
    for due, seen in ((speed, one.first("velocity")), (tension, pull(one)), (thrust, driven(one))):
        if seen is not None and seen is not x:
            found.append(stretch(due, seen))
    return found, turns


def _guess(writer: Writer, name: str, line: Line | None, asked: str) -> str:
    """A value by the line through tension and position, or one that is asked for."""
    if line is None:
        return writer.ask(name, asked)
    return writer.take(name, line.taut if name == "taut" else line.k, "by tension against position")
