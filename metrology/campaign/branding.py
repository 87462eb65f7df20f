"""What a campaign takes from files about the look of its report: what they hold, and what is refused in them.

They lie in the campaign's folder or in the one above, so that many campaigns share them, and a campaign from a stranger
reads nothing elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from metrology.campaign.calibration import folder_of
from metrology.campaign.readings import inside
from metrology.declaration import document as documents
from metrology.declaration.branding import SUFFIXES, Branding
from metrology.declaration.entry import Refusal, refusals
from metrology.errors import Fault, MetrologyError, own_text
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.declaration.document import Document

SHARED = (".yaml", ".yml")
MAX_BYTES = 256 << 10
MAX_PIXELS = 4_000_000
MOST_SHAPES = 5000
_SVG = "{http://www.w3.org/2000/svg}"
_SHAPES = frozenset(
    [
        "svg",
        "g",
        "path",
        "rect",
        "circle",
        "ellipse",
        "line",
        "polyline",
        "polygon",
        "defs",
        "linearGradient",
        "radialGradient",
        "stop",
        "clipPath",
        "title",
        "desc",
        "use",
    ]
)
"""What an SVG may hold: words need fonts, style sheets and pictures can fetch, and the rest can run."""


@dataclass
class Look:
    """What was read: files by their name in the campaign, and what was wrong with them."""

    files: dict[str, bytes] = field(default_factory=dict)
    refusals: list[Refusal] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)


def enter_branding(document: Document) -> Look:
    """Enter the keys of a shared file into ``branding``, where it names one, and read the pictures that are named."""
    look = Look()
    stated = document.data.get("branding") if isinstance(document.data, dict) else None
    if not isinstance(stated, dict):
        return look
    folder = folder_of(document)
    if isinstance(stated.get("file"), str):
        _enter_shared(folder, stated, look)
    for place, name in _pictures(stated):
        if name not in look.files and (raw := _fetched(folder, name, SUFFIXES, place, look)) is not None:
            look.files[name] = raw
            path = folder / name
            look.faults += [Fault(str(path), got, expected, fix) for got, expected, fix in wrong(name, raw)]
    return look


def _enter_shared(folder: Path, stated: dict[str, Any], look: Look) -> None:
    name = stated["file"]
    raw = _fetched(folder, name, SHARED, ("branding", "file"), look)
    if raw is None:
        return
    look.files[name] = raw
    try:
        if len(raw) > MAX_BYTES:
            raise MetrologyError(Fault(str(_place(folder, name)), f"more than {MAX_BYTES >> 10} KiB", "a shorter file"))
        shared = documents.parse(_place(folder, name), raw)
        if shared.faults:
            raise MetrologyError(*(fault for _, fault in shared.faults))
        found = _validated(shared)
    except MetrologyError as error:
        look.faults += error.faults
        return
    stated.update({key: value for key, value in found.items() if key not in stated})


def _validated(shared: Document) -> dict[str, Any]:
    """Keys of a shared file, each with its faults reported at its place there."""
    from pydantic import ValidationError

    data = shared.data if isinstance(shared.data, dict) else {}
    if "file" in data:
        raise MetrologyError(Fault(shared.at("file"), "another shared file", "the keys themselves", "leave it out"))
    try:
        Branding.model_validate(data)
    except ValidationError as error:
        raise MetrologyError(
            *(Fault(shared.at(*one.loc, key=one.of_key), one.got, one.expected, one.fix) for one in refusals(error))
        ) from None
    return data


def _pictures(stated: dict[str, Any]) -> Iterator[tuple[tuple[str, ...], str]]:
    accreditation = stated.get("accreditation")
    mark = accreditation.get("mark") if isinstance(accreditation, dict) else None
    for place, name in ((("branding", "logo"), stated.get("logo")), (("branding", "accreditation", "mark"), mark)):
        if isinstance(name, str):
            yield place, name


def _fetched(folder: Path, name: str, ends: tuple[str, ...], place: tuple[str, ...], look: Look) -> bytes | None:
    try:
        path = _place(folder, name, ends)
        if not path.is_file():
            raise ValueError("there is no such file")
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except (ValueError, OSError) as error:
        why = own_text(error) if isinstance(error, OSError) else str(error)
        expected = f"a file, {' or '.join(ends)}, in the campaign's folder or the one above"
        look.refusals.append(Refusal(place, quoted(name), expected, why))
        return None


def _place(folder: Path, name: str, ends: tuple[str, ...] = ()) -> Path:
    """Where a file lies: in the campaign's folder, else in the one above."""
    ends = ends or SHARED
    own = inside(folder, name, ends)
    return own if own.exists() else inside(folder.resolve().parent, name, ends)


