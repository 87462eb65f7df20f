"""Places of a campaign file that may lack something, as the functions that an item is made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from operator import attrgetter

from metrology.checklist.record import Record
from metrology.message import said

Lacks = Callable[[Record], Iterator[str]]
Spared = Callable[[Record], str]


def campaign(*keys: str) -> Lacks:
    """Name the keys of the campaign that are empty: place in the file, or ``attribute=place`` where the two differ."""
    pairs = [key.split("=") if "=" in key else (key, key) for key in keys]

    def lacks(record: Record) -> Iterator[str]:
        return (place for attribute, place in pairs if not attrgetter(attribute)(record.campaign))

    return lacks


def stated(*keys: str) -> Lacks:
    """Name the lists that the campaign does not state, not even as ``none``."""

    def lacks(record: Record) -> Iterator[str]:
        return (key for key in keys if key not in record.campaign.stated)

    return lacks


def each(section: str, *keys: str) -> Lacks:
    """Name what is empty in the entries of ``samples`` or ``tests``."""

    def lacks(record: Record) -> Iterator[str]:
        entries = getattr(record, section)
        return (f"{section}.{entry.id}.{key}" for entry in entries for key in keys if not getattr(entry, key))

    return lacks


def requirements(key: str, place: str) -> Lacks:
    """Name the requirements that lack a key."""

    def lacks(record: Record) -> Iterator[str]:
        return (f"requirements.{demand.id}.{place}" for demand in record.demands if not getattr(demand, key))

    return lacks


def together(*parts: Lacks) -> Lacks:
    """Name what any of the parts names."""

    def lacks(record: Record) -> Iterator[str]:
        return (place for part in parts for place in part(record))

    return lacks


def deviations(record: Record) -> Iterator[str]:
    """Name the tests of which nobody says whether they deviated; one word for the whole campaign is enough."""
    if "deviations" in record.campaign.stated:
        return iter(())
    return (f"tests.{test.id}.deviations" for test in record.tests if not test.deviations_stated)


def results(record: Record) -> Iterator[str]:
    """Name the want of any result."""
    return iter(() if record.results else (said("a result with an uncertainty"),))


def without(section: str, reason: str) -> Spared:
    """Spare a campaign that has no entry of a section."""
    return lambda record: "" if getattr(record, section) else reason
