"""Reconstruct the readings of the response tests of the four lines: nylon, spectra, peek, al-1100.

The paper published results and figures, not readings. What is written here is what such a rig would have read: a
module of 25 kg floats on a table, tied by the line to a load cell; two thrusters push it (0.38 N or 0.62 N, a step or
an impulse) until the line snatches taut. The physics is integrated with equations of its own, which share nothing
with the simulation that the readings are to judge: SciPy, tight tolerance, every contact and every stop located and
the motion begun anew there.

What is planted, beyond the mass-spring-damper of the paper:

nylon     dry friction between module and table (the paper: "residual friction effects")
spectra   stiffness that grows with elongation, as more strands of the braid bear (the paper: "differential elongation")
peek      the sag of the tape, which its campaign's model has too, and nothing else
al-1100   the sag of the tape, and a set-up about as stiff as the tape (the paper: "comparable with the experimental
setup")

Every run has a thrust, a start and a cell zero of its own, and all runs share errors of thrust, mass, clock and cell
gain, all within the uncertainties that the campaign files state. Motion capture at 100 Hz, load cell at 250 Hz, both
with noise and rounded.

``python campaigns/reconstruct_response.py`` writes the readings; it is deterministic.
``python campaigns/reconstruct_response.py --solve nylon`` looks for the true k and c with which the model of the paper,
fitted the way of the paper, gives the published values, and prints them; they stand in `LINES`.
"""

from __future__ import annotations

import gzip
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import asinh, exp, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

FOLDER = Path(__file__).parent
MASS = 25.0
GRAVITY = 9.8
BEGIN = 1.0
CAMERAS, CELL = 100, 250
"""Rates / Hz of motion capture and load cell."""
NOISE = {"x": 2.0e-4, "v": 1.5e-3, "T": 4.0e-3}
DIGITS = {"x": 5, "v": 4, "T": 3}
TIGHT = {"rtol": 1e-10, "atol": 1e-13}
LONGEST = 0.01
"""Longest step / s: a line that lets go for a moment crosses zero twice, which SciPy does not see within one step."""


@dataclass(frozen=True)
class Line:
    """A line as it truly is, SI; with `elastic_catenary` it hangs throughout, else eq. 3 of the paper serves."""

    k: float
    c: float
    length: float
    weight: float
    gap: float
    seed: int
    friction: float = 0.0
    cubic: float = 0.0
    compliance: float = 0.0
    elastic_catenary: bool = False
    published: tuple[float, float] = (0.0, 0.0)

    def nearer(self, tension: float) -> tuple[float, float]:
        """How much nearer its ends hang than it is long, s·(1 − asinh(w)/w) with w = q·s/(2·T), and how fast it falls.

        Both ends at one height, T the horizontal part of the tension (Irvine, Cable Structures, 1981, 1.1).
        """
        w = self.weight * self.length / (2 * tension)
        ratio = asinh(w) / w
        return self.length * (1 - ratio), self.length / tension * (ratio - 1 / sqrt(1 + w**2))


LINES = {
    "nylon": Line(168.884, 7.9097, 1.5, 8.06e-5 * GRAVITY, 0.05, 11, friction=1e-3, published=(167.64, 8.0)),
    "spectra": Line(736.588, 34.7558, 1.5, 1.60e-3 * GRAVITY, 0.05, 12, cubic=1.5e5, published=(753.33, 35.0)),
    "peek": Line(1810.91, 0.37, 3.0, 1.63e-3 * GRAVITY, 0.10, 13, elastic_catenary=True),
    "al-1100": Line(24734.25, 48.16, 2.99, 3.39e-3 * GRAVITY, 0.10, 14, compliance=1 / 40e3, elastic_catenary=True),
}


@dataclass(frozen=True)
class Run:
    """One run as commanded: thrust / N until `until` / s, and the length of its record / s."""

    name: str
    thrust: float
    until: float
    end: float