def named(folder: Path, data: Any) -> Iterator[tuple[str, Path]]:
    """Every file that the look of a report names and that is there, by its name: for who takes a campaign elsewhere."""
    stated = data.get("branding") if isinstance(data, dict) else None
    if not isinstance(stated, dict):
        return
    stated = dict(stated)
    look = Look()
    if isinstance(stated.get("file"), str):
        _enter_shared(folder, stated, look)
    for name in (*look.files, *(name for _, name in _pictures(stated))):
        try:
            path = _place(folder, name, (*SHARED, *SUFFIXES))
        except ValueError:
            continue
        if path.is_file():
            yield name, path


def wrong(name: str, raw: bytes) -> Iterator[tuple[str, str, str]]:
    """What forbids a picture: what was found, what was expected, how to fix it."""
    if len(raw) > MAX_BYTES:
        yield f"more than {MAX_BYTES >> 10} KiB", f"a picture of at most {MAX_BYTES >> 10} KiB", "make it simpler"
        return
    yield from _wrong_svg(raw) if name.endswith(".svg") else _wrong_png(raw)


def _wrong_png(raw: bytes) -> Iterator[tuple[str, str, str]]:
    from PIL import Image

    try:
        with Image.open(BytesIO(raw), formats=["PNG"]) as picture:
            if picture.width * picture.height > MAX_PIXELS:
                got = f"{picture.width} × {picture.height} pixels"
                yield got, f"a picture of at most {MAX_PIXELS} pixels", "make it smaller"
                return
            picture.load()
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        yield f"no PNG that can be read ({error})", "a PNG", "save it again as PNG"


def _wrong_svg(raw: bytes) -> Iterator[tuple[str, str, str]]:
    expected, fix = "an SVG of plain shapes", "save it as plain SVG, its words as paths"
    if b"<!DOCTYPE" in raw or b"<!ENTITY" in raw:
        yield "a document type", expected, fix
        return
    try:
        root = ET.fromstring(raw)  # noqa: S314 - bounded, and without a document type no entity is declared
    except (ET.ParseError, LookupError, ValueError) as error:
        yield f"no XML ({error})", expected, fix
        return
    elements = list(root.iter())
    if root.tag != f"{_SVG}svg" or len(elements) > MOST_SHAPES:
        yield f"<{_local(root.tag)}> with {len(elements)} elements", f"<svg> with at most {MOST_SHAPES} elements", fix
        return
    if root.get("viewBox") is None and None in (root.get("width"), root.get("height")):
        yield "no size", "an SVG with 'viewBox', or 'width' and 'height'", "save it with its size"
    found = [got for element in elements for got in _hostile(element)]
    yield from ((got, expected, fix) for got in dict.fromkeys(found))


def _hostile(element: ET.Element) -> Iterator[str]:
    tag = element.tag if isinstance(element.tag, str) else ""
    if tag.startswith(_SVG) and _local(tag) not in _SHAPES:
        yield f"<{_local(tag)}>"
    elif not tag.startswith(_SVG):
        yield f"<{_local(tag)}>, which is no part of SVG"
    for key, value in element.attrib.items():
        name = _local(key)
        if name.casefold().startswith("on"):
            yield f"'{name}', which runs code"
        elif (name == "href" and not value.startswith("#")) or re.search(r"(?i)url\(\s*['\"]?(?!#)|@import|\\", value):
            yield f"{name}={quoted(value)}, which refers to another file"


def _local(tag: object) -> str:
    return str(tag).rpartition("}")[2]
