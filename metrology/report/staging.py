"""Files that appear together or not at all: staged beside their folder, then exchanged with it in one step.

One lock guards a folder and every file in it: that of the folder above. It falls with the process that holds it.
"""

from __future__ import annotations

import glob
import os
import shutil
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from metrology.errors import Fault, MetrologyError, own_text
from metrology.report.exchange import exchange

_STAGED, _OLD = ".staged-", ".old-"


def replace_folder(
    folder: Path,
    files: Mapping[str, bytes],
    *,
    gone: Collection[str] = (),
    settle: Callable[[], Mapping[str, bytes]] = dict,
) -> None:
    """Make `folder` hold `files`, all of them from this call; what else lay in it stays, but for names in `gone`.

    The files are written to a hidden folder beside it, which then takes its place in one step. A run that dies on the
    way leaves the older report whole; what it left behind is cleaned up by the next. Runs at once stage their own.

    Parameters
    ----------
    folder : Path
        Made where it is missing.
    files : mapping of str to bytes
        Content by name.
    gone : collection of str
        Names of older files that do not stay.
    settle : callable
        Asked at last, when nobody else changes the folder any more: files that take the place of those in `files`, or
        join them, as what lies in the folder demands it. It may raise, and nothing is changed.

    Raises
    ------
    MetrologyError
        Where the folder cannot be written: full, read-only, or a file of that name in the way.
    """
    try:
        folder = folder.resolve()
        folder.parent.mkdir(parents=True, exist_ok=True)
        # Where the system cannot exchange, there is no folder for a moment: it is looked at under the lock only.
        with _locked(folder.parent):
            _refuse_protected(folder)
            _refuse_folders(folder, files)
        with _staging(folder) as staged:
            _fill(staged, files)
            with _locked(folder.parent):
                settled = settle()
                _fill(staged, settled)
                _carry_over(staged, folder, {*files, *settled, *gone})
                _swap(staged, folder)
    except OSError as error:
        raise MetrologyError(_fault(folder, error)) from error


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the folder of a file, so that nobody else replaces the file or the folder meanwhile.

    Raises
    ------
    MetrologyError
        Where there is no such folder.
    """
    try:
        with _locked(path.resolve().parent.parent):
            yield
    except OSError as error:
        raise MetrologyError(_fault(path.parent, error)) from error


def replace_file(path: Path, content: bytes) -> None:
    """Put `content` in the place of a file, or where there is none, at once: a run that dies leaves the older whole.

    Folders above it are made where they are missing.

    Raises
    ------
    MetrologyError
        Where it cannot be written.
    """
    path = path.resolve()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        mode = path.stat().st_mode & 0o7777 if path.exists() else 0o644
        if not mode & 0o222 or not path.parent.stat().st_mode & 0o222:
            raise PermissionError(13, "write-protected", str(path))
        with _staging_file(path) as staged:
            staged.write_bytes(content)
            _sync(staged)
            staged.chmod(mode)
            staged.replace(path)
        _sync(path.parent)
    except OSError as error:
        raise MetrologyError(_fault(path.parent, error)) from error


def _fault(folder: Path, error: OSError) -> Fault:
    return Fault(
        str(folder),
        f"{own_text(error)} ({error.filename or folder.parent})",
        "a folder that can be written, with room for the report",
        "free space, lift the write protection (chmod u+w), or choose another place; what was there before is whole",
    )


def _refuse_protected(folder: Path) -> None:
    """Refuse a folder closed on purpose: renaming it away would walk around that, root even more so."""
    for place in (folder, folder.parent):
        if place.is_dir() and not place.stat().st_mode & 0o222:
            raise PermissionError(13, "write-protected folder", str(place))
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(20, "a file is where the report's folder should be", str(folder))


def _refuse_folders(folder: Path, files: Iterable[str]) -> None:
    """Refuse where a folder has the name of a file to be written: what the user keeps in it would be lost."""
    for name in files:
        if (folder / name).is_dir():
            raise IsADirectoryError(21, "a folder has the name of a file of the report", str(folder / name))


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder: nobody else cleans or swaps in it. It falls with the process, however that ends."""
    handle = _hold(folder)
    try:
        yield
    finally:
        os.close(handle)


