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
from functools import lru_cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from metrology.rig import closed, hooks, kernel, segments, series

log = logging.getLogger("metrology.rig")
_compiling = threading.Lock()
Kernel = Callable[..., None]


def _copy(
    module: ModuleType, wrap: Callable[[FunctionType], Any], instead: dict[str, Any] | None = None
) -> dict[str, Any]:
    """Copy a module with each function wrapped and calling the other copies, some of them replaced.

    Terms of effects come from files of their own, whose names they keep.
    """
    names: dict[str, Any] = dict(vars(module))
    for name, thing in vars(module).items():
        if isinstance(thing, FunctionType):
            own = thing.__module__ == module.__name__
            names[name] = wrap(FunctionType(thing.__code__, names, name, thing.__defaults__) if own else thing)
    names.update(instead or {})
    return names


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


_ready: dict[ModuleType, Kernel | None] = {}
_COSTS = {kernel: (1, "equation of motion", 30), closed: (2, "base model", 10), series: (2, "free motion", 15)}
"""Level of the compiler, what is compiled and how long it takes at most / s.

Higher levels cost more time to compile and gain nothing for the kernel, but for the long loops of the others.
"""


def _source(base: bool) -> ModuleType:
    return closed if base else kernel


def is_loaded(base: bool) -> bool:
    """Whether the compiled kernel, or the compiled closed form, was asked for before in this process."""
    return _source(base) in _ready


def compiled(base: bool = False) -> Kernel | None:
    """Return the compiled kernel (for `base` the closed form), from the cache if it is there; None if not to be had."""
    return _made(_source(base))


def compiled_series() -> Kernel | None:
    """Return the compiled power series of a free motion, as `compiled` does; None if not to be had."""
    return _made(series)


def _made(module: ModuleType) -> Kernel | None:
    if module in _ready:
        return _ready[module]
    with _compiling:
        if module not in _ready:
            _ready[module] = _load(module)
    return _ready[module]


def _load(module: ModuleType) -> Kernel | None:
    try:
        import numba
    except Exception as error:  # noqa: BLE001 - a broken installation raises anything; the others serve
        log.warning("numba cannot be used (%s); the rig runs without it, more slowly", error)
        return None
    folder = cache_folder(numba.__version__, module)
    with alone(folder):
        return _compile_into(folder, numba, module)


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


def _compile_into(folder: Path | None, numba: Any, module: ModuleType) -> Kernel | None:
    before, level = numba.config.CACHE_DIR, numba.config.OPT
    optimisation, what, most = _COSTS[module]
    numba.config.OPT = type(level)(optimisation)
    if folder is not None:
        numba.config.CACHE_DIR = str(folder)
    else:
        log.warning("no folder for the compiled rig can be written; it will be compiled again in the next process")
    entry = numba.njit(nogil=True, error_model="numpy", cache=folder is not None)
    inner = numba.njit(nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
    small = numba.njit(
        nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True
    )  # fmt: skip

    def wrap(function: FunctionType) -> Any:
        if function.__name__ == "march_many":
            return entry(function)
        return small(function) if hooks.is_small(function) else inner(function)

    try:
        march = _copy(module, wrap)["march_many"]
        if folder is None or not any(folder.rglob("*march_many*.nbi")):
            print(f"Compiling the rig's {what}, once: up to {most} s.", file=sys.stderr, flush=True)
        from metrology.rig.simulate import rehearse

        rehearse(march, module is closed, module is series)
        march.disable_compile()  # arrays of another kind are a fault of ours: to be told, not compiled for in silence
    except Exception as error:  # noqa: BLE001 - whatever the compiler trips over, the other engines serve
        log.warning("the rig could not be compiled (%s); it runs without, more slowly", error)
        return None
    finally:
        numba.config.CACHE_DIR, numba.config.OPT = before, level
    result: Kernel = march
    return result


def cache_folder(version: str, module: ModuleType = kernel) -> Path | None:
    """Folder for the compiled kernel, named by a hash of all that goes into it; None where none can be written.

    `METROLOGY_CACHE` names another place than the user's cache folder.
    """
    source = Path(kernel.__file__).read_bytes() + hooks.key()
    if module is not kernel:  # takes its constants from the kernel
        source += Path(str(module.__file__)).read_bytes()
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
