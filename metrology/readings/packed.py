"""Files as they are stored: of a bounded size, gzipped or in an archive, opened in memory and never on disk."""

from __future__ import annotations

import gzip
import lzma
import re
import zipfile
import zlib
from io import BytesIO
from pathlib import Path

from metrology.errors import MetrologyError
from metrology.readings.sheet import STATE, SeveralPartsError, refused
from metrology.units.dimensions import quoted

MAX_BYTES = 64 * 1024 * 1024
MAX_MEMBERS = 2000
_OF_THE_SYSTEM = re.compile(r"__MACOSX/|(?:.*/)?(?:\._[^/]*|\.DS_Store|Thumbs\.db|desktop\.ini)$")
"""What macOS and Windows put into archives beside the files."""
_PIECE = 1 << 20


def stored(path: Path) -> bytes:
    """The bytes of a file.

    Raises
    ------
    MetrologyError
        For a file that is not there, is no plain file, cannot be read, or has more than 64 MiB.
    """
    try:
        if path.exists() and not path.is_file():
            raise refused(path, "no plain file", "a file with readings")
        if path.exists() and path.stat().st_size > MAX_BYTES:
            raise too_large(path)
        with path.open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise refused(path, "no such file", "a file with readings") from None
    except OSError as error:
        raise refused(path, f"a file that cannot be read ({error.strerror})", "a file with readings") from None
    return limited(path, raw)


def limited(path: Path, raw: bytes) -> bytes:
    """The same bytes, unless there are more than can be read."""
    if len(raw) > MAX_BYTES:
        raise too_large(path)
    return raw


def too_large(path: Path | str) -> MetrologyError:
    """What is said of a file with more than can be read."""
    fix = "split the file, or lower the rate: keep every n-th sample of a record that was filtered before"
    return refused(path, "a file that is too large", f"at most {MAX_BYTES >> 20} MiB of readings a file, unpacked", fix)


def unpacked(path: Path, raw: bytes, member: str | None, *, state: str = STATE) -> tuple[bytes, str]:
    """Content of a gzip file, or of a file in an archive, and its name; others as they are.

    A workbook or an .npz file is an archive too: its parts are counted wherever it was packed.

    Raises
    ------
    MetrologyError
        For a damaged file, one with more than 64 MiB unpacked, and an archive of which it is not clear what is read.
    """
    content, name = raw, path.name
    is_gzip = raw.startswith(b"\x1f\x8b")
    if path.suffix == ".gz" and not is_gzip:
        raise refused(path, "a damaged or truncated gzip file", "a whole gzip file", "copy the file again")
    if is_gzip:
        content, name = _gunzipped(path, raw), path.name.removesuffix(".gz")
    elif path.suffix.lower() == ".zip":
        content, name = _member(path, raw, member, state)
    if member is not None and (is_gzip or path.suffix.lower() != ".zip"):
        raise refused(path, f"'member: {member}' of a file that is no archive", "a .zip file", "leave 'member' out")
    if content.startswith(b"PK"):
        check_archive(path, content)
    return content, name


def _gunzipped(path: Path, raw: bytes) -> bytes:
    try:
        with gzip.open(BytesIO(raw)) as file:
            return limited(path, file.read(MAX_BYTES + 1))
    except (OSError, EOFError, zlib.error):
        raise refused(path, "a damaged or truncated gzip file", "a whole gzip file", "copy the file again") from None


_DAMAGED = (
    zipfile.BadZipFile, OSError, EOFError, zlib.error, lzma.LZMAError, RuntimeError, NotImplementedError, ValueError,
)  # fmt: skip


def check_archive(path: Path, raw: bytes) -> list[str]:
    """Names within an archive whose members have at most 64 MiB together, counted and not believed."""
    try:
        with zipfile.ZipFile(BytesIO(raw)) as archive:
            members = archive.infolist()
            if len(members) > MAX_MEMBERS:
                raise refused(path, f"an archive of {len(members)} files", f"at most {MAX_MEMBERS}")
            _refuse_ways_out(path, members)
            total = 0
            for one in members:
                with archive.open(one) as file:
                    while piece := file.read(_PIECE):
                        total += len(piece)
                        if total > MAX_BYTES:
                            raise too_large(path)
            return [one.filename for one in members if not one.is_dir()]
    except _DAMAGED:
        raise refused(path, "a damaged or locked archive", "a whole one, without a password", "copy it again") from None


def _refuse_ways_out(path: Path, members: list[zipfile.ZipInfo]) -> None:
    """Refuse names that would lead out of a folder: nothing is unpacked into one, but such an archive is an attack."""
    for name in (one.orig_filename for one in members):
        if re.match(r"[/\\]|[A-Za-z]:", name) or ".." in re.split(r"[/\\]", name) or "\0" in name:
            raise refused(path, f"the name {quoted(name)} in the archive", "names of files within it", "pack it anew")


def _member(path: Path, raw: bytes, member: str | None, state: str) -> tuple[bytes, str]:
    names = [name for name in check_archive(path, raw) if name == member or not _OF_THE_SYSTEM.match(name)]
    chosen = member if member is not None else names[0] if len(names) == 1 else None
    if chosen not in names:
        got = f"no file '{member}' in it" if member is not None else f"{len(names)} files in it and none stated"
        error = refused(path, got, f"one of {', '.join(names[:12])}", state.format(kind="member"))
        raise SeveralPartsError.of("member", names, error) if member is None and names else error
    with zipfile.ZipFile(BytesIO(raw)) as archive:
        return archive.read(str(chosen)), str(chosen)
