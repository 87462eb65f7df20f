"""What was added to a report after it was written: signatures, time stamps, validation data, and nothing else."""

from __future__ import annotations

from collections.abc import Container, Iterator
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

if TYPE_CHECKING:
    from metrology.signoff.opened import Opened

STAMP = "/DocTimeStamp"


def is_stamp(embedded: Any) -> bool:
    """Whether what fills a signature field is a time stamp of the document, which nobody's role stands for."""
    return str(embedded.sig_object_type) == STAMP


def faults(opened: Opened) -> Iterator[str]:
    """Everything that `metrology sign`, or an archive that renews time stamps, does not add."""
    readable = [embedded for _, embedded in opened.signatures if not isinstance(embedded, Exception)]
    if len(readable) < len(opened.signatures):
        return  # said of the signature itself
    signed = [int(embedded.signed_revision) for embedded in readable]
    others = [number for number in range(1, opened.revisions) if number not in signed]
    if len(set(signed)) < len(signed):
        yield "several signatures were added at once"
    if any(not _validation_data(opened, number) for number in others):
        yield "something else than signatures was added to the report"
    # No signature before the first tells what came with it, and each later one covers that.
    if 1 in signed and not _signature_alone(opened):
        yield "something else was added together with the first signature"
    if any(_described(opened, number) != _described(opened, 0) for number in range(1, opened.revisions)):
        yield "what the file says of itself, such as its title, was changed"
    if readable and not _reaches_the_end(opened, readable):
        yield "it goes on behind the last signature"
    if any(_visible(embedded.sig_field) for embedded in readable):
        yield "a signature is drawn on a page, where it may cover what is printed"
    if any(ACTIONS & embedded.sig_field.keys() for embedded in readable):
        yield "a signature has an action, which a viewer may run"
    if len(_fields(opened.reader)) != len(readable):
        yield "its form has other fields than signatures, and what they show may cover what is printed"


def _validation_data(opened: Opened, number: int) -> bool:
    """Whether a revision added certificates and lists of revoked ones (PAdES, ETSI EN 319 142-1, 5.4), and no more."""
    from pyhanko.pdf_utils.misc import PdfError
    from pyhanko.sign.diff_analysis import (
        CatalogModificationRule,
        DocInfoRule,
        DSSCompareRule,
        MetadataUpdateRule,
        ModificationLevel,
        ObjectStreamRule,
        StandardDiffPolicy,
        SuspiciousModification,
        XrefStreamRule,
    )

    level = ModificationLevel.LTA_UPDATES
    # Programs note the day of a change in what the file says of itself: neither is shown on a page.
    described = (DocInfoRule(), MetadataUpdateRule())  # type: ignore[no-untyped-call]
    added = (XrefStreamRule(), ObjectStreamRule(), DSSCompareRule(), *described)
    rules = [rule.as_qualified(level) for rule in added]
    catalog = CatalogModificationRule()  # type: ignore[no-untyped-call]
    policy = StandardDiffPolicy(global_rules=[catalog, *rules], form_rule=None)
    before, after = (opened.reader.get_historical_resolver(one) for one in (number - 1, number))
    try:
        policy.apply(before, after)
    except (SuspiciousModification, PdfError):
        return False
    return number > 1  # before the first signature there is nothing to validate


ADDED = frozenset({"/AcroForm", "/Perms", "/DSS", "/Extensions", "/Version", "/Metadata"})
"""What the catalog gets with a signature; of the metadata see `_described`."""
ACTIONS = frozenset({"/A", "/AA"})


def _signature_alone(opened: Opened) -> bool:
    """Whether the first revision is one signature, and changes nothing that was there.

    It may replace the catalog, which gets a form, and a page, or its list of annotations, which gets the place of the
    signature; and what the file says of itself.
    """
    before, after = (opened.reader.get_historical_resolver(number) for number in (0, 1))
    try:
        fields = _fields(after)
        if after.root_ref != before.root_ref or "/AcroForm" in before.root or len(fields) != 1:
            return False
        # Of these `_described` tells.
        described = [_reference(before.trailer_view, "/Info"), _reference(before.root, "/Metadata")]
        places = opened.reader.xrefs
        replaced = [one for one in after.explicit_refs_in_revision() if places.get_historical_ref(one, 0) is not None]
        return not after.refs_freed_in_revision() and all(
            _same(before(one), after(one), ADDED if one == after.root_ref else {"/Annots"}, fields)
            for one in replaced
            if one not in described
        )
    except Exception:  # noqa: BLE001  (a forged file may break any part of the reader)
        return False


