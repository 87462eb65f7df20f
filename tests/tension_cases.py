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
UNLISTED = {
    "periodic error of the extensometer": ({"ripple": 1e-6}, False, ""),
    "periodic error of the crosshead": ({"wobble": 1e-7}, False, ""),
    "extensometer that sticks": ({"sticking": 1e-6}, False, ""),
    "backlash of the crosshead": ({"backlash": 1e-6}, False, ""),
}
"""Effects that no list of causes has; those of cycles show where the force turns."""
PAIRS = (
    ("slack", "softening"), ("slack", "lost section"), ("toe", "extensometer slip"), ("slip", "softening"),
    ("slip", "toe"), ("slack", "yield"), ("mullins", "slack"), ("heating", "slip"), ("drift", "slack"),
)  # fmt: skip
"""Two effects of which none is among what no method parts from the other (`ALIKE`)."""
STEPS = ("slip", "extensometer slip", "lost section")
"""What happens at an instant, which is drawn."""
RANGE = (0.05, 0.9)
"""Parts of the largest force between which the line is drawn."""
CYCLED = ("bedding", "mullins", "creep", "drift", "heating", "extensometer that sticks", "backlash of the crosshead")
"""What loading and unloading with growing peaks shows."""


def parts(name: str) -> tuple[str, ...]:
    """Effects of a case, such as 'slack + softening'; none of '' and 'cycles'."""
    return tuple(one for one in name.split(" + ") if one in EFFECTS or one in UNLISTED)


def machine(name: str, kind: int) -> Machine:
    """A test in which nothing is wrong but the compliance of its set-up."""
    cycled = name == "cycles" or any(one in CYCLED for one in parts(name))
    cycles = {"cycles": 3, "grows": True, "count": 1400} if cycled else {"count": 600}
    return Machine(**{**cycles, **KINDS[kind % len(KINDS)]})


@lru_cache(maxsize=100)
def factor(name: str, kind: int, place: float = 0.5, case: str = "") -> float:
    """Factor on the size of an effect that makes its distance 1, specimens together; `place`: where a step lies.

    `case`: the case whose machine it is planted in, that of the effect alone unless given.
    """
    planted, alone, _ = (EFFECTS | UNLISTED)[name]
    one = machine(case or name, kind)
    size = next(iter(planted))
    here = replace(one, **planted, slip_at=place)
    found = distance(replace(here, **{size: 0.0}), here, *RANGE) * (1.0 if alone else np.sqrt(3))
    return 1.0 / float(found)


def judged(name: str, d: float, seed: int, *, rigid: bool = False) -> Diagnosis:
    """Diagnosis of three specimens; `name` may be empty, or 'cycles': nothing is planted then.

    Two effects, 'slack + slip', have a distance each, of which d is one; the other is drawn between 12 and 60.
    """
    rng = np.random.default_rng(seed)
    base = machine(name, seed)
    of_one, of_all = {}, {}
    for number, each in enumerate(parts(name)):
        given, alone, _ = (EFFECTS | UNLISTED)[each]
        size = next(iter(given))
        place = rng.uniform(0.25, 0.75) if each in STEPS else 0.5
        far = d if number == 0 else 12.0 * 5.0 ** rng.uniform()
        planted = {**given, size: given[size] * far * factor(each, seed % len(KINDS), place, name)}
        (of_one if alone else of_all).update(planted)
        if each in STEPS:
            of_all["slip_at"] = place
    mountings = []
    chosen = int(rng.integers(3))
    for number in range(3):
        compliance = 0.0 if rigid else 2e-8 * (1 + 0.1 * rng.normal())
        one = replace(base, EA=2e6 * (1 + 0.004 * rng.normal()), compliance=compliance, **of_all)
        if number == chosen:
            one = replace(one, **of_one)
        read = pull(one, rng)
        length = Input("length", 0.1, (), "m")
        mountings.append(
            Mounting("abc"[number], read["force"], read["time"], read["crosshead"], (read["strain"],), length)
        )
    test = TensionTest("pull", tuple(mountings), Range("share", *RANGE))
    return tension(test, lines(test), rng=np.random.default_rng(0))


def outcome(name: str, found: Diagnosis, *, rigid: bool) -> str:
    """What was said of a case.

    'named', 'in its group' of `ALIKE`, 'in set', 'abstained', 'misnamed'; of two 'one named' as well; of nothing
    planted 'silent' or 'false'; of something unlisted 'abstained', 'silent', 'misnamed'.
    """
    planted = [one for one in parts(name) if one in EFFECTS]
    causes = {EFFECTS[one][2] for one in planted}
    right = (set() if rigid else {"setup"}) | causes
    # Softening of all specimens alike or of each by itself is softening.
    # A compliance that is the same in every mounting is one of the set-up all the same.
    alike = {"uneven curvature": "curvature", "constant setup": "setup"}
    named, possible = ({alike.get(one, one) for one in names} for names in (found.named, found.possible))
    if named < possible == right:
        named = possible
    if not parts(name):
        return "silent" if named <= right and found.verdict != "unexplained" else "false"
    if named - right:
        return "misnamed"
    if not planted:
        if possible - right:
            return "misnamed"
        return "silent" if found.verdict in ("nothing missing", "explained") else "abstained"
    if causes <= named:
        return "named"
    if not causes <= possible:
        return "one named" if causes & named else "abstained"
    return "in its group" if possible <= right.union(*(ALIKE.get(one, set()) for one in planted)) else "in set"


def further(first: int, each: int) -> Iterator[tuple[str, float, int, bool]]:
    """Pairs of effects, at d = 12 to 60 each, and unlisted ones, at d = 30 to 150: as `campaign`."""
    rng = np.random.default_rng(first)
    for row, (one, other) in enumerate(PAIRS):
        for at in range(each):
            d = 12.0 * 5.0 ** rng.uniform()
            yield f"{one} + {other}", d, first + 30_000 + 100 * row + at, at % 2 == 1
    for row, name in enumerate(UNLISTED):
        for at in range(2 * each):
            d = 30.0 * 5.0 ** rng.uniform()
            yield name, d, first + 40_000 + 100 * row + at, at % 2 == 1


def campaign(first: int, each: int, nothing: int) -> Iterator[tuple[str, float, int, bool]]:
    """Name, distance, seed and whether the set-up is rigid, of every test of a study."""
    for at in range(nothing):
        yield ("cycles" if at % 3 == 2 else ""), 0.0, first + at, at % 2 == 0
    for row, name in enumerate(EFFECTS):
        for at in range(each):
            for place, d in enumerate((10.0, 30.0)):
                yield name, d, first + 10_000 * (place + 1) + 100 * row + at, at % 2 == 1
