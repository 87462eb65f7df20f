"""Verify a report: who signed what and when, whether anything changed, whether the inputs give what is printed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from metrology.signoff import revisions, signatures, trail
from metrology.signoff.certificates import shared, unknown
from metrology.signoff.opened import Opened, open_report
from metrology.signoff.policy import Policy
from metrology.signoff.signatures import Signature
from metrology.signoff.signing import OTHERS, lacking
from metrology.signoff.stamps import CLOCKS, Stamp
from metrology.signoff.verdict import Check, Verdict, failed, good, unchecked

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

    from metrology.identification import Signatory


@dataclass(frozen=True)
class Again:
    """How a report is made again from its attachments.

    `templates`: the laboratory's own, where it was made with them. `allow_code`: run Python files that it names.
    """

    templates: Path | None = None
    allow_code: bool = False


def verify(
    report: Path,
    trusted: Sequence[Certificate] | Policy = (),
    *,
    require: Sequence[str] = (),
    again: Again | None = Again(),
    progress: Callable[[str], None] = lambda _text: None,
) -> Verdict:
    """Check everything that a report's PDF claims; nothing is fetched.

    Parameters
    ----------
    report : Path
        The PDF.
    trusted : sequence of Certificate, or Policy
        Authorities that you trust, or a laboratory's trust policy; a signature that leads to none of them fails.
    require : sequence of str
        Roles without whose signature the report is not good, besides those that the campaign and the policy name.
    again : Again, optional
        How to evaluate the attached inputs and lay out the report again; None not to, and nothing is then good.
    progress : callable
        Called with what is being done.

    Raises
    ------
    MetrologyError
        For what is no report of ours.
    """
    opened = open_report(report)
    policy = trusted if isinstance(trusted, Policy) else Policy(authorities=tuple(trusted))
    found = tuple(checks(opened, policy, require=require, again=again, progress=progress))
    campaign = opened.stated["campaign"]
    return Verdict(str(report), str(campaign.get("report_number", "")), str(campaign.get("title", "")), found)


def checks(
    opened: Opened,
    policy: Policy,
    *,
    require: Sequence[str] = (),
    again: Again | None = Again(),
    progress: Callable[[str], None] = lambda _text: None,
) -> Iterator[Check]:
    """Every check as it is made, those that take long last; parameters as for `verify`."""
    from metrology.signoff import rebuild

    progress("signatures")
    given, given_stamps = signatures.read_all(opened, policy)
    yield from _people(opened, given, policy, require)
    yield from _stamps(given_stamps)
    yield from _draft(opened)
    yield from _file(opened, given)
    yield from _inputs(opened)
    yield from trail.checks(opened, given)
    if again is None:
        yield unchecked("results", "not evaluated and laid out again: only the signatures were asked for")
    else:
        yield from rebuild.checks(opened, again.templates, progress, allow_code=again.allow_code)


def _people(opened: Opened, given: Sequence[Signature], policy: Policy, require: Sequence[str]) -> Iterator[Check]:
    """One check for everybody who has to sign, and one for every signature that nobody asked for."""
    named = {person.role: person for person in opened.required}
    wanted = dict.fromkeys([*named, *(policy.declared.require if policy.declared else ()), *require])
    if not wanted:
        yield unchecked("signatures", "the campaign names nobody who signs: nothing tells whose report this is")
    for role in wanted:
        own = [signature for signature in given if signature.role == role]
        if role not in named:
            yield failed(role, "a signature is required in this role, for which the campaign names nobody")
        elif len(own) != 1:
            yield failed(role, _count(named[role], len(own)))
        else:
            yield _person(named[role], own[0], policy)
    for signature in given:
        if signature.role not in wanted:
            yield failed(signature.role, f"{signature.signer} signed in a role that the campaign does not name")
    yield from _declared_otherwise(opened)


def _declared_otherwise(opened: Opened) -> Iterator[Check]:
    """A check that fails where the attached campaign file names other signatories than `results.json`."""
    if opened.declared_otherwise:
        yield failed("signatures", OTHERS)


def _count(person: Signatory, count: int) -> str:
    return f"{person.name}, {person.function}, has not signed" if count == 0 else f"signed {count} times"


def _person(person: Signatory, signature: Signature, policy: Policy) -> Check:
    against = [one.got for one in unknown(signature.certificate, person, policy)] if signature.certificate else []
    note = f" ({signature.note})" if signature.note else ""
    who = f"{signature.signer}: " if signature.signer else ""
    if wrong := signature.broken or signature.untrusted:
        return failed(person.role, f"signature of {who}{wrong}{note}")
    if against:
        return failed(person.role, f"signed with {against[0]}{note}")
    if signature.unknown:
        return unchecked(person.role, f"signature of {who}{signature.unknown}{note}")
    when = f"existed by a time stamp on {signature.proven:%Y-%m-%d %H:%M:%S %Z}" if signature.proven else "signed"
    own = f" {signature.when:%Y-%m-%d %H:%M:%S %Z}" if not signature.proven else ","
    sentence = f"{person.name}, {person.function}: {when}{own} with the certificate of {signature.signer}"
    return good(person.role, f"{sentence}{note}")


def _stamps(given: Sequence[Stamp]) -> Iterator[Check]:
    """One check for every time stamp of the document."""
    for stamp in given:
        if stamp.broken:
            yield failed("time stamp", f"{stamp.authority}: {stamp.broken}".removeprefix(": "))
        elif stamp.untrusted:
            yield unchecked("time stamp", stamp.untrusted)
        else:
            yield good(
                "time stamp", f"of {stamp.authority}: all that was there existed on {stamp.when:%Y-%m-%d %H:%M:%S %Z}"
            )


def _draft(opened: Opened) -> Iterator[Check]:
    """A check that fails for a draft; nothing where that is unknown, since another version made the report."""
    try:
        missing = lacking(opened)
    except ValueError:
        return
    if missing:
        clauses = ", ".join(row.clause for row in missing)
        yield failed("state", f"a draft, which nobody can sign: its checklists ask for what is missing ({clauses})")


def _file(opened: Opened, given: Sequence[Signature]) -> Iterator[Check]:
    """Whether the file is what was written, and signatures in their order, and nothing besides."""
    faults = [*revisions.faults(opened), *_order(opened, given)]
    yield from (failed("file", fault) for fault in faults)
    if faults or any(signature.broken for signature in given):
        return
    if given:
        yield good("file", "nothing was changed after the first signature but for other signatures and time stamps")
    else:
        yield unchecked("file", "without a signature nothing tells whether it was changed")


def _order(opened: Opened, given: Sequence[Signature]) -> Iterator[str]:
    order = [person.role for person in opened.required]
    ranks = [order.index(signature.role) for signature in given if signature.role in order]
    if ranks != sorted(ranks):
        yield f"the signatures are not in the order {', '.join(order)}"
    if given and not given[0].certifying:
        yield "the first signature does not certify the report, as `metrology sign` makes it"
    times = [signature.proven or signature.when for signature in given]
    if any(one and next_ and one > next_ + CLOCKS for one, next_ in pairwise(times)):
        yield "a later signature states an earlier time"
    names = {person.role: person.name for person in opened.required}
    certificates = {signature.role: signature.certificate for signature in given if signature.certificate}
    for one, other in shared(certificates, names):
        yield f"{one} and {other} were signed by one person, by the certificates"


def _inputs(opened: Opened) -> Iterator[Check]:
    """Whether every file that `results.json` names is attached as it was evaluated."""
    attached, count = opened.sources(), len(opened.inputs)
    missing = [file.path for file in opened.inputs if file.attached and file.path not in attached]
    hashed = [file.path for file in opened.inputs if not file.attached]
    if not missing and hashed:
        yield unchecked("inputs", f"the hash alone is there of {', '.join(hashed)}, larger than the campaign attaches")
    elif not missing:
        files = "the one file that went in is" if count == 1 else f"all {count} files that went in are"
        yield good("inputs", f"{files} attached, as evaluated")
    elif len(missing) == count and not _extra(opened):
        yield unchecked("inputs", "none is attached: the report was made again from results.json alone")
    else:
        yield failed("inputs", f"not attached as evaluated: {', '.join(missing)}")


def _extra(opened: Opened) -> bool:
    """Whether files are attached that could be inputs."""
    from metrology.report.attachments import MADE

    return bool(opened.attachments.keys() - MADE.keys())
