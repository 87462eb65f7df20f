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
from typing import Any

from metrology.rig import closed, kernel, segments

log = logging.getLogger("metrology.rig")
_compiling = threading.Lock()
Kernel = Callable[..., None]


def _copy(
    module: ModuleType, wrap: Callable[[FunctionType], Any], instead: dict[str, Any] | None = None
) -> dict[str, Any]:
    """Copy a module with each function wrapped and calling the other copies, some of them replaced."""
    names: dict[str, Any] = dict(vars(module))
    for name, thing in vars(module).items():
        if isinstance(thing, FunctionType):
            names[name] = wrap(FunctionType(thing.__code__, names, name, thing.__defaults__))
    names.update(instead or {})
    return names


def _allocating(module: ModuleType) -> set[str]:
    """Names of the functions that make arrays, by themselves or by those that they call."""
    calls = {name: set(thing.__code__.co_names) for name, thing in vars(module).items() if isinstance(thing, FunctionType)}
    found, before = {"zeros", "empty"}, 0
    while len(found) > before:
        before = len(found)
        found |= {name for name, used in calls.items() if used & found}
    return found


@lru_cache(maxsize=1)
def interpreted() -> Kernel:
    """Return the kernel as it stands: slow, needs nothing."""
    return kernel.march_many


@lru_cache(maxsize=2)
def numpy(base: bool = False) -> Kernel:
    """Return the kernel with its linear segments vectorised by NumPy, or the closed form of the `base` model so."""
    if base:
        march: Kernel = _copy(closed, lambda function: function, {"write": segments.write})["march_many"]
    else:
        march = _copy(kernel, lambda function: function, {"linear_leg": segments.linear_leg})["march_many"]
    return march


_ready: dict[bool, Kernel | None] = {}


def is_loaded(base: bool) -> bool:
    """Whether the compiled kernel, or the compiled closed form, was asked for before in this process."""
    return base in _ready


def compiled(base: bool = False) -> Kernel | None:
    """Return the compiled kernel (for `base` the closed form), from the cache if it is there; None if not to be had."""
    if base in _ready:
        return _ready[base]
    with _compiling:
        if base not in _ready:
            _ready[base] = _load(base)
    return _ready[base]


def _load(base: bool) -> Kernel | None:
    try:
        import numba
    except Exception as error:  # noqa: BLE001 - a broken installation raises anything; the others serve
        log.warning("numba cannot be used (%s); the rig runs without it, more slowly", error)
        return None
    return _compile(numba, base)


def _compile(numba: Any, base: bool) -> Kernel | None:
    folder = cache_folder(numba.__version__, base)
    with alone(folder):
        return _compile_into(folder, numba, base)


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


def _compile_into(folder: Path | None, numba: Any, base: bool) -> Kernel | None:
    before, level = numba.config.CACHE_DIR, numba.config.OPT
    # Higher levels cost more time to compile and gain nothing here, but for the long loops of the closed form.
    numba.config.OPT = type(level)(2 if base else 1)
    if folder is not None:
        numba.config.CACHE_DIR = str(folder)
    else:
        log.warning("no folder for the compiled rig can be written; it will be compiled again in the next process")
    entry = numba.njit(nogil=True, error_model="numpy", cache=folder is not None)
    inner = partial(numba.njit, nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
    module = closed if base else kernel
    # Counting who holds an array costs most of a short function's time; what makes no array needs no count.
    counts = {True: inner(), False: inner(_nrt=False)}
    making = _allocating(module)
    try:
        march = _copy(
            module,
            lambda function: entry(function)
            if function.__name__ == "march_many"
            else counts[function.__name__ in making](function),
        )["march_many"]
        if folder is None or not any(folder.rglob("*march_many*.nbi")):
            what, most = ("base model", 10) if base else ("equation of motion", 30)
            print(f"Compiling the rig's {what}, once: up to {most} s.", file=sys.stderr, flush=True)
        from metrology.rig.simulate import rehearse

        rehearse(march, base)
        march.disable_compile()  # arrays of another kind are a fault of ours: to be told, not compiled for in silence
    except Exception as error:  # noqa: BLE001 - whatever the compiler trips over, the other engines serve
        log.warning("the rig could not be compiled (%s); it runs without, more slowly", error)
        return None
    finally:
        numba.config.CACHE_DIR, numba.config.OPT = before, level
    result: Kernel = march
    return result


def cache_folder(version: str, base: bool = False) -> Path | None:
    """Folder for the compiled kernel, named by a hash of all that goes into it; None where none can be written.

    `METROLOGY_CACHE` names another place than the user's cache folder.
    """
    source = Path(kernel.__file__).read_bytes()
    if base:  # takes its constants from the kernel
        source += Path(closed.__file__).read_bytes()
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
