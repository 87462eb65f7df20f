"""What a report's pages show, read back from the PDF: its words and numbers, and what is painted."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import pairwise
from math import isclose, isfinite
from typing import Any

COVER = 2
"""Pages on which the table of results begins, at most: page 1, or the next where there is much to be noted."""
_NUMBER = re.compile(r"(?<![\w.])([−-]?\d+(?:\.\d+)?)(?:×10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?(?![\w.]*\w)")
_POWERS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
_PAINTING = {"f", "F", "f*", "B", "B*", "b", "b*", "S", "s", "sh", "Do", "BI", "INLINE IMAGE"}


@dataclass(frozen=True)
class Printed:
    """Pages as they are read back.

    Parameters
    ----------
    texts : tuple of str
        Of each page, without spaces and line breaks, which hang on fonts.
    numbers : tuple of tuple of Number
        Of each page, in reading order.
    painted : tuple of Counter
        How often each page fills, strokes and shows a picture; annotations count too.
    """

    texts: tuple[str, ...]
    numbers: tuple[tuple[Number, ...], ...]
    painted: tuple[Counter[str], ...]


@dataclass(frozen=True)
class Number:
    """A number as it is printed: its value, and half a unit of its last digit."""

    value: float
    half: float


def read(content: bytes) -> Printed:
    """Read the pages of a PDF back.

    Raises
    ------
    ValueError
        Where they cannot be read.
    """
    from pypdf import PdfReader
    from pypdf.errors import PyPdfError

    try:
        pages = PdfReader(BytesIO(content)).pages
        texts = [page.extract_text() for page in pages]
        painted = tuple(_painted(page) for page in pages)
    except (PyPdfError, ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError) as error:
        raise ValueError(f"{type(error).__name__}: {error}") from None
    return Printed(
        tuple("".join(text.split()) for text in texts), tuple(tuple(_numbers(text)) for text in texts), painted
    )


def _painted(page: Any) -> Counter[str]:
    contents = page.get_contents()
    operations = contents.operations if contents is not None else ()
    found = Counter(_operator(operator) for _, operator in operations)
    kept = Counter({name: count for name, count in found.items() if name in _PAINTING})
    kept["annotations"] = len([one for one in page.get("/Annots", []) if not _is_field(one.get_object())])
    return kept


def _operator(operator: bytes | str) -> str:
    return operator.decode("latin-1") if isinstance(operator, bytes) else operator


def _is_field(annotation: Any) -> bool:
    """Whether an annotation is the place of a signature, which none of ours draws."""
    return str(annotation.get("/FT", "")) == "/Sig"


def _numbers(text: str) -> Iterator[Number]:
    for digits, power in _NUMBER.findall(text):
        scale = 10.0 ** int(power.translate(_POWERS) or 0) if _is_power(power) else 1.0
        places = len(digits.partition(".")[2])
        trailing = 0 if places else len(digits) - len(digits.rstrip("0"))
        yield Number(float(digits.replace("−", "-")) * scale, 0.5 * 10.0 ** (trailing - places) * scale)


def _is_power(power: str) -> bool:
    return bool(re.fullmatch("⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]{1,3}", power))


def absent(results: Sequence[Mapping[str, Any]], printed: Printed) -> list[str]:
    """Results of page 1 whose value and u do not stand there side by side, rounded, by whatever version."""
    numbers = [number for page in printed.numbers[:COVER] for number in page]
    pairs = [*pairwise(numbers)]
    return [str(one["name"]) for one in results if one.get("headline", True) and not _stands(one, pairs)]


def _stands(result: Mapping[str, Any], pairs: Sequence[tuple[Number, Number]]) -> bool:
    from metrology.units import convert, factor

    value, u, unit = float(result["value"]), float(result["u"]), str(result["display_unit"])
    if not (isfinite(value) and isfinite(u)):
        return True
    wanted = convert(value, unit), u / factor(unit)
    return any(_rounds(wanted[0], first) and _rounds(wanted[1], second) for first, second in pairs)


def _rounds(value: float, number: Number) -> bool:
    return abs(value - number.value) <= number.half * (1 + 1e-9) or isclose(value, number.value, rel_tol=1e-12)


def difference(made: Printed, found: Printed) -> str:
    """Where the pages of one file show other words, numbers or drawings than those of another; empty if nowhere."""
    if len(made.texts) != len(found.texts):
        return f"{len(found.texts)} pages for {len(made.texts)}"
    for page, (one, other) in enumerate(zip(made.texts, found.texts, strict=True), 1):
        if one != other:
            at = next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), 0)
            return f"page {page}: '{other[max(0, at - 20) : at + 20]}' for '{one[max(0, at - 20) : at + 20]}'"
    for page, (mine, theirs) in enumerate(zip(made.painted, found.painted, strict=True), 1):
        if mine != theirs:
            return f"page {page}: something else is drawn on it"
    return ""