def _hold(path: Path) -> int:
    """Wait for the lock of a file or folder, and return the handle that keeps it."""
    import fcntl

    handle = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
    except BaseException:
        os.close(handle)
        raise
    return handle


@contextmanager
def _staging(folder: Path) -> Iterator[Path]:
    """A hidden folder beside `folder`, locked while this run lives, so that others can tell it from a leftover."""
    with _locked(folder.parent):
        _clean(folder)
        staged = Path(tempfile.mkdtemp(prefix=_prefix(folder.name), dir=folder.parent))
        handle = _hold(staged)
    try:
        yield staged
    finally:
        os.close(handle)
        shutil.rmtree(staged, ignore_errors=True)


@contextmanager
def _staging_file(path: Path) -> Iterator[Path]:
    """Likewise a hidden file."""
    with _locked(path.parent):
        for staged in path.parent.glob(f"{glob.escape(_prefix(path.name))}*"):
            if _abandoned(staged):
                staged.unlink(missing_ok=True)
        handle, name = tempfile.mkstemp(prefix=_prefix(path.name), dir=path.parent)
        os.close(handle)
        staged = Path(name)
        handle = _hold(staged)
    try:
        yield staged
    finally:
        os.close(handle)
        staged.unlink(missing_ok=True)


def _prefix(name: str) -> str:
    """What the names of staged files and folders begin with."""
    return f".{name}{_STAGED}"


def _clean(folder: Path) -> None:
    """Remove what killed runs left; where one died between two renamings, put the old report back."""
    for old in sorted(folder.parent.glob(f".{glob.escape(folder.name)}{_OLD}*")):
        if folder.exists():
            shutil.rmtree(old, ignore_errors=True)
        else:
            old.rename(folder)
    for staged in folder.parent.glob(f"{glob.escape(_prefix(folder.name))}*"):
        if _abandoned(staged):
            shutil.rmtree(staged, ignore_errors=True)


def _abandoned(staged: Path) -> bool:
    """Whether no living run holds it; one that was just removed needs no cleaning."""
    import fcntl

    try:
        handle = os.open(staged, os.O_RDONLY)
    except FileNotFoundError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    finally:
        os.close(handle)
    return True


def _fill(staged: Path, files: Mapping[str, bytes]) -> None:
    for name, content in files.items():
        (staged / name).write_bytes(content)
        _sync(staged / name)


def _sync(path: Path) -> None:
    """Wait until a file's content, or a folder's list of names, is on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _carry_over(staged: Path, folder: Path, without: Collection[str]) -> None:
    """Give the staged folder the permissions of the older report, and what lies beside its files."""
    staged.chmod((folder.stat().st_mode & 0o7777) if folder.is_dir() else 0o755)
    leftovers = tuple(_prefix(name) for name in without)
    for other in sorted(folder.iterdir()) if folder.is_dir() else ():
        if other.name not in without and not other.name.startswith(leftovers):
            _keep(other, staged / other.name)
    _sync(staged)


def _keep(other: Path, place: Path) -> None:
    """Carry over what the user put beside an older report."""
    if other.is_dir() and not other.is_symlink():
        shutil.copytree(other, place, symlinks=True)
    else:
        shutil.copy2(other, place, follow_symlinks=False)


def _swap(staged: Path, folder: Path) -> None:
    if not folder.exists():
        staged.rename(folder)
    elif not exchange(staged, folder):
        _rename_twice(staged, folder)
    _sync(folder.parent)


def _rename_twice(staged: Path, folder: Path) -> None:
    """Where two folders cannot be exchanged: the next run puts back what one leaves that dies in between."""
    old = folder.with_name(staged.name.replace(_STAGED, _OLD))
    folder.rename(old)
    try:
        staged.rename(folder)
    except OSError:
        old.rename(folder)
        raise
    shutil.rmtree(old, ignore_errors=True)
