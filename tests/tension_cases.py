"""Blind tension tests: three specimens by the generator of `truth_tension`, an effect of a known distance in them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np
from truth_tension import Machine, distance, pull

from metrology.diagnosis import Diagnosis
from metrology.diagnostics import tension
from metrology.gum.inputs import Input
from metrology.tension.lines import lines
from metrology.tension.test import Mounting, Range, TensionTest

KINDS = (
    {"memory": 0.0, "white": 0.0},
    {"memory": 0.6, "white": 0.3},
    {"memory": 0.3, "white": 0.0, "strain_division": 2e-6, "crosshead_division": 5e-7},
    {"memory": 0.5, "white": 0.5, "tails": True},
)
"""Noise: white, coloured, quantised, with heavy tails."""
EFFECTS = {
    # name → (what the generator is given, whether one specimen alone has it, the cause that is right)
    "slack": ({"slack": 1e-5}, False, "slack"),
    "toe": ({"toe": 1e-4}, False, "toe"),
    "softening": ({"softening": 0.05}, False, "curvature"),
    "hardening": ({"softening": -0.05}, False, "curvature"),
    "slip": ({"slip": 1e-5}, True, "slip"),
    "extensometer slip": ({"extensometer_slip": 1e-4}, True, "extensometer slip"),
    "extensometer toe": ({"extensometer_toe": 1e-4, "toe_force": 400.0}, True, "extensometer toe"),
    "bedding": ({"bedding": 0.05}, False, "memory"),
    "mullins": ({"mullins": 0.1}, False, "memory"),
    "creep": ({"creep": 0.02}, False, "creep"),
    "drift": ({"drift": 1.0}, False, "cell drift"),
    "yield": ({"plastic": 0.3}, False, "yield"),
    "lost section": ({"section": 0.01}, True, "lost section"),
    "heating": ({"warming": 2.0}, False, "heating"),
}
ALIKE = {
    "toe": {"extensometer toe"},
    "softening": {"yield", "extensometer toe"},
    "hardening": {"toe", "extensometer toe"},
    "bedding": {"yield", "creep", "cell drift", "heating"},
    "creep": {"memory", "yield", "cell drift", "heating"},
    "drift": {"heating"},
    "yield": {"curvature"},
}
"""Causes that no method parts from an effect of d = 10 at odds of 20 to 1 in 95 % of tests: whatever their sizes, less
than 4.6 standard deviations of the generator's own noise are between them (`studies/limits_tension.py`)."""
STEPS = ("slip", "extensometer slip", "lost section")
"""What happens at an instant, which is drawn."""
RANGE = (0.05, 0.9)
"""Parts of the largest force between which the line is drawn."""
CYCLED = ("bedding", "mullins", "creep", "drift", "heating")
"""What loading and unloading with growing peaks shows."""


def machine(name: str, kind: int) -> Machine:
    """A test in which nothing is wrong but the compliance of its set-up."""
    cycles = {"cycles": 3, "grows": True, "count": 1400} if name in CYCLED or name == "cycles" else {"count": 600}
    return Machine(**{**cycles, **KINDS[kind % len(KINDS)]})


@lru_cache(maxsize=100)
def factor(name: str, kind: int, place: float = 0.5) -> float:
    """Factor on the size of an effect that makes its distance 1, specimens together; `place`: where a step lies."""
    planted, alone, _ = EFFECTS[name]
    one = machine(name, kind)
    size = next(iter(planted))
    here = replace(one, **planted, slip_at=place)
    found = distance(replace(here, **{size: 0.0}), here, *RANGE) * (1.0 if alone else np.sqrt(3))
    return 1.0 / float(found)


def judged(name: str, d: float, seed: int, *, rigid: bool = False) -> Diagnosis:
    """Diagnosis of three specimens; `name` may be empty, or 'cycles': nothing is planted then."""
    rng = np.random.default_rng(seed)
    base = machine(name, seed)
    planted, alone = {}, False
    if name in EFFECTS:
        given, alone, _ = EFFECTS[name]
        size = next(iter(given))
        place = rng.uniform(0.25, 0.75) if name in STEPS else 0.5
        planted = {**given, size: given[size] * d * factor(name, seed % len(KINDS), place), "slip_at": place}
    mountings = []
    chosen = int(rng.integers(3))
    for number in range(3):
        compliance = 0.0 if rigid else 2e-8 * (1 + 0.1 * rng.normal())
        one = replace(base, EA=2e6 * (1 + 0.004 * rng.normal()), compliance=compliance)
        if not alone or number == chosen:
            one = replace(one, **planted)
        read = pull(one, rng)
        length = Input("length", 0.1, (), "m")
        mountings.append(
            Mounting("abc"[number], read["force"], read["time"], read["crosshead"], (read["strain"],), length)
        )
    test = TensionTest("pull", tuple(mountings), Range("share", *RANGE))
    return tension(test, lines(test), rng=np.random.default_rng(0))


def outcome(name: str, found: Diagnosis, *, rigid: bool) -> str:
    """'named', 'in its group' of `ALIKE`, 'in set', 'abstained', 'misnamed'; of nothing planted 'silent' or 'false'."""
    right = (set() if rigid else {"setup"}) | ({EFFECTS[name][2]} if name in EFFECTS else set())
    # Softening of all specimens alike or of each by itself is softening.
    # A compliance that is the same in every mounting is one of the set-up all the same.
    alike = {"uneven curvature": "curvature", "constant setup": "setup"}
    named, possible = ({alike.get(one, one) for one in names} for names in (found.named, found.possible))
    if named < possible == right:
        named = possible
    if name not in EFFECTS:
        return "silent" if named <= right and found.verdict != "unexplained" else "false"
    if named - right:
        return "misnamed"
    if EFFECTS[name][2] in named:
        return "named"
    if EFFECTS[name][2] not in possible:
        return "abstained"
    return "in its group" if possible <= right | ALIKE.get(name, set()) else "in set"


def campaign(first: int, each: int, nothing: int) -> Iterator[tuple[str, float, int, bool]]:
    """Name, distance, seed and whether the set-up is rigid, of every test of a study."""
    for at in range(nothing):
        yield ("cycles" if at % 3 == 2 else ""), 0.0, first + at, at % 2 == 0
    for row, name in enumerate(EFFECTS):
        for at in range(each):
            for place, d in enumerate((10.0, 30.0)):
                yield name, d, first + 10_000 * (place + 1) + 100 * row + at, at % 2 == 1
