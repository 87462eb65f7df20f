"""What a worker does: one campaign from its bytes to the bytes of its report."""

from __future__ import annotations

import gc
import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from metrology.batch import bundle, card, stamp
from metrology.batch.bundle import Bundle
from metrology.errors import Fault, MetrologyError

_ALONE = threading.Lock()
"""One campaign at a time in a process: drawing and laying out keep their state in the process."""
THREADS = "OPENBLAS_NUM_THREADS"


@dataclass(frozen=True)
class Made:
    """The files of a report, or the faults for which there is none."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    faults: tuple[Fault, ...] = ()


def work(packed: Bundle, code: str, *, allow_code: bool = False) -> Made:
    """Evaluate a campaign and return its report; a campaign that cannot be evaluated gives its faults.

    Parameters
    ----------
    packed : Bundle
        The campaign.
    code : str
        What `stamp.code` says where the campaign comes from; a worker of other code refuses the work.
    allow_code : bool
        Whether Python files that the campaign names may be run.
    """
    with _ALONE, bundle.unpacked(packed) as root:
        try:
            _refuse_other(code)
            return Made(_report(packed, root, allow_code=allow_code))
        except MetrologyError as error:
            return Made(faults=tuple(_named(packed, root, fault) for fault in error.faults))
        finally:
            # Drawing leaves circles of 20 000 objects a campaign, which Python itself collects ever more seldom as a
            # process holds more, and one of Dask's more seldom still.
            gc.collect()


def _report(packed: Bundle, root: Path, *, allow_code: bool) -> dict[str, bytes]:
    from metrology import chain, report
    from metrology.campaign.load import load
    from metrology.campaign.sources import read_sources
    from metrology.chain.diagnosis import extended

    campaign = load(root / packed.place, allow_code=allow_code)
    findings, traces = chain.traced(campaign)
    further = extended(campaign, findings, root / packed.home)
    made = report.make(findings, sources=read_sources(campaign), traces=traces)
    return {**made, **further, card.NAME: card.to_json(card.make(findings))}


def _refuse_other(code: str) -> None:
    """Refuse what would give other last bits than the machine that the campaign comes from."""
    import socket

    where = f"worker on {socket.gethostname()}"
    if stamp.code() != code:
        got, expected = "other code, templates or libraries", "those of the machine that gives out the work"
        raise MetrologyError(Fault(where, got, expected, "install the same version from the same lock file"))
    if os.environ.get(THREADS) != "1":
        got = f"{THREADS}={os.environ.get(THREADS, '')}"
        raise MetrologyError(Fault(where, got, f"{THREADS}=1", "set it before the worker starts"))


def _named(packed: Bundle, root: Path, fault: Fault) -> Fault:
    return replace(fault, where=bundle.named(packed, root, fault.where), got=bundle.named(packed, root, fault.got))