def _same(one: Any, other: Any, added: Container[str], fields: list[Any]) -> bool:
    """Whether an object is what it was, but for what a signature adds to it."""
    if isinstance(one, list):
        return isinstance(other, list) and list(other) in (list(one), [*one, *fields])
    if not isinstance(one, dict) or one.get("/Type") not in ("/Catalog", "/Page"):
        return bool(one == other)
    notes = _listed(one, "/Annots"), _listed(other, "/Annots")
    return _without(one, added) == _without(other, added) and _same(*notes, (), fields)


def _fields(within: Any) -> list[Any]:
    """References to the fields of a form."""
    return _listed(within.root["/AcroForm"], "/Fields") if "/AcroForm" in within.root else []


def _listed(one: Any, key: str) -> list[Any]:
    """A list wherever in the file it stands (`get` would return a mere reference); empty where there is none."""
    return [*one[key]] if key in one else []


def _without(one: Any, keys: Container[str]) -> dict[str, Any]:
    return {key: one.raw_get(key) for key in one if key not in keys}


def _reference(one: Any, key: str) -> Any:
    found = one.raw_get(key) if key in one else None
    return getattr(found, "reference", None)


NOTED = ("/ModDate", "/Producer")
"""What programs note in the document information when they change a file: when, and by which program."""
SHOWN = "{http://purl.org/dc/elements/1.1/}"
"""Namespace of what viewers and archives show of the metadata: title, authors, subject."""


def _described(opened: Opened, number: int) -> tuple[dict[str, str], list[tuple[str, str]]]:
    """What a revision says of the file itself, but for when and by what it was last changed.

    Programs write the same metadata in other words of RDF; what is shown of them counts.
    """
    reader = opened.reader

    def held(within: Any, key: str) -> Any:
        one = within.raw_get(key) if key in within else None
        return one if one is None or not hasattr(one, "reference") else reader.get_object(one.reference, number)

    trailer = reader.get_historical_resolver(number).trailer_view
    info, metadata = held(trailer, "/Info"), held(held(trailer, "/Root"), "/Metadata")
    stated = {str(key): str(info.raw_get(key)) for key in info or () if key not in NOTED}
    return stated, _shown(metadata.data) if metadata is not None else []


def _shown(metadata: bytes) -> list[tuple[str, str]]:
    """Name and text of every property of `SHOWN`; all of what is no plain XML, or has entities of its own."""
    whole = [("", metadata.decode("utf-8", "replace"))]
    if b"<!" in metadata:
        return whole
    try:
        tree = ET.fromstring(metadata)  # noqa: S314 - bounded, and without a document type no entity is declared
    except ET.ParseError:
        return whole
    texts = [(one.tag, "".join(one.itertext()).strip()) for one in tree.iter() if one.tag.startswith(SHOWN)]
    return sorted([*texts, *(item for one in tree.iter() for item in one.items() if item[0].startswith(SHOWN))])


def _reaches_the_end(opened: Opened, readable: list[Any]) -> bool:
    """Whether the last signature covers all but validation data, and no bytes lie behind that."""
    from pyhanko.sign.validation.status import SignatureCoverageLevel

    last = max(readable, key=lambda embedded: int(embedded.signed_revision))
    if int(last.signed_revision) < opened.revisions - 1:
        return opened.content.rstrip(b"\r\n").endswith(b"%%EOF")
    return bool(last.evaluate_signature_coverage() == SignatureCoverageLevel.ENTIRE_FILE)


def _visible(field: Any) -> bool:
    from pyhanko.sign.diff_analysis.rules.form_field_rules import is_field_visible

    return bool(is_field_visible(field))  # type: ignore[no-untyped-call]