def runs(name: str) -> tuple[Run, ...]:
    """Two thrust levels, impulse and step, each twice."""
    sags = LINES[name].elastic_catenary
    burst = {0.38: 4.0, 0.62: 2.6} if sags else {0.38: 2.0, 0.62: 1.6}
    found = []
    for label, thrust in (("low", 0.38), ("high", 0.62)):
        for repeat in (1, 2):
            found.append(Run(f"{label}-step-{repeat}", thrust, 30.0, 30.0))
            found.append(Run(f"{label}-impulse-{repeat}", thrust, BEGIN + burst[thrust], 20.0 if sags else 12.0))
    return tuple(found)


# ---- physics --------------------------------------------------------------------------------------------------------
Rate = Callable[[float, np.ndarray], list[float]]


def plain_line(line: Line, mass: float, push: Push, start: float, stamps: np.ndarray) -> np.ndarray:
    """Rows x, v, T of a module on a line without sag, with dry friction: four regimes, each up to its first event."""
    y, now, found = np.array([start, 0.0]), BEGIN, np.full((3, len(stamps)), np.nan)
    found[:, stamps < BEGIN] = np.array([[start], [0.0], [_slack_weight(line, line.length - start)]])
    edges = [*sorted({BEGIN, *push.edges}), stamps[-1] + 1e-9]
    contact, slide = "slack", 0
    while now < stamps[-1]:
        edge = next(t for t in edges if t > now + 1e-12)
        force = push((now + edge) / 2)
        slide = slide or _moves(line, y, contact, force)
        tension = _tension(line, contact)
        done = solve_ivp(
            _rate(line, mass, tension, force, slide),
            (now, edge),
            y,
            "DOP853",
            dense_output=True,
            events=_ends(line, contact, tension, force, slide),
            max_step=LONGEST,
            **TIGHT,
        )
        inside = (stamps >= now) & (stamps < done.t[-1])
        if inside.any():
            rows = done.sol(stamps[inside])
            found[:, inside] = np.vstack([rows, [tension(x, v) for x, v in rows.T]])
        y, now = done.y[:, -1].copy(), float(done.t[-1])
        contact, slide = _next(y, contact, slide, [len(t) > 0 for t in done.t_events])
    return found


def _slack_weight(line: Line, gap: float) -> float:
    """Eq. 3 of the paper, held at its value 5 mm before taut."""
    gap = max(gap, 5e-3)
    span = line.length - gap
    return line.weight * span**2 / (8 * sqrt(3 * span * gap / 8))


def _pull(line: Line, e: float, v: float) -> float:
    return line.k * e + line.cubic * e**3 + line.c * v


def _tension(line: Line, contact: str) -> Callable[[float, float], float]:
    if contact == "taut":
        return lambda x, v: _pull(line, x - line.length, v)
    return lambda x, _v: _slack_weight(line, line.length - x)


def _rate(line: Line, mass: float, tension: Callable[[float, float], float], force: float, slide: int) -> Rate:
    if slide == 0:
        return lambda _t, _y: [0.0, 0.0]
    return lambda _t, y: [y[1], (force - tension(y[0], y[1]) - slide * line.friction) / mass]


def _moves(line: Line, y: np.ndarray, contact: str, force: float) -> int:
    """Which way a module at rest begins to slide; 0 where friction holds it."""
    net = force - _tension(line, contact)(y[0], 0.0)
    return 0 if abs(net) <= line.friction else int(np.sign(net))


def _ends(line: Line, contact: str, tension: Callable[[float, float], float], force: float, slide: int) -> list[Rate]:
    """Contact made or lost, the module stopped or set going: what ends a regime, in this order."""

    def crossing(_t: float, y: np.ndarray) -> float:
        return y[0] - line.length

    def pulling(_t: float, y: np.ndarray) -> float:
        return _pull(line, y[0] - line.length, y[1])

    def speed(_t: float, y: np.ndarray) -> float:
        return y[1] if slide else 1.0

    def grip(_t: float, y: np.ndarray) -> float:
        return line.friction - abs(force - tension(y[0], 0.0)) if slide == 0 else 1.0

    crossing.direction = 1 if contact == "slack" else -1
    pulling.direction = -1 if contact == "taut" else 1
    speed.direction = -slide
    grip.direction = -1
    watched = [crossing, pulling, speed, grip]
    for event in watched:
        event.terminal = True
    if contact == "slack":
        watched[1] = _never
    elif contact == "taut":
        watched[0] = _never
    return watched


def _never(_t: float, _y: np.ndarray) -> float:
    return 1.0


