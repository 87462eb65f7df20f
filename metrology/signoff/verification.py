"""Verify a report: who signed what and when, whether anything changed, whether the inputs give what is printed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from metrology.signoff import signatures
from metrology.signoff.authority import MARK
from metrology.signoff.opened import Opened, open_report
from metrology.signoff.signatures import CLOCKS, Signature
from metrology.signoff.signing import lacking
from metrology.signoff.verdict import Check, Verdict, failed, good

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

    from metrology.identification import Signatory


def verify(
    report: Path,
    trusted: Sequence[Certificate] = (),
    *,
    rebuild: bool = True,
    templates: Path | None = None,
    progress: Callable[[str], None] = lambda _text: None,
) -> Verdict:
    """Check everything that a report's PDF claims.

    Parameters
    ----------
    report : Path
        The PDF.
    trusted : sequence of Certificate
        Authorities that you trust; a signature that leads to none of them fails.
    rebuild : bool
        Whether to evaluate the attached inputs and lay the report out again.
    templates : Path, optional
        The laboratory's own templates, where the report was made with them.
    progress : callable
        Told what is being done.

    Raises
    ------
    MetrologyError
        For what is no report of ours.
    """
    from metrology.signoff import rebuild as again

    opened = open_report(report)
    progress("signatures")
    given = signatures.read(opened, trusted)
    found = [*_people(opened, given), *_draft(opened), *_file(opened, given), *_inputs(opened)]
    if rebuild:
        found += again.checks(opened, templates, progress)
    campaign = opened.stated["campaign"]
    return Verdict(str(report), str(campaign.get("report_number", "")), str(campaign.get("title", "")), tuple(found))


def _people(opened: Opened, given: Sequence[Signature]) -> Iterator[Check]:
    """One check for everybody who has to sign, and one for every signature that nobody asked for."""
    if not opened.required:
        yield Check("signatures", "not checked", "the campaign names nobody who signs")
    for person in opened.required:
        own = [signature for signature in given if signature.role == person.role]
        yield _person(person, own[0]) if len(own) == 1 else failed(person.role, _count(person, len(own)))
    roles = [person.role for person in opened.required]
    for signature in given:
        if signature.role not in roles:
            yield failed(signature.role, f"{signature.signer} signed in a role that the campaign does not name")


def _count(person: Signatory, count: int) -> str:
    return f"{person.name}, {person.function}, has not signed" if count == 0 else f"signed {count} times"


def _person(person: Signatory, signature: Signature) -> Check:
    wrong = signature.broken or signature.untrusted
    if wrong:
        who = f"{signature.signer}: " if signature.signer else ""
        return failed(person.role, f"signature of {who}{wrong}" + (f" ({signature.note})" if signature.note else ""))
    sentence = (
        f"{person.name}, {person.function}: signed {signature.when:%Y-%m-%d %H:%M:%S %Z} with the certificate of "
    )
    notes = [note for note in (signature.note, _other_name(person, signature)) if note]
    return good(person.role, f"{sentence}{signature.signer}" + (f" ({'; '.join(notes)})" if notes else ""))


def _other_name(person: Signatory, signature: Signature) -> str:
    same = person.name.casefold().split() == signature.signer.casefold().split()
    return "" if same or MARK in signature.issuer else "that name is not the one that the campaign gives"


def _draft(opened: Opened) -> Iterator[Check]:
    """A check that fails for a draft; nothing of what cannot be told, since another version made the report."""
    try:
        missing = lacking(opened)
    except ValueError:
        return
    if missing:
        clauses = ", ".join(row.clause for row in missing)
        yield failed("state", f"a draft, which nobody can sign: its checklists ask for what is missing ({clauses})")


def _file(opened: Opened, given: Sequence[Signature]) -> Iterator[Check]:
    """Whether the file is what was written, and signatures in their order, and nothing besides."""
    faults = list(_faults(opened, given))
    yield from (failed("file", fault) for fault in faults)
    if faults or any(signature.broken for signature in given):
        return
    if given:
        yield good("file", "nothing was changed after the first signature but for the other signatures")
    else:
        yield Check("file", "not checked", "without a signature nothing tells whether it was changed")


def _faults(opened: Opened, given: Sequence[Signature]) -> Iterator[str]:
    if given and not signatures.whole(opened):
        yield "it goes on behind the last signature"
    if opened.revisions != len(given) + 1:
        yield "something else than signatures was added to the report"
    order = [person.role for person in opened.required]
    ranks = [order.index(signature.role) for signature in given if signature.role in order]
    if ranks != sorted(ranks):
        yield f"the signatures are not in the order {', '.join(order)}"
    if given and not given[0].certifying:
        yield "the first signature does not certify the report, as `metrology sign` makes it"
    if any(one.when and next_.when and one.when > next_.when + CLOCKS for one, next_ in pairwise(given)):
        yield "a later signature states an earlier time"
    names = {person.role: person.name for person in opened.required}
    for i, one in enumerate(given):
        for other in given[:i]:
            if (
                one.fingerprint
                and one.fingerprint == other.fingerprint
                and names.get(one.role) != names.get(other.role)
            ):
                yield f"{other.role} and {one.role} signed with one certificate"


def _inputs(opened: Opened) -> Iterator[Check]:
    """Whether every file that `results.json` names is attached as it was evaluated."""
    attached, count = opened.sources(), len(opened.inputs)
    missing = [file.path for file in opened.inputs if file.path not in attached]
    if not missing:
        yield good("inputs", f"all {count} files that went in are attached, as they were evaluated")
    elif len(missing) == count and not _extra(opened):
        yield Check("inputs", "not checked", "none is attached: the report was made again from results.json alone")
    else:
        yield failed("inputs", f"not attached as evaluated: {', '.join(missing)}")


def _extra(opened: Opened) -> bool:
    """Whether files are attached that could be inputs."""
    from metrology.report.attachments import MADE

    return bool(opened.attachments.keys() - MADE.keys())
