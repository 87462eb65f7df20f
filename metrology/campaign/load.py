"""Read a campaign file and everything that it names, without a fault, or tell all faults at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import starmap
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from metrology.campaign.branding import enter_branding
from metrology.campaign.calibration import read_certificates
from metrology.campaign.causes import alone, enter_causes
from metrology.campaign.checks import check
from metrology.campaign.copies import check_copies
from metrology.campaign.extension import check_extends
from metrology.campaign.fit_checks import check_fits
from metrology.campaign.imported import enter_results
from metrology.campaign.known_twice import differences
from metrology.campaign.masses import enter_masses
from metrology.campaign.names import collect, resolve
from metrology.campaign.own import Code
from metrology.campaign.provided import contradictions
from metrology.campaign.ranges import check_ranges
from metrology.campaign.readings import Shelf, noted
from metrology.campaign.salvage import without
from metrology.campaign.schema import Campaign
from metrology.campaign.unused import idle, unused
from metrology.declaration import fixes
from metrology.declaration.columns import SourceFile, source_file
from metrology.declaration.document import Document, parse, spell
from metrology.declaration.document import read as read_document
from metrology.declaration.entry import Refusal, refusals
from metrology.errors import Fault, MetrologyError, Notice


def load(path: Path | str, *, allow_code: bool = False) -> Campaign:
    """Return the campaign that the file `path` declares.

    Parameters
    ----------
    path : Path or str
        Campaign file.
    allow_code : bool
        Run the Python files that the campaign names under `diagnosis`, after everything else was found right.

    Raises
    ------
    MetrologyError
        Every fault of the file and of the readings that it names: first those of the campaign file, line by line, then
        those of the readings.
    """
    return of_document(read_document(Path(path)), allow_code=allow_code)


def of_document(document: Document, *, allow_code: bool = False) -> Campaign:
    """Return the campaign that a document declares; the readings lie beside its path. Errors as for `load`."""
    unread, faulty, certificates, uncorrected = read_certificates(document)
    results, imported, together = enter_results(document)
    look = enter_branding(document)
    unread += look.refusals
    faulty += look.faults
    unread += enter_causes(document)
    unread += enter_masses(document)
    campaign, wrong = _validate(document, document.data)
    wrong += unread
    rest = None
    if campaign is None:
        rest = without(
            document.data, [document.locate(refusal.loc) for refusal in wrong] + sorted(document.spoiled, key=str)
        )
        campaign = _validate(document, rest.data)[0] if rest else None
    outside: list[Fault] = []
    code: Code | None = None
    if campaign is not None:
        campaign._imported = imported
        found, outside, code = _judge(campaign)
        wrong += rest.passed_on(found) if rest else found
        campaign._files = (*campaign._files, *certificates, *results, *starmap(source_file, look.files.items()))
        campaign._look = look.files
        campaign._together = together
        campaign._notices = (*campaign._notices, *uncorrected)
    outside += faulty
    _raise(document, wrong, outside)
    assert campaign is not None
    assert code is not None
    if allow_code:
        campaign._own = code.run()
        if campaign.own:
            _raise(document, check(campaign, campaign.names), [])
    return campaign


def faults(path: Path, text: str) -> tuple[Fault, ...]:
    """Every fault of a text that is to be saved as `path`; the readings are those beside that."""
    try:
        of_document(parse(path, text.encode("utf-8", "replace")))
    except MetrologyError as error:
        return error.faults
    return ()


def _validate(document: Document, data: Any) -> tuple[Campaign | None, list[Refusal]]:
    try:
        campaign = Campaign.model_validate(data)
    except ValidationError as error:
        return None, refusals(error)
    campaign._document = document
    return campaign, []


def _judge(campaign: Campaign) -> tuple[list[Refusal], list[Fault], Code]:
    """Check what holds between the entries, and read the files: faults of the campaign file, and of the readings."""
    names = collect(campaign)
    resolve(campaign, names)
    elsewhere = list(check_extends(campaign))
    shelf, code = Shelf(campaign), Code(campaign)
    if not elsewhere:
        shelf.fetch()
        elsewhere = code.refusals
    campaign._names, campaign._tables = names, MappingProxyType(shelf.tables)
    campaign._files = (*_files(campaign), *code.files)
    campaign._notices = (*_noticed(campaign), *shelf.notices)
    outside = [*shelf.faults, *check_ranges(campaign), *check_copies(campaign)]
    return [*check(campaign, names), *elsewhere, *shelf.refusals, *check_fits(campaign)], outside, code


def _noticed(campaign: Campaign) -> Iterator[str]:
    document = campaign._document
    if document is not None:
        yield from document.notices
        # No path: results are the same in whatever folder the campaign stands.
        found = (*unused(campaign), *idle(campaign), *alone(document))
        yield from (noted(Notice(spell(place), sentence)) for place, sentence in found)
        yield from contradictions(campaign)
        yield from differences(campaign)


def _files(campaign: Campaign) -> tuple[SourceFile, ...]:
    """The campaign file and every file of readings, each once, in the order of the campaign."""
    document = campaign._document
    assert document is not None
    own = source_file(document.path.name, document.raw)
    sources = [table.source for tables in campaign._tables.values() for table in tables]
    return tuple(dict.fromkeys([own, *sources]))


def _raise(document: Document, wrong: Iterable[Refusal], outside: Iterable[Fault]) -> None:
    """Tell the faults, each once, in the order of the file; what a spoiled entry says is left out."""
    ranked = [(document.order(refusal.loc), refusal) for refusal in wrong if not document.is_spoiled(refusal.loc)]
    faults = list(document.faults)
    for order, refusal in ranked:
        where = document.at(*refusal.loc, key=refusal.of_key)
        edit = fixes.edit(document, refusal)
        faults.append((order, Fault(where, refusal.got, refusal.expected, refusal.fix, edit)))
    faults.sort(key=lambda pair: pair[0])
    everything = dict.fromkeys([*(fault for _, fault in faults), *outside])
    if everything:
        raise MetrologyError(*everything)
