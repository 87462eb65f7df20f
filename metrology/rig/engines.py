"""Three ways to run the kernel: compiled, with vectorised NumPy segments, and as plain Python."""

from __future__ import annotations

import hashlib
import logging
import os
import sys
import tempfile
import threading
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any

from metrology.rig import kernel, segments

log = logging.getLogger("metrology.rig")
_compiling = threading.Lock()
Kernel = Callable[..., None]


def _copy(wrap: Callable[[FunctionType], Any], instead: dict[str, Any] | None = None) -> dict[str, Any]:
    """Copy the kernel with each function wrapped and calling the other copies, some of them replaced."""
    names: dict[str, Any] = dict(vars(kernel))
    for name, thing in vars(kernel).items():
        if isinstance(thing, FunctionType):
            names[name] = wrap(FunctionType(thing.__code__, names, name, thing.__defaults__))
    names.update(instead or {})
    return names


@lru_cache(maxsize=1)
def interpreted() -> Kernel:
    """Return the kernel as it stands: slow, needs nothing."""
    return kernel.march_many


@lru_cache(maxsize=1)
def numpy() -> Kernel:
    """Return the kernel with its linear segments vectorised by NumPy: fast where the equation is linear."""
    march: Kernel = _copy(lambda function: function, {"linear_leg": segments.linear_leg})["march_many"]
    return march


@lru_cache(maxsize=1)
def compiled() -> Kernel | None:
    """Return the compiled kernel, from the cache where it is there; None where it cannot be had."""
    with _compiling:
        try:
            import numba
        except Exception as error:  # noqa: BLE001 - a broken installation raises anything; the others serve
            log.warning("numba cannot be used (%s); the rig runs without it, more slowly", error)
            return None
        return _compile(numba)


def _compile(numba: Any) -> Kernel | None:
    folder = cache_folder(numba.__version__)
    before = numba.config.CACHE_DIR
    if folder is not None:
        numba.config.CACHE_DIR = str(folder)
    else:
        log.warning("no folder for the compiled rig can be written; it will be compiled again in the next process")
    entry = numba.njit(nogil=True, error_model="numpy", cache=folder is not None)
    inner = numba.njit(nogil=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
    try:
        march = _copy(lambda function: entry(function) if function.__name__ == "march_many" else inner(function))[
            "march_many"
        ]
        if folder is None or not any(folder.rglob("*march_many*.nbi")):
            print("Compiling the rig's equation of motion, once: up to 30 s.", file=sys.stderr, flush=True)
        from metrology.rig.simulate import rehearse

        rehearse(march)
    except Exception as error:  # noqa: BLE001 - whatever the compiler trips over, the other engines serve
        log.warning("the rig could not be compiled (%s); it runs without, more slowly", error)
        return None
    finally:
        numba.config.CACHE_DIR = before
    result: Kernel = march
    return result


def cache_folder(version: str) -> Path | None:
    """Folder for the compiled kernel, named by a hash of all that goes into it; None where none can be written.

    `METROLOGY_CACHE` names another place than the user's cache folder.
    """
    source = Path(kernel.__file__).read_bytes()
    key = hashlib.sha256(source + version.encode() + sys.version.encode()).hexdigest()[:16]
    named = os.environ.get("METROLOGY_CACHE") or os.environ.get("XDG_CACHE_HOME")
    base = Path(named) if named else Path.home() / ".cache"
    folder = base / "metrology" / f"rig-{key}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return None
