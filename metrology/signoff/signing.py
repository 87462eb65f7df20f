"""Sign a report in a role: PAdES, the first signature certifying; the file is replaced whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology import audit_trail
from metrology.campaign import days
from metrology.errors import Fault, MetrologyError
from metrology.report import recorded, staging
from metrology.signoff import evidence, revisions, signatures, trail
from metrology.signoff.authority import MARK
from metrology.signoff.certificates import common_name, fingerprint, objections, shared, unknown
from metrology.signoff.keys import as_asn1
from metrology.signoff.opened import RESULTS, Opened, open_report
from metrology.signoff.policy import Policy

if TYPE_CHECKING:
    from metrology.checklist import Row
    from metrology.identification import Signatory
    from metrology.signoff.keys import Signer
    from metrology.signoff.signatures import Signature

OTHERS = "the attached campaign file names others who sign than results.json does"


@dataclass(frozen=True)
class Stamping:
    """Whose time stamps a signature gets.

    Parameters
    ----------
    stamper : pyhanko TimeStamper
        Who gives them.
    long_term : bool
        Whether the file takes in lists of revoked certificates and a time stamp of the whole, too (PAdES B-LTA).
    """

    stamper: Any
    long_term: bool = False


def sign(
    report: Path, role: str, signer: Signer, *, policy: Policy | None = None, stamping: Stamping | None = None
) -> Opened:
    """Add the signature of a role to a report's PDF, and return the report as it was before.

    Parameters
    ----------
    report : Path
        Replaced by its signed form, which begins with the very bytes that it had.
    role : str
        One that the campaign names, and that nobody has signed in yet.
    signer : Signer
        Key and certificate.
    policy : Policy, optional
        What the laboratory accepts: what `verify` would fail by it is refused.
    stamping : Stamping, optional
        For a signature with a time stamp.

    Raises
    ------
    MetrologyError
        For a report that is none of ours, was changed, is a draft, is dated after today, does not name the role, was
        signed in it already or not yet in one before it; for a certificate that is not that of the person named, that
        somebody else signed with, or that `verify` would not rely on; where no time stamp is to be had, or the file
        cannot be written.
    """
    report = report.resolve()
    with staging.locked(report):
        opened = open_report(report)
        policy = policy or Policy()
        person = _person(opened, role)
        given = signatures.read(opened, policy)
        _refuse_out_of_turn(opened, given, role)
        _refuse_certificate(opened, given, person, signer, policy)
        _refuse_unstamped(opened, policy, stamping)
        _refuse_changed(opened, given)
        refuse_draft(opened)
        _refuse_early(opened)
        entries = audit_trail.read(report.parent / audit_trail.NAME)
        made = _signed(opened, _reason(person, signer, trail.anchor(entries)), person, signer, policy, stamping)
        # The line comes first: a signature without one would look like somebody else's.
        detail = f"{role}: {common_name(signer.certificate)}, {fingerprint(signer.certificate)}"
        if entries:
            line = recorded.line(report.parent, "sign", {report.name: made}, detail=detail)
            staging.replace_file(report.parent / audit_trail.NAME, line[audit_trail.NAME])
        staging.replace_file(report, made)
    return opened


def _person(opened: Opened, role: str) -> Signatory:
    named = {person.role: person for person in opened.required}
    if role not in named:
        expected = f"one of {', '.join(named)}" if named else "a campaign that says who signs"
        fix = "name the person under `report.signatures` of the campaign, and make the report anew"
        raise MetrologyError(Fault(str(opened.path), f"the role '{role}'", expected, fix))
    return named[role]


def _refuse_out_of_turn(opened: Opened, given: Sequence[Signature], role: str) -> None:
    """Refuse a role signed already, and one whose turn has not come."""
    signed = [signature.role for signature in given]
    names = [person.role for person in opened.required]
    where = str(opened.path)
    if role in signed:
        raise MetrologyError(Fault(where, f"a report that is signed as {role}", "a role that nobody has signed in yet"))
    missing = [before for before in names[: names.index(role)] if before not in signed]
    if missing:
        got = f"a report without the signature of the {missing[0]}"
        raise MetrologyError(Fault(where, got, f"signatures in the order {', '.join(names)}"))


def _refuse_certificate(
    opened: Opened, given: Sequence[Signature], person: Signatory, signer: Signer, policy: Policy
) -> None:
    """Refuse what `verify` would fail: all of it at once."""
    certificate, now = signer.certificate, evidence.now()
    found = [Fault("certificate", one.got, one.expected) for one in objections(certificate, policy, now)]
    known = evidence.gather(policy, opened)
    if revoked := known.revoked(certificate):
        found.append(Fault("certificate", f"one that was revoked on {revoked:%Y-%m-%d}", "one that holds"))
    names = {one.role: one.name for one in opened.required}
    certificates = {one.role: one.certificate for one in given if one.certificate} | {person.role: certificate}
    for other, role in shared(certificates, names):
        if person.role in (other, role):
            got = f"the certificate that signed as {other}, or another one of that person"
            found.append(Fault("certificate", got, f"a certificate of {person.name}"))
    found += [Fault("certificate", one.got, one.expected) for one in unknown(certificate, person, policy)]
    found += _untrusted(signer, known) if policy.authorities and not found else ()
    if found:
        raise MetrologyError(*found)


def _untrusted(signer: Signer, known: evidence.Evidence) -> Iterator[Fault]:
    """A certificate that leads to no authority of the policy, or that no list of revoked ones covers."""
    import asyncio

    from pyhanko_certvalidator import CertificateValidator
    from pyhanko_certvalidator.errors import PathBuildingError, ValidationError

    others = list(signer.pyhanko.cert_registry)
    context = known.context(evidence.now())
    validator = CertificateValidator(as_asn1(signer.certificate), intermediate_certs=others, validation_context=context)
    try:
        with signatures.quiet():
            asyncio.run(validator.async_validate_path())
    except PathBuildingError:
        yield Fault("certificate", "one that leads to no authority of the trust policy", "one issued by such")
    except ValidationError as error:
        yield Fault("certificate", f"one that does not hold: {error}", "one that holds by the trust policy")


def _refuse_unstamped(opened: Opened, policy: Policy, stamping: Stamping | None) -> None:
    if policy.stamped and stamping is None:
        expected = "a time stamp, which the trust policy asks for"
        raise MetrologyError(Fault(str(opened.path), "a signature without a time stamp", expected, "give --tsa"))


def _refuse_changed(opened: Opened, given: Sequence[Signature]) -> None:
    """Refuse a file that is not what `metrology report` and earlier signatures left."""
    faults = [f"the signature as {s.role} does not hold: {s.broken}" for s in given if s.broken]
    faults += revisions.faults(opened)
    faults += [OTHERS] if opened.declared_otherwise else []
    # Once signed here the trail would know it.
    faults += [f"{trail.SUBJECT}: {check.sentence}" for check in trail.checks(opened, given) if check.state == "failed"]
    attached = opened.sources()
    if attached:
        faults += [
            f"{file.path} is not attached as it was evaluated"
            for file in opened.inputs
            if file.attached and file.path not in attached
        ]
    if faults:
        expected, fix = "the report as it was written", "make the report anew, and sign that"
        raise MetrologyError(*(Fault(str(opened.path), fault, expected, fix) for fault in faults))


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
        fix = "sign with the version that made it, or make the report anew"
        got = "a report of another version of this software"
        raise MetrologyError(Fault(str(opened.path), got, "a report that this one reads", fix)) from None
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


def _refuse_early(opened: Opened) -> None:
    """Refuse a report that is dated after today: what it says to have been issued has not been."""
    issued = opened.stated["campaign"]["issued"]
    if issued and date.fromisoformat(issued) > days.today():
        fix = "correct `report.issued`, or the clock of this computer, and make the report anew"
        raise MetrologyError(Fault(str(opened.path), f"a report of {issued}", "one that is not dated after today", fix))


def _signed(
    opened: Opened, reason: str, person: Signatory, signer: Signer, policy: Policy, stamping: Stamping | None
) -> bytes:
    from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
    from pyhanko.sign import fields
    from pyhanko.sign.signers import PdfSignatureMetadata, PdfSigner

    first = not signatures.roles(opened)
    long_term = stamping is not None and stamping.long_term
    metadata = PdfSignatureMetadata(
        field_name=person.role,
        name=person.name,
        reason=reason,
        md_algorithm="sha256",
        subfilter=fields.SigSeedSubFilter.PADES,
        certify=first,
        docmdp_permissions=fields.MDPPerm.FILL_FORMS,
        signer_key_usage={"digital_signature", "non_repudiation"},
        embed_validation_info=long_term,
        use_pades_lta=long_term,
        validation_context=_context(opened, policy) if long_term else None,
    )
    writer = IncrementalPdfFileWriter(BytesIO(opened.content))
    field = fields.SigFieldSpec(sig_field_name=person.role)
    stamper = stamping.stamper if stamping else None
    made = _run(PdfSigner(metadata, signer.pyhanko, timestamper=stamper, new_field_spec=field), writer, opened)
    assert made.startswith(opened.content)
    return made


def _context(opened: Opened, policy: Policy) -> Any:
    """For PAdES B-LTA: who is trusted, for signatures and for time stamps; lists of revoked ones may be fetched."""
    known = evidence.gather(policy, opened)
    both = Policy(policy.declared, (*policy.authorities, *policy.stamping), (), policy.lists, policy.responses)
    whole = evidence.Evidence(both, known.certificates, known.lists, known.responses)
    return whole.context(evidence.now(), fetch=True)


def _run(signer: Any, writer: Any, opened: Opened) -> bytes:
    from pkcs11.exceptions import PKCS11Error
    from pyhanko.pdf_utils.misc import PdfError
    from pyhanko.sign.general import SigningError
    from pyhanko.sign.timestamps.common_utils import TimestampRequestError

    where = str(opened.path)
    try:
        with signatures.quiet():
            return bytes(signer.sign_pdf(writer).getvalue())
    except TimestampRequestError as error:
        got = f"no time stamp ({' '.join(str(error).split())})"
        raise MetrologyError(Fault("--tsa", got, "the address of a time-stamping authority that answers")) from None
    except (SigningError, PdfError) as error:
        raise MetrologyError(Fault(where, f"{error}", "a key that signs, and a report as it was made")) from None
    except PKCS11Error as error:
        got = f"the token refused: {type(error).__name__}{f': {error}' if str(error) else ''}"
        raise MetrologyError(Fault(where, got, "a token that signs by ECDSA or RSA with SHA-256")) from None


def _reason(person: Signatory, signer: Signer, anchor: str) -> str:
    test = f" ({MARK}: proves nothing)" if MARK in signer.certificate.issuer.rfc4514_string() else ""
    return f"{person.role}, {person.function}{test}{f'; {anchor}' if anchor else ''}"
