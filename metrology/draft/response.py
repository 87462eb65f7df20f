"""A draft of a response test: a module on a line under thrust, a file a run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from metrology.draft.parts import Bound, Writer, stretch, times
from metrology.draft.recognition import driven, moved, pull
from metrology.draft.seen import Seen
from metrology.draft.survey import Survey

DUE = {False: ("x", "v", "T", "F"), True: ("angle", "rate", "torque", "drive")}
"""Columns of a rig that moves along a line, and of one that turns: position, speed, tension, thrust."""
TAUT = 0.3
"""Part of the largest tension from which on a line is taken to be taut throughout. A choice: below it a sagging line
and the zero of the cell bend the record, above it most readings of a pull are left for the line through them."""


def write(writer: Writer) -> Iterator[str]:
    """Lines of the draft."""
    one = writer.surveys[0]
    columns, turns = _columns(one)
    x, pulled = columns[0].seen, _tension(one)
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
    line = _line(x, one.first("velocity"), pulled)
    yield f"      taut: {_guess(writer, 'taut', line, 'position at which the line is just taut, such as 1.500 m')}"
    yield "      # line_weight: catenary   # with length and linear_density of the sample"
    yield "    # known: {mass: {common: 25 g, source: …}, thrust_gain: {common: 1 %, source: …}}   # within what"
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
    elif begin := _begin(source, thrust):
        yield f"        held_until: {begin}   # guess: the thrust begins; leave it out where the module was free before"
    yield f"        start: {{position: {_start(columns[0].seen)}}}   # guess: the first reading"


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


def _tension(one: Survey) -> Seen | None:
    """The column of the tension; one of another file at the times of the motion."""
    if (own := pull(one)) or not one.beside:
        return own
    other = next((each for each in one.beside if pull(each)), None)
    force = pull(other) if other else None
    time, at = one.first("time"), other.first("time") if other else None
    if force is None or time is None or at is None or force.values is None or time.unit != at.unit:
        return force
    if time.values is None or at.values is None:
        return replace(force, values=None)
    known = np.isfinite(force.values) & np.isfinite(at.values)
    values = np.interp(time.values, at.values[known], force.values[known], left=np.nan, right=np.nan)
    return replace(force, values=values)


def _begin(one: Survey, thrust: Seen) -> str:
    """Time until which there is no thrust; nothing where it is there from the beginning."""
    time = one.first("time")
    if time is None or time.values is None or thrust.values is None:
        return ""
    pushed = np.flatnonzero(np.abs(thrust.values) > 0.5 * np.nanmax(np.abs(thrust.values)))
    # The last reading without thrust: a thrust that was measured rises between two readings.
    return f"{time.values[pushed[0] - 1]:.6g} {time.unit or 's'}" if len(pushed) and pushed[0] > 1 else ""


def _start(x: Seen) -> str:
    first = next(value for value in x.values if np.isfinite(value)) if x.values is not None else 0.0
    return f"{first:.6g} {x.unit or 'm'}"


def _line(x: Seen, speed: Seen | None, pulled: Seen | None) -> dict[str, str]:
    """Where the line is taut, and its stiffness, by tension against position (and speed) while it pulls."""
    if pulled is None or x.values is None or pulled.values is None or not (x.unit and pulled.unit):
        return {}
    both = np.isfinite(x.values) & np.isfinite(pulled.values)
    position, tension = x.values[both], pulled.values[both]
    taut = tension > TAUT * np.max(tension, initial=0.0)
    if np.count_nonzero(taut) < 10 or not np.ptp(position[taut]) > 0:
        return {}
    terms = [position[taut], np.ones(np.count_nonzero(taut))]
    if speed is not None and speed.values is not None:
        terms.append(np.nan_to_num(speed.values[both][taut]))
    slope, zero = np.linalg.lstsq(np.column_stack(terms), tension[taut], rcond=None)[0][:2]
    if not slope > 0:
        return {}
    return {"taut": f"{-zero / slope:.4g} {x.unit}", "k": f"{slope:.3g} {pulled.unit}/{x.unit}"}


def _guess(writer: Writer, name: str, line: dict[str, str], asked: str) -> str:
    """A value by the line through tension and position, or one that is asked for."""
    return writer.take(name, line[name], "by tension against position") if line else writer.ask(name, asked)
