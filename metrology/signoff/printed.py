"""What a report's pages show, read back from the PDF: its words and numbers, and what is painted."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from itertools import pairwise
from math import isclose, isfinite
from typing import Any

COVER = 2
"""Pages on which the table of results begins, at most: page 1, or the next where there is much to be noted."""
_NUMBER = re.compile(r"(?<![\w.])([−-]?\d+(?:[.,]\d+)?)(?:×10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?(?![\w.]*\w)")
_POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_PAINTING = {"f", "F", "f*", "B", "B*", "b", "b*", "S", "s", "sh", "Do", "BI", "INLINE IMAGE"}


@dataclass(frozen=True)
class Number:
    """A number as it is printed: its value, and half a unit of its last digit."""

    value: float
    half: float


@contextmanager
def _readable() -> Iterator[None]:
    """What a damaged file makes the reader stumble over, as one kind of error."""
    from pypdf.errors import PyPdfError

    try:
        yield
    except (PyPdfError, KeyError, TypeError, AttributeError, IndexError, RecursionError) as error:
        raise ValueError(f"{type(error).__name__}: {error}") from None


def numbers(content: bytes) -> Iterator[list[Number]]:
    """The numbers on each page of a PDF, in reading order; a page is read when it is asked for.

    Raises
    ------
    ValueError
        Where they cannot be read.
    """
    from pypdf import PdfReader

    with _readable():
        for page in PdfReader(BytesIO(content)).pages:
            yield list(_numbers(page.extract_text()))


def difference(made: bytes, found: bytes) -> str:
    """Where one PDF, before it is signed, shows other words, numbers or drawings than another; empty if nowhere.

    So do attachments and actions. Spaces, line breaks and places, which hang on fonts, count for nothing.

    Raises
    ------
    ValueError
        Where pages cannot be read.
    """
    from pypdf import PdfReader

    with _readable():
        ours, theirs = PdfReader(BytesIO(made)), PdfReader(BytesIO(found))
        if more := _catalog(theirs) - _catalog(ours):
            return f"the file has {', '.join(sorted(more))}"
        if other := _attached(theirs) - _attached(ours):
            return f"the attached {min(other)[0]} is another one"
        if len(ours.pages) != len(theirs.pages):
            return f"{len(theirs.pages)} pages for {len(ours.pages)}"
        pairs = enumerate(zip(ours.pages, theirs.pages, strict=True), 1)
        return next((f"page {page}: {words}" for page, pair in pairs if (words := _other(*pair))), "")


def _other(mine: Any, theirs: Any) -> str:
    """What one page shows otherwise than another."""
    one, other = ("".join(page.extract_text().split()) for page in (mine, theirs))
    if one != other:
        at = next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), 0)
        return f"'{other[max(0, at - 20) : at + 20]}' for '{one[max(0, at - 20) : at + 20]}'"
    return "something else is drawn on it" if _painted(mine) != _painted(theirs) else ""


def _attached(reader: Any) -> frozenset[tuple[str, bytes]]:
    """Name and content of every attachment, both contents where a file gives two: one viewer shows one of them."""
    found = ((one.name, one.pdf_object["/EF"]) for one in reader.attachment_list)
    return frozenset((name, stream.get_object().get_data()) for name, held in found for stream in held.values())


def _catalog(reader: Any) -> frozenset[str]:
    root = reader.trailer["/Root"]
    return frozenset(str(key) for key in (*root.keys(), *root.get("/Names", {}).keys()))


def _painted(page: Any) -> Counter[str]:
    contents = page.get_contents()
    operations = contents.operations if contents is not None else ()
    found = Counter(_operator(operator) for _, operator in operations)
    kept = Counter({name: count for name, count in found.items() if name in _PAINTING})
    return kept + Counter(_annotated(one.get_object()) for one in page.get("/Annots", []))


def _annotated(annotation: Any) -> str:
    """What an annotation is, whether it is drawn, and where it leads."""
    action = annotation.get("/A", {})
    drawn = "/AP" in annotation or "/AA" in annotation
    return f"{annotation.get('/Subtype')} {drawn} {action.get('/S')} {action.get('/URI')} {annotation.get('/Dest')}"


def _operator(operator: bytes | str) -> str:
    return operator.decode("latin-1") if isinstance(operator, bytes) else operator


def _numbers(text: str) -> Iterator[Number]:
    for figures, power in _NUMBER.findall(text):
        digits = figures.replace(",", ".")  # a certificate may have decimal commas
        scale = 10.0 ** int(power.translate(_POWERS) or 0) if _is_power(power) else 1.0
        places = len(digits.partition(".")[2])
        trailing = 0 if places else len(digits) - len(digits.rstrip("0"))
        yield Number(float(digits.replace("−", "-")) * scale, 0.5 * 10.0 ** (trailing - places) * scale)


def _is_power(power: str) -> bool:
    return bool(re.fullmatch("⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]{1,3}", power))


def absent(results: Sequence[Mapping[str, Any]], printed: Iterable[Sequence[Number]]) -> list[str]:
    """Results whose value and u stand nowhere side by side, rounded, by whatever version; those of page 1 not there.

    No further pages are read than it takes to find all: those with pictures take long.
    """
    left = list(results)
    for page, found in enumerate(printed):
        if page == COVER and any(one.get("headline", True) for one in left):
            break
        pairs = list(pairwise(found))
        left = [one for one in left if not _stands(one, pairs)]
        if not left:
            break
    return [str(one["name"]) for one in left]


EXACT = 1e-13
"""Part of a value below which its u is printed as zero."""


def _stands(result: Mapping[str, Any], pairs: Sequence[tuple[Number, Number]]) -> bool:
    from metrology.units import convert, factor

    value, u, unit = float(result["value"]), float(result["u"]), str(result["display_unit"])
    if not (isfinite(value) and isfinite(u)):
        return True
    wanted, u = convert(value, unit), u / factor(unit)
    u = u if u > EXACT * abs(wanted) else 0.0
    # One digit of u at least has to be printed, and the value to that place: a lone "5" stands for nothing. What has no
    # u is printed in full, or to five digits.
    most = 0.51 * u if u > 0 else max(1e-5 * abs(wanted), 1e-12)
    for first, second in pairs:
        # Value and u are printed to one place: zeros at the end of the one are digits where the other has digits.
        half = min(first.half, second.half)
        shown = half <= most or (not u and isclose(wanted, first.value, rel_tol=1e-12))
        if shown and _rounds(wanted, first.value, half) and _rounds(u, second.value, half):
            return True
    return False


def _rounds(value: float, printed: float, half: float) -> bool:
    return abs(value - printed) <= half * (1 + 1e-9) or isclose(value, printed, rel_tol=1e-12)
