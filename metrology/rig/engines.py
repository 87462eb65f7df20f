"""Ways to run the kernel and the closed form of the base model: compiled, with NumPy alone, and as plain Python."""

from __future__ import annotations

import hashlib
import logging
import os
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from metrology.rig import base_samples, closed, hooks, kernel, segments, tangent, taut_and_free
from metrology.rig.kernel.march import march_many

log = logging.getLogger("metrology.rig")
_compiling = threading.Lock()
Kernel = Callable[..., None]


class Program(NamedTuple):
    """A function that is compiled, of modules of which the later ones use the earlier ones'."""

    modules: tuple[ModuleType, ...]
    entry: str
    words: str
    level: int


WITHIN = {"tension", "pull", "stretch", "net_force"}
"""Functions that are written into the equation of motion: to hand them their arrays takes longer than what they do."""
BASE = (taut_and_free, closed)
"""Modules of the base model in closed form."""
PROGRAMS = {
    # Higher levels cost more time to compile and gain nothing here, but for the long loops of the closed form.
    "base": Program(BASE, "march_many", "base model", 2),
    "kernel": Program(kernel.MODULES + tangent.MODULES, "march_many", "equation of motion", 1),
    "tangent": Program(kernel.MODULES + tangent.MODULES, "trace", "derivatives", 1),
}


def _copy(
    modules: tuple[ModuleType, ...], wrap: Callable[[FunctionType], Any], instead: dict[str, Any] | None = None
) -> dict[str, Any]:
    """Copy modules into one, each function wrapped and calling the other copies, some of them replaced.

    Terms of effects come from files of their own, whose names they keep.
    """
    names: dict[str, Any] = {}
    for module in modules:
        names.update(vars(module))
    homes = {module.__name__ for module in modules}
    for name, thing in list(names.items()):
        if isinstance(thing, FunctionType):
            own = thing.__module__ in homes
            names[name] = wrap(FunctionType(thing.__code__, names, name, thing.__defaults__) if own else thing)
    names.update(instead or {})
    return names


def _allocating(modules: tuple[ModuleType, ...]) -> set[str]:
    """Names of the functions that make arrays, by themselves or by those that they call."""
    things = {name: thing for module in modules for name, thing in vars(module).items()}
    calls = {name: set(thing.__code__.co_names) for name, thing in things.items() if isinstance(thing, FunctionType)}
    found, before = {"zeros", "empty", "full"}, 0
    while len(found) > before:
        before = len(found)
        found |= {name for name, used in calls.items() if used & found}
    return found


@lru_cache(maxsize=1)
def interpreted() -> Kernel:
    """Return the kernel as it stands: slow, needs nothing."""
    return march_many


@lru_cache(maxsize=2)
def numpy(base: bool = False) -> Kernel:
    """Return the kernel with its linear segments vectorised by NumPy, or the closed form of the `base` model so."""
    modules, instead = (
        (BASE, {"write": base_samples.write}) if base else (kernel.MODULES, {"linear_leg": segments.linear_leg})
    )
    march: Kernel = _copy(modules, lambda function: function, instead)["march_many"]
    return march


_ready: dict[str, Kernel | None] = {}


def _name(base: bool) -> str:
    return "base" if base else "kernel"


def is_loaded(base: bool) -> bool:
    """Whether the compiled kernel, or the compiled closed form, was asked for before in this process."""
    return _name(base) in _ready


def compiled(base: bool = False) -> Kernel | None:
    """Return the compiled kernel (for `base` the closed form), from the cache if it is there; None if not to be had.

    Parameters
    ----------
    base : bool
        The closed form of the base model in place of the kernel.

    Returns
    -------
    callable or None
        The kernel.
    """
    return loaded(_name(base))


def loaded(name: str) -> Kernel | None:
    """Return a compiled program of `PROGRAMS`, from the cache if it is there; None if not to be had."""
    if name in _ready:
        return _ready[name]
    with _compiling:
        if name not in _ready:
            _ready[name] = _load(PROGRAMS[name])
    return _ready[name]


