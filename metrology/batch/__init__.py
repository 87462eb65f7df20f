"""All campaigns below a folder: those that are up to date are left alone, the others go through an executor.

An executor is one in the sense of `concurrent.futures`: processes of this machine, or a Dask cluster. A campaign
travels to its worker as bytes and its report comes back as bytes, so that a worker needs no disk in common with this
machine, and every report is written here, in the one place that knows how to write it whole.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from pathlib import Path

from metrology.batch import bundle, outcome, stamp
from metrology.batch.bundle import Bundle
from metrology.batch.job import Made, work
from metrology.batch.outcome import Outcome
from metrology.batch.workers import WorkerDiedError, Workers
from metrology.errors import Fault, MetrologyError

__all__ = ["Outcome", "Workers", "find", "make"]

Progress = Callable[[str], None]
PATIENCE = 10
"""How often to see whether the workers can still be reached while none of them is done, s."""


def find(folder: Path) -> list[Path]:
    """Return every `campaign.yaml` below `folder`, in the order of their paths; hidden folders are passed over.

    Raises
    ------
    MetrologyError
        Where there is no such folder, or no campaign in it.
    """
    if not folder.is_dir():
        raise MetrologyError(Fault(str(folder), "no folder", "a folder with campaigns below it"))
    # By name: a link to a file that is gone is a campaign too, of which the table says so.
    homes = (Path(home) for home, folders, files in os.walk(folder) if "campaign.yaml" in (*folders, *files))
    found = sorted(home / "campaign.yaml" for home in homes if not _hidden(home.relative_to(folder)))
    if not found:
        raise MetrologyError(Fault(str(folder), "no campaign.yaml at any depth", "a folder with campaigns below it"))
    return found


def _hidden(path: Path) -> bool:
    return any(part.startswith(".") for part in path.parts)


def make(
    paths: Sequence[Path],
    output: Path,
    workers: Workers,
    *,
    allow_code: bool = False,
    progress: Progress = lambda _text: None,
) -> list[Outcome]:
    """Make the report of every campaign that is not up to date; one that fails does not stop the others.

    Same campaigns, same reports to the last bit, whatever the workers, their number and the order in which they end.

    Parameters
    ----------
    paths : sequence of Path
        Campaign files, as `find` returns them.
    output : Path
        Folder in which each report gets a folder of the campaign's id.
    workers : Workers
        Where the campaigns are evaluated.
    allow_code : bool
        Whether Python files that campaigns name may be run there.
    progress : callable
        Told how many are done.

    Returns
    -------
    list of Outcome
        One for each path, in their order.
    """
    desk = _Desk(output, len(paths), progress)
    running: dict[Future[Made], Bundle] = {}
    for packed in desk.stale(paths):
        # No more at once than keeps all workers busy: what waits, and what comes back, must fit into memory.
        while running and len(running) >= workers.width():
            _take(running, workers, desk)
        future = _submitted(packed, workers, allow_code=allow_code)
        if future is None:
            desk.lose(packed)
        else:
            running[future] = packed
    while running:
        _take(running, workers, desk)
    return [desk.outcomes[path] for path in paths]


def _submitted(packed: Bundle, workers: Workers, *, allow_code: bool) -> Future[Made] | None:
    """Hand out a campaign; None where no workers can be reached, also where they are lost in this very moment."""
    if not workers.width():
        return None
    try:
        return workers.executor.submit(work, packed, stamp.code(), allow_code=allow_code)
    except Exception:
        if workers.width():
            raise
        return None


def _take(running: dict[Future[Made], Bundle], workers: Workers, desk: _Desk) -> None:
    """Take in what is done; give up what is under way where no workers can be reached any more."""
    done = wait(running, timeout=PATIENCE, return_when=FIRST_COMPLETED).done
    for future in done:
        desk.enter(running.pop(future), future)
    if not done and not workers.width():
        for packed in running.values():
            desk.lose(packed)
        running.clear()


@dataclass
class _Desk:
    """Where campaigns are handed out and reports come in."""

    output: Path
    total: int
    progress: Progress

    def __post_init__(self) -> None:
        self.outcomes: dict[Path, Outcome] = {}
        self._homes: dict[str, Path] = {}

    def stale(self, paths: Sequence[Path]) -> Iterator[Bundle]:
        """Yield the campaigns that are to be made, and enter those that need or can not."""
        for path in paths:
            try:
                packed = bundle.pack(path, self.output)
                self._refuse_same(packed.identity, path)
            except MetrologyError as error:
                self._note(outcome.refused(path, "", error.faults, self.output))
                continue
            standing = self._standing(packed)
            if standing is None:
                yield packed
            else:
                self._note(standing)

    def _standing(self, packed: Bundle) -> Outcome | None:
        """Return the outcome of a campaign whose report is up to date."""
        folder = self.output / packed.identity
        if not packed.identity or not stamp.fresh(folder, stamp.key(packed)):
            return None
        return outcome.done(packed.path, "up to date", (folder / "results.json").read_bytes())

    def _refuse_same(self, identity: str, path: Path) -> None:
        """Refuse a second campaign of one id, whose report would take the place of the first's."""
        first = self._homes.setdefault(identity, path) if identity else path
        if first != path:
            got = f"{identity!r}, the id of {first} too"
            raise MetrologyError(Fault(f"{path} id", got, "an id of its own, as reports go to its folder"))

    def enter(self, packed: Bundle, future: Future[Made]) -> None:
        """Write what a worker made of a campaign, or note why it made nothing."""
        self._note(self._entered(packed, future))

    def _entered(self, packed: Bundle, future: Future[Made]) -> Outcome:
        from metrology import report

        path, identity = packed.path, packed.identity
        if (error := _error(future)) is not None:
            return outcome.refused(path, identity, [error], self.output)
        made = future.result()
        if made.faults:
            return outcome.refused(path, identity, made.faults, self.output)
        try:
            news = stamp.changed(self.output / identity, made.files)
            files = {**made.files, stamp.NAME: stamp.text(stamp.key(packed), made.files, news)}
            report.place(files, self.output / identity, command="batch", campaign=packed.path)
        except MetrologyError as fault:
            return outcome.refused(path, identity, fault.faults, self.output)
        return outcome.done(path, "made", made.files["results.json"])

    def lose(self, packed: Bundle) -> None:
        """Note that a campaign found nobody to make it."""
        reason = "its scheduler cannot be reached any more: start it again, and the batch"
        self._note(outcome.refused(packed.path, packed.identity, [reason], self.output))

    def _note(self, one: Outcome) -> None:
        self.outcomes[one.path] = one
        failed = sum(entry.state == "not made" for entry in self.outcomes.values())
        self.progress(f"{len(self.outcomes)} of {self.total} done, {failed} not made; last {one.path.parent.name}")


def _error(future: Future[Made]) -> str | None:
    """What went wrong outside the campaign: a worker that died, or an error of the program itself."""
    if future.cancelled():
        return "given up by its scheduler: see whether that still runs"
    error = future.exception()
    if error is None:
        return None
    text = " ".join(str(error).split())
    return text if isinstance(error, WorkerDiedError) else f"{type(error).__name__}: {text}"
