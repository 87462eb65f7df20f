"""A limit on address space (`ulimit -v`): too low a one is refused, before a library tries without end to get more."""

from __future__ import annotations

from importlib import import_module

from metrology.errors import Fault, MetrologyError

LEAST = 1 << 30
"""Bytes for the report of a small campaign, most of them mapped by libraries and never used."""


def require() -> None:
    """Refuse a limit below `LEAST`; under any other let OpenBLAS take its buffers while there is room.

    OpenBLAS asks again without end where 32 MiB are not to be had as it is loaded, and SciPy brings one of its own that
    would be loaded in mid-evaluation.

    Raises
    ------
    MetrologyError
        Where the limit is too low.
    """
    try:
        import resource
    except ImportError:  # no such limit on this system
        return
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return
    if limit < LEAST:
        got = f"a limit of {limit >> 20} MiB of address space"
        raise MetrologyError(Fault("ulimit -v", got, f"{LEAST >> 20} MiB at least", f"ulimit -v {LEAST >> 9}, or more"))
    import_module("scipy.linalg")
