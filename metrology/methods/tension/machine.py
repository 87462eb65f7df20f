"""What every test in a testing machine asks of its campaign: a record for each specimen, instruments of known class."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from metrology.declaration.entry import Refusal
from metrology.methods.tension.preparation import CELL, EXTENSOMETER
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.method.declared import Declared


def specimens(name: str, files: Mapping[str, str], excluded: Iterable[str | None]) -> Iterator[Refusal]:
    """Specimens that are there, each with a record of its own, and not all of them excluded.

    Parameters
    ----------
    name : str
        Test.
    files : mapping of str to str
        Specimen → name of its file.
    excluded : iterable of str or None
        Files that the campaign excludes; None where an exclusion names no file.
    """
    place = ("tests", name)
    if not files:
        yield Refusal((*place, "specimens"), "no specimen", "at least one")
    seen: dict[str, str] = {}
    for specimen, file in files.items():
        if file in seen:
            where = (*place, "specimens", specimen, "readings")
            yield Refusal(where, f"{quoted(file)}, as of '{seen[file]}'", "a record of its own for each specimen")
        seen.setdefault(file, specimen)
    if seen and {*excluded} >= seen.keys():
        yield Refusal((*place, "exclusions"), "every specimen", "at least one that is used")


def gauge(campaign: Declared, name: str, test: Any) -> Iterator[Refusal]:
    """Gauge length that lies on every specimen.

    Parameters
    ----------
    campaign : Declared
        With its samples.
    name, test : str, test in a testing machine
        With `sample`, `specimens`, `gauge_length`.
    """
    sample, stated = campaign.samples.get(test.sample), test.gauge_length
    own = sample.length if sample is not None else None
    free = [length.si for one in test.specimens.values() if (length := one.length or own) is not None]
    if stated is not None and free and stated.si > min(free):
        got = f"{quoted(stated.value)}, and a free length of {min(free):.4g} m"
        yield Refusal(("tests", name, "gauge_length"), got, "a gauge that lies on the specimen", "check the units")


def classes(
    campaign: Declared, name: str, used: Iterable[tuple[str, str]], unclassed: Container[str] = ()
) -> Iterator[Refusal]:
    """Classes of the standards, where no certificate states what an instrument errs by.

    Parameters
    ----------
    campaign : Declared
        With its instruments.
    name : str
        Test.
    used : iterable of (str, str)
        Role and instrument.
    unclassed : container of str
        Roles that need neither class nor certificate.
    """
    for role, instrument in used:
        stated = campaign.instruments.get(instrument)
        if stated is None:
            continue
        known, standard = (CELL, "ISO 7500-1") if role == "force" else (EXTENSOMETER, "ISO 9513")
        where = ("tests", name, "instruments", role)
        if stated.class_ and stated.class_ not in known:
            got = f"'{instrument}', of class {quoted(stated.class_)}"
            yield Refusal(where, got, f"a class of {standard}: {', '.join(known)}; or 'certificate' alone")
        if not stated.class_ and stated.certificate is None and role not in unclassed:
            got = f"'{instrument}', of which neither class nor certificate is stated"
            yield Refusal(where, got, f"its class to {standard}, such as 'class: {list(known)[1]}', or a certificate")
