"""Sign a report in a role: PAdES B-B, the first signature certifying; the file is replaced whole or not at all."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError
from metrology.report import staging
from metrology.signoff import signatures
from metrology.signoff.authority import MARK
from metrology.signoff.opened import RESULTS, Opened, open_report

if TYPE_CHECKING:
    from metrology.checklist import Row
    from metrology.identification import Signatory
    from metrology.signoff.keys import Signer
    from metrology.signoff.signatures import Signature


def sign(report: Path, role: str, signer: Signer) -> Opened:
    """Add the signature of a role to a report's PDF, and return the report as it was before.

    Parameters
    ----------
    report : Path
        Replaced by its signed form, which begins with the very bytes that it had.
    role : str
        One that the campaign names, and that nobody has signed in yet.
    signer : Signer
        Key and certificate.

    Raises
    ------
    MetrologyError
        For a report that is none of ours, was changed, is a draft, does not name the role, was signed in it already or
        not yet in one before it; for a certificate that somebody else signed with; where the file cannot be written.
    """
    with staging.locked(report):
        opened = open_report(report)
        person = _person(opened, role)
        given = signatures.read(opened)
        _refuse_out_of_turn(opened, given, role, signer)
        _refuse_changed(opened, given)
        refuse_draft(opened)
        staging.replace_file(report, _signed(opened, person, signer))
    return opened


def _person(opened: Opened, role: str) -> Signatory:
    named = {person.role: person for person in opened.required}
    if role not in named:
        expected = f"one of {', '.join(named)}" if named else "a campaign that says who signs"
        mend = "name the person under `report.signatures` of the campaign, and make the report anew"
        raise MetrologyError(Fault(str(opened.path), f"the role '{role}'", expected, mend))
    return named[role]


def _refuse_out_of_turn(opened: Opened, given: Sequence[Signature], role: str, signer: Signer) -> None:
    """Refuse a role signed already, one whose turn has not come, and one person's certificate for another."""
    from cryptography.hazmat.primitives.hashes import SHA256

    signed = [signature.role for signature in given]
    names = {person.role: person.name for person in opened.required}
    where = str(opened.path)
    if role in signed:
        raise MetrologyError(Fault(where, f"a report that is signed as {role}", "a role that nobody has signed in yet"))
    missing = [before for before in list(names)[: list(names).index(role)] if before not in signed]
    if missing:
        got = f"a report without the signature of the {missing[0]}"
        raise MetrologyError(Fault(where, got, f"signatures in the order {', '.join(names)}"))
    same = [s.role for s in given if s.fingerprint == signer.certificate.fingerprint(SHA256()).hex()]
    if any(names.get(other) != names[role] for other in same):
        got = f"the certificate that signed as {same[0]}"
        raise MetrologyError(Fault(where, got, f"a certificate of {names[role]}"))


def _refuse_changed(opened: Opened, given: Sequence[Signature]) -> None:
    """Refuse a file that is not what `metrology report` and earlier signatures left."""
    faults = [f"the signature as {s.role} does not hold: {s.broken}" for s in given if s.broken]
    if opened.revisions != len(given) + 1 or (given and not signatures.whole(opened)):
        faults.append("something else than signatures was added")
    attached = opened.sources()
    if attached:
        faults += [
            f"{file.path} is not attached as it was evaluated" for file in opened.inputs if file.path not in attached
        ]
    if faults:
        expected, mend = "the report as it was written", "make the report anew, and sign that"
        raise MetrologyError(*(Fault(str(opened.path), fault, expected, mend) for fault in faults))


def refuse_draft(opened: Opened) -> None:
    """Refuse a report that lacks what its checklists ask for: the one place that tells a draft from what can be signed.

    Raises
    ------
    MetrologyError
        With everything that is missing.
    """
    try:
        missing = lacking(opened)
    except ValueError:
        mend = "sign with the version that made it, or make the report anew"
        got = "a report of another version of this software"
        raise MetrologyError(Fault(str(opened.path), got, "a report that this one reads", mend)) from None
    faults = [
        Fault(
            str(opened.path), f"a draft: {row.reason}", f"{row.clause}: {row.asks}", f"see {row.key}" if row.key else ""
        )
        for row in missing
    ]
    if faults:
        raise MetrologyError(*faults)


def lacking(opened: Opened) -> tuple[Row, ...]:
    """What the checklists of a report ask for and its `results.json` does not give: a draft, where it is anything.

    Raises
    ------
    ValueError
        Where another version of this software made the report.
    """
    from metrology import checklist
    from metrology.findings import from_json

    return tuple(checklist.lacking(from_json(opened.attachments[RESULTS])))


def _signed(opened: Opened, person: Signatory, signer: Signer) -> bytes:
    from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
    from pyhanko.sign import fields
    from pyhanko.sign.signers import PdfSignatureMetadata, PdfSigner

    first = not signatures.roles(opened)
    metadata = PdfSignatureMetadata(
        field_name=person.role,
        name=person.name,
        reason=_reason(person, signer),
        md_algorithm="sha256",
        subfilter=fields.SigSeedSubFilter.PADES,
        certify=first,
        docmdp_permissions=fields.MDPPerm.FILL_FORMS,
    )
    writer = IncrementalPdfFileWriter(BytesIO(opened.content))
    field = fields.SigFieldSpec(sig_field_name=person.role)
    signed: bytes = _run(PdfSigner(metadata, signer.pyhanko, new_field_spec=field), writer, opened)
    assert signed.startswith(opened.content)
    return signed


def _run(signer: Any, writer: Any, opened: Opened) -> bytes:
    from pkcs11.exceptions import PKCS11Error
    from pyhanko.pdf_utils.misc import PdfError
    from pyhanko.sign.general import SigningError

    try:
        return bytes(signer.sign_pdf(writer).getvalue())
    except (SigningError, PdfError) as error:
        raise MetrologyError(
            Fault(str(opened.path), f"{error}", "a key that signs, and a report as it was made")
        ) from None
    except PKCS11Error as error:
        got = f"the token refused: {type(error).__name__}{f': {error}' if str(error) else ''}"
        expected = "a token that signs by ECDSA or RSA with SHA-256"
        raise MetrologyError(Fault(str(opened.path), got, expected)) from None


def _reason(person: Signatory, signer: Signer) -> str:
    reason = f"{person.role}, {person.function}"
    return f"{reason} ({MARK}: proves nothing)" if MARK in signer.certificate.issuer.rfc4514_string() else reason
