"""What makes a PDF last: PDF/A-3a and PDF/UA-1 at once, its sources within, and quick to validate once signed."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from metrology.report import attachments

if TYPE_CHECKING:
    from metrology.report.attachments import Attachment

VARIANT = "pdf/a-3a"
"""The profile that WeasyPrint writes; PDF/UA-1 is claimed beside it, in the same metadata."""

_TEXTS = {"/P", "/H1", "/H2", "/H3", "/H4", "/H5", "/H6", "/TD", "/TH", "/Caption", "/LBody", "/Lbl", "/Span"}
"""Structure elements that hold text."""
_WRAPPERS = {"/Span", "/NonStruct"}
"""Structure elements that say nothing of what they hold."""
_BARE = {"Type", "S", "P", "Pg", "K"}
"""Entries of an element that says nothing more of itself: no words in place of it, no language, no attributes."""
_END = b"</rdf:RDF>"
# PDF/A has no property that names PDF/UA: ISO 19005-3, 6.6.2.3, wants the schema of such a one within the file.
_UNIVERSAL_ACCESS = b"""\
<rdf:Description rdf:about="" xmlns:pdfuaid="http://www.aiim.org/pdfua/ns/id/" pdfuaid:part="1"/>
<rdf:Description rdf:about="" xmlns:pdfaExtension="http://www.aiim.org/pdfa/ns/extension/"
 xmlns:pdfaSchema="http://www.aiim.org/pdfa/ns/schema#" xmlns:pdfaProperty="http://www.aiim.org/pdfa/ns/property#">
<pdfaExtension:schemas><rdf:Bag><rdf:li rdf:parseType="Resource">
<pdfaSchema:schema>PDF/UA identification</pdfaSchema:schema>
<pdfaSchema:namespaceURI>http://www.aiim.org/pdfua/ns/id/</pdfaSchema:namespaceURI>
<pdfaSchema:prefix>pdfuaid</pdfaSchema:prefix>
<pdfaSchema:property><rdf:Seq><rdf:li rdf:parseType="Resource">
<pdfaProperty:name>part</pdfaProperty:name>
<pdfaProperty:valueType>Integer</pdfaProperty:valueType>
<pdfaProperty:category>internal</pdfaProperty:category>
<pdfaProperty:description>Part of ISO 14289 that the document follows</pdfaProperty:description>
</rdf:li></rdf:Seq></pdfaSchema:property>
</rdf:li></rdf:Bag></pdfaExtension:schemas></rdf:Description>
"""


def prepare(document: Any) -> None:
    """Keep one annotation a link: WeasyPrint gives every box within a link one more, outside of any link's tag."""
    for page in document.pages:
        page.links[:] = [link for link in page.links if link[3].element_tag == "a"]


def finish(pdf: Any, files: Sequence[Attachment], issued: str) -> None:
    """Bring a `pydyf.PDF` that WeasyPrint made for `VARIANT` into its last shape, before it is written.

    Parameters
    ----------
    pdf : pydyf.PDF
        Changed in place.
    files : sequence of Attachment
        What it carries.
    issued : str
        Date of issue, ``2026-11-20``, or empty.
    """
    _claim_universal_access(pdf)
    while _fold_leaves(pdf):
        pass
    attachments.embed(pdf, files, issued)
    _compress_once(pdf)
    _write_objects_apart(pdf)


def _compress_once(pdf: Any) -> None:
    """Put what is compressed in the place of every stream: pydyf asks for it twice, and each time compresses anew."""
    import pydyf  # type: ignore[import-untyped]

    for entry in pdf.objects:
        if isinstance(entry, pydyf.Stream) and entry.compress:
            plain = b"\n".join(item if isinstance(item, bytes) else pydyf._to_bytes(item) for item in entry.stream)
            entry.stream, entry.compress = [zlib.compress(plain)], False
            entry.extra["Filter"] = "/FlateDecode"


def _claim_universal_access(pdf: Any) -> None:
    """Claim PDF/UA-1 within the one rdf:RDF that the metadata may have."""
    metadata = _object(pdf, pdf.catalog["Metadata"])
    (xml,) = metadata.stream
    head, tail = xml.rsplit(_END, 1)
    metadata.stream = [head + _UNIVERSAL_ACCESS + _END + tail]


def _fold_leaves(pdf: Any) -> bool:
    """Let cells, paragraphs and the like hold their text themselves; whether there was anything to fold.

    WeasyPrint wraps each piece in a span of its own, and styled ones once more, more than half of all objects; who
    validates a signature reads all.
    """
    leaves = {entry.reference: entry for entry in pdf.objects if _is_leaf(pdf, entry)}
    for entry in pdf.objects if leaves else ():
        if entry.free != "f" and isinstance(entry, dict) and entry.get("Type") == "/StructElem":
            entry["K"][:] = [piece for kid in entry["K"] for piece in leaves.get(_key(kid), {"K": [kid]})["K"]]
    tree = _object(pdf, _object(pdf, pdf.catalog["StructTreeRoot"])["ParentTree"])
    for owners in tree["Nums"][1::2] if leaves else ():
        if isinstance(owners, list):
            owners[:] = [leaves[owner]["P"] if owner in leaves else owner for owner in owners]
    for leaf in leaves.values():
        leaf.free, leaf.generation = "f", 1
    return bool(leaves)


def _is_leaf(pdf: Any, entry: Any) -> bool:
    """Whether an element wraps one piece of text or nothing, within one on its page that may hold text itself."""
    if entry.free == "f" or not isinstance(entry, dict) or entry.get("S") not in _WRAPPERS or entry.keys() - _BARE:
        return False
    parent = _object(pdf, entry["P"])
    bare = len(entry["K"]) < 2 and all(isinstance(kid, int) for kid in entry["K"])
    return bare and parent["S"] in _TEXTS | _WRAPPERS and parent["Pg"] == entry["Pg"]


def _key(kid: Any) -> bytes:
    return kid if isinstance(kid, bytes) else b""


def _object(pdf: Any, reference: bytes) -> Any:
    return pdf.objects[int(reference.split()[0])]


def _write_objects_apart(pdf: Any) -> None:
    """Keep objects out of a common stream: a tagged page has thousands, and validators unpack the stream for each."""
    write = pdf.write

    def write_apart(output: Any, version: str, identifier: bool, _compress: bool) -> None:
        write(output, version, identifier, compress=False)

    pdf.write = write_apart
