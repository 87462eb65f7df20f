"""Files within the PDF: what the report was made from and what it says, for programs, each with its relationship."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import md5, sha256
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError

if TYPE_CHECKING:
    from metrology.findings import Findings

MEDIA_TYPES = {
    ".csv": "text/csv",
    ".gz": "application/gzip",
    ".json": "application/json",
    ".png": "image/png",
    ".py": "text/x-python",
    ".svg": "image/svg+xml",
    ".yaml": "application/yaml",
    ".yml": "application/yaml",
}
"""By our own table: those of two machines differ, and with them the bytes."""

MADE = {
    "results.json": ("Data", "All results at full precision, as a program reads them"),
    "results.csv": ("Data", "The results as a table"),
    "ro-crate-metadata.json": ("Supplement", "Provenance as RO-Crate: files, software, action, people"),
}
"""File of the report's folder that the PDF carries → relationship (ISO 32000-2, table 43) and description."""


@dataclass(frozen=True)
class Attachment:
    """A file within the PDF.

    `path` is where it belongs, seen from the campaign's folder or the report's; `name` the same for a list of files,
    without a folder. `relationship`: of the file to the report, ``Source``, ``Data`` or ``Supplement``.
    """

    name: str
    path: str
    content: bytes
    relationship: str
    description: str

    @property
    def media_type(self) -> str:
        """Its media type, by the end of its name."""
        return media_type(self.name)


def media_type(name: str) -> str:
    """The media type of a file, by the end of its name."""
    return MEDIA_TYPES.get(PurePosixPath(name).suffix, "application/octet-stream")


def gather(
    findings: Findings, made: Mapping[str, bytes], sources: Mapping[str, bytes] | None
) -> tuple[Attachment, ...]:
    """Everything that the PDF carries.

    Parameters
    ----------
    findings : Findings
        What the report prints.
    made : mapping
        Files of the report's folder by name; those of `MADE` are carried.
    sources : mapping, optional
        The campaign file and the readings, by their path in `findings.inputs`; None where they are not at hand.

    Raises
    ------
    MetrologyError
        For an input that is missing among `sources`, or is not the one that was evaluated.
    """
    names = _names([file.path for file in findings.inputs], taken=list(MADE))
    inputs = () if sources is None else _inputs(findings, sources, names)
    outputs = (Attachment(name, name, made[name], *MADE[name]) for name in MADE if name in made)
    return (*inputs, *outputs)


def _inputs(findings: Findings, sources: Mapping[str, bytes], names: Mapping[str, str]) -> tuple[Attachment, ...]:
    faults = [
        Fault(file.path, found, "the file that was evaluated, of the same SHA-256", "make the report anew")
        for file in findings.inputs
        if file.attached
        if (found := _difference(sources.get(file.path), file.sha256))
    ]
    if faults:
        raise MetrologyError(*faults)
    return tuple(
        Attachment(names[file.path], file.path, sources[file.path], "Source", input_kind(i, file.path))
        for i, file in enumerate(findings.inputs)
        if file.attached
    )


def input_kind(index: int, path: str) -> str:
    """What an input is, in words: the first is the campaign file."""
    if path.endswith(".py"):
        return "An effect of the laboratory's own, as it was run"
    if path.endswith((".svg", ".png")):
        return "A picture at the head of the report"
    return "Readings, as they were evaluated" if index else "The campaign file"


def _difference(content: bytes | None, digest: str) -> str:
    if content is None:
        return "nothing"
    return "" if sha256(content).hexdigest() == digest else "a file that changed since"


def _names(paths: Sequence[str], taken: Sequence[str]) -> dict[str, str]:
    """A name without a folder for every path, no two alike, also where a file system knows no upper case."""
    names: dict[str, str] = {}
    used = {name.casefold() for name in taken}
    for path in paths:
        name = plain = path.replace("/", "-")
        count = 1
        while name.casefold() in used:
            count += 1
            name = f"{count}-{plain}"
        used.add(name.casefold())
        names[path] = name
    return names


def embed(pdf: Any, files: Sequence[Attachment], issued: str) -> None:
    """Put files into a `pydyf.PDF`, as PDF/A-3 wants them (ISO 19005-3, 6.8); they carry the date of issue, or none."""
    import pydyf  # type: ignore[import-untyped]

    date = {"ModDate": pydyf.String(f"D:{issued.replace('-', '')}000000Z")} if issued else {}
    specifications = [(file.name, _specification(pdf, file, date)) for file in sorted(files, key=_key)]
    if not specifications:
        return
    names = pydyf.Dictionary({"Names": pydyf.Array()})
    for name, reference in specifications:
        names["Names"].extend([pydyf.String(name), reference])
    pdf.add_object(names)
    pdf.catalog.setdefault("Names", pydyf.Dictionary())["EmbeddedFiles"] = names.reference
    pdf.catalog["AF"] = pydyf.Array([reference for _, reference in specifications])


def _key(file: Attachment) -> tuple[bool, bytes]:
    """Order of names in a PDF: by their bytes, those in UTF-16 behind their byte order mark."""
    return not file.name.isascii(), file.name.encode("ascii" if file.name.isascii() else "utf-16-be")


def _specification(pdf: Any, file: Attachment, date: Mapping[str, Any]) -> bytes:
    import pydyf

    checksum = f"<{md5(file.content, usedforsecurity=False).hexdigest()}>"
    stream = pydyf.Stream(
        [file.content],
        {
            "Type": "/EmbeddedFile",
            "Subtype": f"/{file.media_type.replace('/', '#2f')}",
            "Params": pydyf.Dictionary({"Size": len(file.content), "CheckSum": checksum, **date}),
        },
        compress=file.media_type != "application/gzip",
    )
    pdf.add_object(stream)
    specification = pydyf.Dictionary(
        {
            "Type": "/Filespec",
            "F": pydyf.String(file.name),
            "UF": pydyf.String(file.name),
            "EF": pydyf.Dictionary({"F": stream.reference, "UF": stream.reference}),
            "Desc": pydyf.String(f"{file.description}: {file.path}" if file.path != file.name else file.description),
            "AFRelationship": f"/{file.relationship}",
        }
    )
    pdf.add_object(specification)
    return bytes(specification.reference)
