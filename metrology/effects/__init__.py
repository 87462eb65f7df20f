"""Every effect that the package knows: one file each, found by itself; a file here with an ``EFFECT`` is enough.

An effect's file holds all there is to say of it (`metrology.effect.Effect`): parameters with unit, null and range, what
it adds to the motion or to a reading, and for each method that tries it as a cause words, pictures and first sizes.
What is missing is an error at import that names the file, the field and what belongs there.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from types import ModuleType

from metrology.effect import PICTURES, Cause, Effect
from metrology.effect.whole import faults
from metrology.errors import Fault, MetrologyError


def read(module: ModuleType) -> Effect:
    """Effect that a file declares.

    Raises
    ------
    MetrologyError
        With one fault for everything that is missing.
    """
    file, stem = str(module.__file__), module.__name__.rpartition(".")[2]
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, Effect):
        raise MetrologyError(Fault(file, "no effect", "EFFECT = Effect(…), as in the other files of its folder"))
    found = list(faults(effect, file))
    if effect.name != stem:
        found.append(Fault(f"{file}: name", f"'{effect.name}'", f"'{stem}', as the file is named"))
    if found:
        raise MetrologyError(*found)
    return effect


def _discovered() -> tuple[Effect, ...]:
    names = sorted(one.name for one in pkgutil.iter_modules(__path__))
    effects = [read(importlib.import_module(f"{__name__}.{name}")) for name in names]
    found = [*_twice(effects), *_beside_nothing(effects)]
    if found:
        raise MetrologyError(*found)
    # What acts on readings alone comes last: another one then leaves the places of all that the motion knows.
    return tuple(sorted(effects, key=lambda one: (bool(one.readings) or not one.parameters, one.name)))


def _beside_nothing(effects: list[Effect]) -> Iterator[Fault]:
    every = [(effect, cause) for effect in effects for cause in effect.causes]
    known = {(cause.method, cause.name) for _, cause in every}
    for effect, cause in every:
        if cause.beside and (cause.method, cause.beside) not in known:
            yield Fault(
                f"{effect.name}.py: causes",
                f"to be tried with '{cause.beside}'",
                f"the name of a cause of '{cause.method}'",
            )


def _twice(effects: list[Effect]) -> Iterator[Fault]:
    seen: dict[tuple[str, str], str] = {}
    for effect in effects:
        for cause in effect.causes:
            key = (cause.method, cause.name)
            if key in seen:
                got = f"'{cause.name}', as in {seen[key]}.py"
                yield Fault(f"{effect.name}.py: causes", got, f"a name that no other cause of '{cause.method}' has")
            seen[key] = effect.name


EFFECTS: tuple[Effect, ...] = _discovered()
"""Every effect, in the order in which the equation of motion takes their parameters."""


def causes(method: str) -> list[tuple[Effect, Cause]]:
    """What one method tries, with the effects behind."""
    return [(effect, cause) for effect in EFFECTS for cause in effect.causes if cause.method == method]


def shown() -> dict[str, tuple[str, ...]]:
    """Picture → the causes that it shows best, whatever the method."""
    found = [cause for one in EFFECTS for cause in one.causes]
    return {
        picture: tuple(dict.fromkeys(cause.name for cause in found if picture in cause.pictures))
        for picture in PICTURES
        if picture != PICTURES[-1]
    }
