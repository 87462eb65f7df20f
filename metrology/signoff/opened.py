"""A report's PDF, opened: its attachments, what it says of itself, and where the unsigned part ends."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

from metrology import jsontext
from metrology.errors import Fault, MetrologyError, own_text, without
from metrology.identification import Signatory

RESULTS = "results.json"
FAMILY = "metrology-results/"
ROLES = ("author", "reviewer", "approver")
"""In the order in which they sign."""
_END = b"%%EOF\n"
_DEPTH = 32
MAX_BYTES = 256 * 1024 * 1024
_EXPANDED = 192 * 1024 * 1024
"""Bytes that all compressed parts of a file may come to, unless that is less than ten times the file."""


@dataclass(frozen=True)
class Input:
    """A file that went in, as `results.json` names it."""

    path: str
    sha256: str
    attached: bool = True


@dataclass(frozen=True)
class Opened:
    """A report's PDF.

    Parameters
    ----------
    path : Path
        As the user gave it.
    content : bytes
        The whole file.
    reader : pyhanko PdfFileReader
        Over `content`.
    attachments : mapping
        Name to content, in the file's last state.
    stated : mapping
        `results.json`, parsed as plain JSON, so that any later version reads it.
    """

    path: Path
    content: bytes
    reader: Any
    attachments: Mapping[str, bytes]
    stated: Mapping[str, Any]

    @property
    def unsigned(self) -> bytes:
        """The file as it was written, before anything was added."""
        start = self.reader.xrefs.get_startxref_for_revision(0)
        end = self.content.find(_END, start)
        return self.content[: end + len(_END)] if end >= 0 else self.content

    @property
    def revisions(self) -> int:
        """How often the file was written: once, and once more for each signature, time stamp and validation data."""
        return int(self.reader.xrefs.total_revisions)

    @cached_property
    def signatures(self) -> tuple[tuple[str, Any], ...]:
        """Role and signature as pyHanko reads it, or the error where it cannot; its own list would stop there."""
        from pyhanko.sign.fields import enumerate_sig_fields
        from pyhanko.sign.validation.pdf_embedded import EmbeddedPdfSignature

        found: list[tuple[str, Any]] = []
        for name, _, field in enumerate_sig_fields(self.reader, filled_status=True):
            try:
                found.append((str(name), EmbeddedPdfSignature(self.reader, field, name)))
            except Exception as error:  # noqa: BLE001  (damaged bytes break the parser anywhere)
                found.append((str(name), error))
        return tuple(found)

    @property
    def required(self) -> tuple[Signatory, ...]:
        """Who has to sign, in order."""
        return tuple(Signatory(**person) for person in self.stated["campaign"].get("signatures", ()))

    def declared_signatories(self) -> tuple[tuple[str, str, str], ...] | None:
        """Role, name and function of who signs, as the attached campaign file says; None where there is none."""
        import yaml

        content = self.sources().get(self.inputs[0].path)
        try:
            report = yaml.load(content or b"", yaml.BaseLoader).get("report", {})  # noqa: S506  (texts only)
            people = report.get("signatures", {})
            named = [(role, people[role]) for role in ROLES if role in people]
            return tuple((role, person["name"].strip(), person["function"].strip()) for role, person in named)
        except (yaml.YAMLError, AttributeError, KeyError, TypeError, RecursionError):
            return None

    @property
    def declared_otherwise(self) -> bool:
        """Whether the attached campaign file names other signatories than `results.json`."""
        stated = self.declared_signatories()
        return stated not in (None, tuple((one.role, one.name, one.function) for one in self.required))

    @property
    def inputs(self) -> tuple[Input, ...]:
        """Files that went in; the campaign file first."""
        stated = self.stated["inputs"]
        # The campaign file is attached whatever is said: it names who signs.
        return tuple(
            Input(str(file["path"]), str(file["sha256"]), not index or file.get("attached") is not False)
            for index, file in enumerate(stated)
        )

    def sources(self) -> dict[str, bytes]:
        """Attached inputs by their path, found by their hash; what is missing, or is not what it was, is left out."""
        known = {sha256(content).hexdigest(): content for content in self.attachments.values()}
        return {file.path: known[file.sha256] for file in self.inputs if file.sha256 in known}


def open_report(path: Path) -> Opened:
    """Open a report of ours.

    Raises
    ------
    MetrologyError
        For what is no PDF, is truncated, encrypted, or is not one of our reports.
    """
    content = _content(path)
    reader = _reader(path, content)
    try:
        attachments = dict(_attachments(reader))
    except Exception as error:  # noqa: BLE001  (whatever a damaged file makes the parser stumble over)
        raise _damaged(path, error) from None
    opened = Opened(path, content, reader, attachments, _stated(path, attachments))
    try:
        _ = opened.signatures, opened.unsigned, opened.revisions
    except Exception as error:  # noqa: BLE001  (a list of fields that leads nowhere)
        raise _damaged(path, error) from None
    return opened


def _content(path: Path) -> bytes:
    try:
        if path.exists() and not path.is_file():
            raise MetrologyError(Fault(str(path), "no plain file", "a report's PDF"))
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise MetrologyError(Fault(str(path), own_text(error), "a report's PDF")) from None
    if len(content) > MAX_BYTES:
        raise MetrologyError(Fault(str(path), f"a file of more than {MAX_BYTES >> 20} MiB", "a report's PDF"))
    return content


def _reader(path: Path, content: bytes) -> Any:
    try:
        from pyhanko.pdf_utils.decode_limits import DecodeLimits, DocumentDecodeBudget
        from pyhanko.pdf_utils.reader import PdfFileReader
    except ImportError:
        raise without("pyHanko", "sign", "metrology verify") from None
    if not content.startswith(b"%PDF-"):
        raise MetrologyError(Fault(str(path), "a file that is no PDF", "report.pdf, as `metrology report` writes it"))
    try:
        budget = DocumentDecodeBudget(base_allowance=_EXPANDED, max_ratio=10)
        reader = PdfFileReader(BytesIO(content), strict=True, decode_limits=DecodeLimits(document_budget=budget))
        encrypted = reader.encrypted
    except Exception as error:  # noqa: BLE001  (as above)
        raise _damaged(path, error) from None
    if encrypted:
        raise MetrologyError(
            Fault(str(path), "an encrypted PDF", "the report as it was written, which is not encrypted")
        )
    return reader


def _damaged(path: Path, error: Exception) -> MetrologyError:
    got = f"a damaged or truncated PDF ({type(error).__name__}: {error})"
    return MetrologyError(Fault(str(path), got, "a whole PDF", "copy the file again"))


def _attachments(reader: Any) -> Iterator[tuple[str, bytes]]:
    names = _entry(reader.root, "/Names")
    yield from _leaves(names["/EmbeddedFiles"], _DEPTH) if "/EmbeddedFiles" in names else ()


def _entry(node: Any, key: str) -> Any:
    """What a dictionary holds, wherever in the file it stands (`get` would return a mere reference); else nothing."""
    if key not in node:
        return ()
    return node[key]


def _leaves(node: Any, depth: int) -> Iterator[tuple[str, bytes]]:
    if depth == 0:
        raise ValueError("a tree of attachments that is too deep")
    for kid in _entry(node, "/Kids"):
        yield from _leaves(kid.get_object(), depth - 1)
    entries = _entry(node, "/Names")
    for i in range(0, len(entries) - 1, 2):
        specification = entries[i + 1]
        yield str(specification["/UF"]), bytes(specification["/EF"]["/F"].data)


def _stated(path: Path, attachments: Mapping[str, bytes]) -> Mapping[str, Any]:
    """What `results.json` says, where it has the places that sign-off needs."""
    wrong = Fault(str(path), "", "a PDF that `metrology report` wrote, with all of its attachments")
    if RESULTS not in attachments:
        raise MetrologyError(Fault(wrong.where, f"a PDF without {RESULTS} attached", wrong.expected))
    try:
        jsontext.check(attachments[RESULTS])
        stated = json.loads(attachments[RESULTS])
        ours = stated["schema"].startswith(FAMILY)
        people = [Signatory(**person) for person in stated["campaign"].get("signatures", ())]
        files = [(file["path"] + file["sha256"], file["bytes"]) for file in stated["inputs"]]
    except (ValueError, KeyError, TypeError, AttributeError):
        raise MetrologyError(Fault(wrong.where, f"{RESULTS} of another kind", wrong.expected)) from None
    if not ours or not files or len({person.role for person in people}) != len(people):
        raise MetrologyError(Fault(wrong.where, f"{RESULTS} of another kind", wrong.expected))
    return dict(stated)