def _next(y: np.ndarray, contact: str, slide: int, happened: list[bool]) -> tuple[str, int]:
    crossed, pulled, stopped, _ = happened
    if crossed and contact == "slack":
        contact = "taut"
    elif crossed:
        contact = "slack"
    elif pulled:
        contact = "lifted" if contact == "taut" else "taut"
    if stopped:
        y[1] = 0.0
        slide = 0
    return contact, slide


def sagging_line(line: Line, mass: float, push: Push, start: float, stamps: np.ndarray) -> np.ndarray:
    """Rows x, v, T of a module on an elastic catenary in series with a compliant set-up: smooth, never without tension.

    The line's own strain ε obeys T = k·ε + c·ε′, and the distance beyond the free length is e = ε − s·(1 − asinh(w)/w)
    + C·T, w = q·s/(2·T). Both together give ε′ and so the rate of T; the state is x, v, ln T. The dashpot makes this
    stiff, hence LSODA in place of DOP853.
    """
    compliance = line.compliance
    T = brentq(lambda T: T / line.k + compliance * T - line.nearer(T)[0] - (start - line.length), 1e-6, 1e3, xtol=1e-15)
    y, now, found = np.array([start, 0.0, np.log(T)]), BEGIN, np.full((3, len(stamps)), np.nan)
    found[:, stamps < BEGIN] = np.array([[start], [0.0], [T]])
    edges = [*sorted(push.edges), stamps[-1] + 1e-9]
    for edge in (t for t in edges if t > BEGIN):
        force = push((now + edge) / 2)

        def rate(_t: float, y: np.ndarray, force: float = force) -> list[float]:
            T = exp(y[2])
            near, fall = line.nearer(T)
            strain = y[0] - line.length + near - compliance * T
            strain_rate = (T - line.k * strain) / line.c
            return [y[1], (force - T) / mass, (y[1] - strain_rate) / ((fall + compliance) * T)]

        inside = (stamps >= now) & (stamps < edge)
        wanted = [*stamps[inside], edge]
        done = solve_ivp(rate, (now, edge), y, "LSODA", t_eval=wanted, rtol=1e-9, atol=1e-12, max_step=0.05)
        assert done.success, done.message
        found[:, inside] = [done.y[0, :-1], done.y[1, :-1], np.exp(done.y[2, :-1])]
        y, now = done.y[:, -1].copy(), edge
        if edge > stamps[-1]:
            break
    return found


class Push:
    """Thrust over time: constant from the beginning until `until`."""

    def __init__(self, value: float, until: float) -> None:
        self.value, self.until, self.edges = value, until, (BEGIN, until)

    def __call__(self, t: float) -> float:
        """Thrust / N at time t / s."""
        return self.value if BEGIN <= t < self.until else 0.0


# ---- readings -------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Errors:
    """What the lab does not know exactly: shared by all runs, then by each one."""

    thrust: float
    mass: float
    clock: float
    gain: float
    zero: float = 0.0
    start: float = 0.0


def shared(rng: np.random.Generator) -> Errors:
    """Errors of all runs of a line."""
    thrust, mass, clock, gain = rng.standard_normal(4)
    return Errors(1 + 0.003 * thrust, 1 + 0.0008 * mass, 0.8e-3 * clock, 1 + 0.002 * gain)


def own(rng: np.random.Generator, common: Errors) -> Errors:
    """Errors of one run."""
    thrust, zero, start = rng.standard_normal(3)
    return replace(common, thrust=common.thrust * (1 + 0.0015 * thrust), zero=3e-3 * zero, start=2e-4 * start)


