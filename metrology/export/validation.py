"""Validation of a certificate against the schemas that the user has, without a look at the network."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from pathlib import Path

from metrology.errors import Fault, MetrologyError
from metrology.export.markup import DCC


@dataclass(frozen=True)
class Schemas:
    """The schemas of a folder: `files` by the namespace that each is for, `version` of the certificate's."""

    files: dict[str, Path]
    version: str


def find(folder: Path) -> Schemas:
    """Return the schemas of a folder and of the folders in it, where si/ and d-sig/ may stand.

    Raises
    ------
    MetrologyError
        Where there is none of the certificate's namespace.
    """
    files: dict[str, Path] = {}
    for path in sorted(folder.rglob("*.xsd")) if folder.is_dir() else ():
        target = re.search(r'targetNamespace\s*=\s*"([^"]*)"', path.read_text(encoding="utf-8", errors="replace"))
        if target:
            files[target[1]] = path
    if DCC not in files:
        expected = f"a folder with the schema of {DCC} (dcc.xsd) and those that it imports"
        raise MetrologyError(Fault(str(folder), "no such schema", expected))
    stated = re.search(r"<xs:schema[^>]*?\sversion\s*=\s*\"([^\"]+)\"", files[DCC].read_text(encoding="utf-8"))
    return Schemas(files, stated[1] if stated else "")


def faults(document: bytes, schemas: Schemas, name: str) -> tuple[Fault, ...]:
    """Return everything in which a document departs from the schemas.

    Raises
    ------
    MetrologyError
        Where the schemas are unusable, or the package `xmlschema` is missing.
    """
    try:
        import xmlschema
    except ImportError:
        fix = "install the extra 'export'"
        raise MetrologyError(Fault("--schema", "no package 'xmlschema'", "the package that validates", fix)) from None
    locations = [(space, path.resolve().as_uri()) for space, path in schemas.files.items()]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", xmlschema.XMLSchemaImportWarning)
            schema = xmlschema.XMLSchema(schemas.files[DCC], locations=locations, allow="local")
    except (xmlschema.XMLSchemaException, xmlschema.XMLSchemaImportWarning, OSError, ValueError) as error:
        got = " ".join(str(error).split())[:300]
        raise MetrologyError(
            Fault(str(schemas.files[DCC]), got, "a schema with all that it imports in the same folder")
        ) from None
    return tuple(
        Fault(f"{name} {error.path}", " ".join(str(error.reason).split())[:300], "what the schema asks")
        for error in schema.iter_errors(document.decode())
    )