def _load(program: Program) -> Kernel | None:
    try:
        import numba
    except Exception as error:  # noqa: BLE001 - a broken installation raises anything; the others serve
        log.warning("numba cannot be used (%s); the rig runs without it, more slowly", error)
        return None
    folder = cache_folder(numba.__version__, program.modules)
    with alone(folder):
        return _compile_into(folder, numba, program)


@contextmanager
def alone(folder: Path | None) -> Iterator[None]:
    """Let one process at a time work in the folder, so that the others wait and then load what it made."""
    if folder is None:
        yield
        return
    with (folder / "lock").open("w") as lock:
        try:
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX)
        except (ImportError, OSError):  # no locks on this system or file system: to compile twice is only slower
            log.debug("the folder %s cannot be locked", folder)
        yield  # closing the file gives the lock back


def _compile_into(folder: Path | None, numba: Any, program: Program) -> Kernel | None:
    before, level = numba.config.CACHE_DIR, numba.config.OPT
    numba.config.OPT = type(level)(program.level)
    if folder is not None:
        numba.config.CACHE_DIR = str(folder)
    else:
        log.warning("no folder for the compiled rig can be written; it will be compiled again in the next process")
    try:
        compiled: Kernel = _compilable(program.modules, folder is not None)[program.entry]
        if folder is None or not any(folder.rglob(f"*{program.entry}*.nbi")):
            print(f"Compiling the rig's {program.words}, once: up to 30 s.", file=sys.stderr, flush=True)
        _rehearse(compiled, program)
        compiled.disable_compile()  # type: ignore[attr-defined] # arrays of another kind are a fault of ours
    except Exception as error:  # noqa: BLE001 - whatever the compiler trips over, the other engines serve
        log.warning("the rig could not be compiled (%s); it runs without, more slowly", error)
        return None
    finally:
        numba.config.CACHE_DIR, numba.config.OPT = before, level
    return compiled


@lru_cache
def _compilable(modules: tuple[ModuleType, ...], cached: bool) -> dict[str, Any]:
    """Copy of the modules for the compiler: what two programs share is compiled once in a process."""
    import numba

    entry = numba.njit(nogil=True, error_model="numpy", cache=cached)
    inner = partial(numba.njit, nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
    # Counting who holds an array costs most of a short function's time; what makes no array needs no count.
    counts, making = {True: inner(), False: inner(_nrt=False)}, _allocating(modules)
    entries = {one.entry for one in PROGRAMS.values()}

    def wrap(function: FunctionType) -> Any:
        if function.__name__ in entries:
            return entry(function)
        if hooks.is_small(function) or function.__name__ in WITHIN:
            return inner(_nrt=False, forceinline=True)(function)
        return counts[function.__name__ in making](function)

    return _copy(modules, wrap)


def _rehearse(compiled: Kernel, program: Program) -> None:
    """Run something short, so that a program is compiled and known to work."""
    from metrology.rig.model import Rig
    from metrology.rig.packing import pack
    from metrology.rig.run import Run
    from metrology.rig.sensitivity import follow
    from metrology.rig.simulate import march_rows

    rig, run = Rig(1.0, 4.0), Run.sampled([0.0, 1.0], -0.1, 0.1)
    if program.entry == "trace":
        follow(rig, run, ("k",), (march_many, compiled))
    else:
        vectors = np.array(rig.vector(), ndmin=2)
        march_rows(compiled, pack(rig, run, vectors), vectors, closed in program.modules)


def cache_folder(version: str, modules: tuple[ModuleType, ...] = kernel.MODULES) -> Path | None:
    """Folder for the compiled modules, named by a hash of all that goes into them; None where none can be written.

    `METROLOGY_CACHE` names another place than the user's cache folder.
    """
    # All of them take their constants from the kernel's layout; what is compiled hangs on how it is done, too.
    files = [str(kernel.layout.__file__), *(str(module.__file__) for module in modules), __file__]
    source = hooks.key() + b"".join(Path(file).read_bytes() for file in files)
    key = hashlib.sha256(source + version.encode() + sys.version.encode()).hexdigest()[:16]
    named = os.environ.get("METROLOGY_CACHE") or os.environ.get("XDG_CACHE_HOME")
    caches = Path(named) if named else Path.home() / ".cache"
    folder = caches / "metrology" / f"rig-{key}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return None