def measure(line: Line, run: Run, errors: Errors, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Readings of one run: 't' with 'x' and 'v' of the cameras, 's' with 'T' of the cell."""
    t, s = np.arange(round(run.end * CAMERAS) + 1) / CAMERAS, np.arange(round(run.end * CELL) + 1) / CELL
    true = s - errors.clock
    stamps, places = np.unique(np.concatenate([t, np.maximum(true, 0.0)]), return_inverse=True)
    move = sagging_line if line.elastic_catenary else plain_line
    until = run.until if run.until < run.end else run.end + 1.0
    push = Push(run.thrust * errors.thrust, until)
    rows = move(line, MASS * errors.mass, push, line.length - line.gap + errors.start, stamps)
    x, v, T = rows[0, places[: len(t)]], rows[1, places[: len(t)]], rows[2, places[len(t) :]]
    readings = {"t": t, "x": x, "v": v, "s": s, "T": errors.gain * T + errors.zero}
    for channel, noise in NOISE.items():
        readings[channel] = readings[channel] + noise * rng.standard_normal(len(readings[channel]))
    return readings


def occlusions(run: Run, rng: np.random.Generator) -> Iterator[slice]:
    """Frames in which the markers are hidden: two short gaps in every step of the first repeat."""
    if run.name.endswith("step-1"):
        for _ in range(2):
            first = int(rng.integers(500, 2500))
            yield slice(first, first + int(rng.integers(5, 40)))


def campaign(name: str, line: Line) -> Iterator[tuple[str, str]]:
    """Files of one line: name and text."""
    rng = np.random.default_rng([2026, line.seed])
    common = shared(rng)
    for run in runs(name):
        readings = measure(line, run, own(rng, common), rng)
        hidden = np.zeros(len(readings["t"]), dtype=bool)
        for gap in occlusions(run, rng):
            hidden[gap] = True
        yield f"{run.name}-motion.csv.gz", _motion(readings, hidden)
        yield f"{run.name}-cell.csv.gz", _cell(readings)


def _motion(readings: dict[str, np.ndarray], hidden: np.ndarray) -> str:
    lines = ["time / s,x / m,v / m/s"]
    for t, x, v, gone in zip(readings["t"], readings["x"], readings["v"], hidden, strict=True):
        lines.append(f"{t:.2f},," if gone else f"{t:.2f},{x:.{DIGITS['x']}f},{v + 0.0:.{DIGITS['v']}f}")
    return "\n".join(lines) + "\n"


def _cell(readings: dict[str, np.ndarray]) -> str:
    rows = (f"{t:.3f},{T:.{DIGITS['T']}f}" for t, T in zip(readings["s"], readings["T"], strict=True))
    return "\n".join(["time / s,T / N", *rows]) + "\n"


def write(line: Line, name: str, place: Path) -> int:
    """Write the readings of one line to the folder of its campaign and return their bytes."""
    folder, size = place / "readings", 0
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in campaign(name, line):
        packed = gzip.compress(text.encode(), 9, mtime=0)
        (folder / file).write_bytes(packed)
        size += len(packed)
    return size


def solve(name: str) -> None:
    """Print the true k and c with which the fit by least RMS difference gives the published ones, to their digits.

    The sum of squares has kinks wherever a contact passes a reading, so that the last digits of its minimum jump about
    as the truth moves: the search goes on, in steps that shrink, until they fall into place.
    """
    from metrology.campaign.load import load
    from metrology.chain.plan import Plan
    from metrology.estimation import paper_way
    from metrology.methods.response.preparation import prepared

    line = LINES[name]
    with TemporaryDirectory() as place:
        shutil.copy(FOLDER / name / "campaign.yaml", place)
        for turn in range(80):
            write(line, name, Path(place))
            loaded = load(Path(place) / "campaign.yaml")
            ready = prepared(Plan(), loaded, *next(iter(loaded.tests.items())))
            found = paper_way(ready.rig, ready.of("identification"), start=line.published)
            print(f"{name}: true k = {line.k}, c = {line.c} gives {found.k:.4f}, {found.c:.4f}", flush=True)
            if abs(found.k / line.published[0] - 1) < 1e-4 and abs(found.c - line.published[1]) < 0.05:
                return
            share = max(0.3, 1 - turn / 10)
            k = line.k * (line.published[0] / found.k) ** share
            c = line.c * (line.published[1] / found.c) ** share
            line = replace(line, k=round(k, 3), c=round(c, 4))


def main() -> None:
    """Write everything, or solve for the true values of one line."""
    if sys.argv[1:2] == ["--solve"]:
        solve(sys.argv[2])
        return
    for name, line in LINES.items() if len(sys.argv) < 2 else [(name, LINES[name]) for name in sys.argv[1:]]:
        print(f"{name}: {write(line, name, FOLDER / name) / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
