"""What must hold between the entries of a campaign file: names exist, dimensions agree, dates are possible."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date
from typing import TYPE_CHECKING

from metrology import units
from metrology.campaign.correlations import check_correlations
from metrology.campaign.diagnosis import check_diagnosis
from metrology.campaign.document import Place
from metrology.campaign.entry import Refusal, from_text, mean
from metrology.campaign.judgement import RectangularPrior
from metrology.campaign.methods import AnyTest, DecayTest, ElongationTest, ResponseTest, Test
from metrology.campaign.response_checks import check_response
from metrology.elongation import LEAST_LOADS
from metrology.units.dimensions import Dimension, TextError, quoted

if TYPE_CHECKING:
    from metrology.campaign.judgement import Requirement
    from metrology.campaign.names import Names
    from metrology.campaign.quantity import Stated
    from metrology.campaign.schema import Campaign


def check(campaign: Campaign, names: Names) -> list[Refusal]:
    """Everything that is wrong between the entries, with places from the root of the file."""
    found = list(_tests(campaign))
    found += _replaces(campaign)
    found += _instruments(campaign)
    found += _unknown("derived", campaign)
    found += _ensembles(campaign)
    found += check_correlations(campaign, names)
    found += _comparisons(campaign, names)
    found += _requirements(campaign, names)
    found += _audit(campaign, names)
    found += check_diagnosis(campaign)
    return found + names.refusals


def _known(word: str, choices: list[str], what: str, *place: str | int) -> Iterator[Refusal]:
    if word not in choices:
        near = mean(word, choices) or (f"known are {', '.join(choices[:12])}" if choices else f"no {what} is declared")
        yield Refusal(
            place,
            f"'{word}', an unknown {what}",
            f"the name of {'an' if what[0] in 'aeiou' else 'a'} {what} of this campaign",
            near,
            word,
        )


def _unknown(section: str, campaign: Campaign) -> Iterator[Refusal]:
    for index, derived in enumerate(campaign.derived):
        if derived.sample is not None:
            yield from _known(derived.sample, list(campaign.samples), "sample", section, index, "sample")


def _tests(campaign: Campaign) -> Iterator[Refusal]:
    for name, test in campaign.tests.items():
        place = ("tests", name)
        yield from _known(test.sample, list(campaign.samples), "sample", *place, "sample")
        for role, instrument in getattr(test, "instruments", ()):
            if instrument is not None:
                yield from _known(instrument, list(campaign.instruments), "instrument", *place, "instruments", role)
        yield from _dates(campaign, name, test)
        yield from _exclusions(test, place)
        if isinstance(test, ElongationTest):
            yield from _elongation(campaign, name, test)
        elif isinstance(test, DecayTest):
            yield from _decay(campaign, name, test)
        elif isinstance(test, ResponseTest):
            yield from check_response(campaign, name, test)


def _exclusions(test: AnyTest, place: Place) -> Iterator[Refusal]:
    """A release of a free decay is left out as a whole, of everything else single lines."""
    for index, exclusion in enumerate(test.exclusions):
        where = (*place, "exclusions", index)
        if isinstance(test, DecayTest) and exclusion.line is not None:
            got, mend = "a line of a free decay, in which a gap cannot stand", "leave 'line' out"
            yield Refusal((*where, "line"), got, "a whole release, by its 'file'", mend)
        elif isinstance(test, DecayTest) and exclusion.file is None:
            yield Refusal(where, "no 'file'", f"a release, one of {', '.join(test.readings)}")
        elif not isinstance(test, DecayTest) and exclusion.line is None:
            yield Refusal(where, "no 'line'", "the line of the reading that is not used")


def _dates(campaign: Campaign, name: str, test: Test) -> Iterator[Refusal]:
    if test.date is None:
        return
    sample = campaign.samples.get(test.sample)
    yield from _not_before(
        test.date, sample.received if sample else None, "the sample's receipt", "tests", name, "date"
    )
    if campaign.report.issued is not None and campaign.report.issued < test.date:
        got = f"'{campaign.report.issued}', before test '{name}' of {test.date}"
        yield Refusal(("report", "issued"), got, "a day on or after the last test")


def _replaces(campaign: Campaign) -> Iterator[Refusal]:
    older, issued = campaign.report.replaces, campaign.report.issued
    if older is not None and older.number == campaign.report.number:
        yield Refusal(
            ("report", "replaces", "number"), f"'{older.number}', this report's own number", "the older one's"
        )
    if older is not None and issued is not None and older.date > issued:
        got = f"'{older.date}', after this report's issue on {issued}"
        yield Refusal(("report", "replaces", "date"), got, "the older report's date of issue")


def _not_before(day: date, earliest: date | None, event: str, *place: str | int) -> Iterator[Refusal]:
    if earliest is not None and day < earliest:
        yield Refusal(place, f"'{day}', before {event} on {earliest}", f"a day on or after {earliest}")


def _elongation(campaign: Campaign, name: str, test: ElongationTest) -> Iterator[Refusal]:
    place = ("tests", name)
    if len(test.loads) < LEAST_LOADS:
        yield Refusal((*place, "loads"), f"{_count(len(test.loads), 'load')}", "at least three loads")
    by_mass = [load for load in test.loads.values() if load.mass is not None]
    if by_mass and test.gravity is None:
        expected = "'gravity', such as '9.8060(5) m/s^2', or loads as forces"
        yield Refusal(place, "loads as masses without 'gravity'", expected)
    seen: dict[tuple[bool, float], str] = {}
    for load, stated in test.loads.items():
        quantity = stated.mass or stated.force
        key = (stated.mass is not None, quantity.si if quantity else 0.0)
        if key in seen:
            yield Refusal((*place, "loads", load), f"the load of '{seen[key]}' a second time", "loads that differ")
        seen.setdefault(key, load)
    yield from _reads(campaign, test.instruments.extension, "m", *place, "instruments", "extension")


def _decay(campaign: Campaign, name: str, test: DecayTest) -> Iterator[Refusal]:
    place = ("tests", name)
    for index, file in enumerate(test.readings):
        if file in test.readings[:index]:
            yield Refusal((*place, "readings", index), f"{quoted(file)} a second time", "every release once")
    if not test.readings:
        yield Refusal((*place, "readings"), "an empty list", "at least one CSV file")
    if test.readings and {exclusion.file for exclusion in test.exclusions} >= set(test.readings):
        yield Refusal((*place, "exclusions"), "every release", "at least one release that is used")
    if test.stiffness is None:
        return
    if test.inertia is not None:
        yield Refusal((*place, "stiffness"), f"'{test.stiffness}' with 'inertia'", "none: k in N·m/rad is its own")
        return
    choices = [other for other, stated in campaign.tests.items() if stated.method == "elongation"]
    yield from _known(test.stiffness, choices, "elongation test", *place, "stiffness")
    known = test.stiffness in choices and test.sample in campaign.samples
    if known and campaign.tests[test.stiffness].sample != test.sample:
        other = campaign.tests[test.stiffness].sample
        yield Refusal(
            (*place, "stiffness"),
            f"'{test.stiffness}', a test of sample '{other}'",
            f"an elongation test of '{test.sample}'",
        )


def _reads(campaign: Campaign, instrument: str, unit: str, *place: str | int) -> Iterator[Refusal]:
    """The instrument must have a resolution of the dimension of `unit`."""
    stated = campaign.instruments.get(instrument)
    if stated is None:
        return
    due = units.dimension(unit)
    if stated.resolution is None:
        expected = f"an instrument with 'resolution', {due.name}"
        yield Refusal(
            place,
            f"'{instrument}', of which no resolution is stated",
            expected,
            f"add it under instruments.{instrument}",
        )
    elif stated.resolution.dimension != due:
        got = f"'{instrument}', with a resolution of '{stated.resolution.value}'"
        yield Refusal(place, got, f"an instrument that reads {due.name}")


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"


def _instruments(campaign: Campaign) -> Iterator[Refusal]:
    for name, instrument in campaign.instruments.items():
        if instrument.correction is not None and instrument.correction.fit is not None:
            place = ("instruments", name, "correction", "fit")
            yield from _known(instrument.correction.fit, list(campaign.fits), "fit", *place)
        certificate = instrument.certificate
        stated = certificate.expanded_uncertainty if certificate else None
        if (
            stated is not None
            and instrument.resolution is not None
            and stated.dimension != instrument.resolution.dimension
            and not stated.dimension.dimensionless
        ):
            place = ("instruments", name, "certificate", "expanded_uncertainty")
            due = instrument.resolution.dimension.name
            yield Refusal(place, f"'{stated.value}', {stated.dimension.name}", f"{due}, as the resolution")


def _ensembles(campaign: Campaign) -> Iterator[Refusal]:
    for name, ensemble in campaign.ensembles.items():
        place = ("ensembles", name)
        for key in ("uncertainty", "descriptions"):
            for member in getattr(ensemble, key):
                yield from _known(member, list(ensemble.columns), "column", *place, key, member)
        if not ensemble.columns:
            yield Refusal((*place, "columns"), "no column", "at least one, such as 'V: \"V / V\"'")
        for member, components in ensemble.uncertainty.items():
            yield from _component_units(components, ensemble.columns.get(member, ""), (*place, "uncertainty", member))


def _component_units(components: tuple[object, ...], heading: str, place: Place) -> Iterator[Refusal]:
    unit = heading.partition("/")[2].strip() or "1"
    for index, component in enumerate(components):
        for key in ("standard", "half_width", "expanded", "scale", "limit_half_width"):
            text = getattr(component, key)
            try:
                amount = None if text is None else units.parse(text, expected=unit, difference=True)
            except TextError as error:
                yield from_text(error, *place, index, key)
                continue
            if amount is not None and amount.value <= 0:
                yield Refusal((*place, index, key), quoted(text), "an uncertainty greater than zero")


def _agree(dimension: Dimension | None, stated: Stated | None, *place: str | int) -> Iterator[Refusal]:
    if dimension is not None and stated is not None and stated.dimension != dimension:
        yield Refusal(place, f"'{stated.value}', {stated.dimension.name}", f"{dimension.name}, as the quantity")


def _comparisons(campaign: Campaign, names: Names) -> Iterator[Refusal]:
    for index, comparison in enumerate(campaign.comparisons):
        place = ("comparisons", index, "between")
        found = [
            side.value.dimension if side.value is not None else names.look_up(side.quantity or "", *place, number)
            for number, side in enumerate(comparison.between)
        ]
        if None not in found and found[0] != found[1]:
            got = f"{found[0].name} and {found[1].name}" if found[0] and found[1] else ""
            yield Refusal(place, got, "two quantities of one dimension")


def _requirements(campaign: Campaign, names: Names) -> Iterator[Refusal]:
    seen: set[str] = set()
    for index, requirement in enumerate(campaign.requirements):
        place = ("requirements", index)
        if requirement.id in seen:
            yield Refusal(
                (*place, "id"), f"'{requirement.id}' a second time", "every requirement with an id of its own"
            )
        seen.add(requirement.id)
        dimension = names.look_up(requirement.quantity, *place, "quantity")
        yield from _agree(dimension, requirement.limits.lower, *place, "limits", "lower")
        yield from _agree(dimension, requirement.limits.upper, *place, "limits", "upper")
        yield from _prior(requirement, dimension, place)
        yield from _agreed(campaign, requirement, place)


def _agreed(campaign: Campaign, requirement: Requirement, place: Place) -> Iterator[Refusal]:
    """A rule is agreed before the test whose result it judges, or before the first test."""
    test = campaign.tests.get(requirement.quantity.partition(".")[0])
    days = [each.date for each in ([test] if test else campaign.tests.values()) if each.date is not None]
    agreed = requirement.decision.agreed
    if agreed is not None and days and agreed > min(days):
        got = f"'{agreed}', after the test of {min(days)}"
        expected = "a day on or before the test: a decision rule is agreed before its result is known"
        yield Refusal((*place, "decision", "agreed"), got, expected)


def _prior(requirement: Requirement, dimension: Dimension | None, place: Place) -> Iterator[Refusal]:
    prior = requirement.prior
    for key in ("mean", "standard", "scale", "median", "low", "high"):
        stated = getattr(prior, key, None)
        yield from _agree(dimension, stated, *place, "prior", key)
        if stated is not None and stated.si <= 0 and key in ("standard", "scale", "median"):
            yield Refusal((*place, "prior", key), quoted(stated.value), "a number greater than zero")
    if isinstance(prior, RectangularPrior) and prior.low.si >= prior.high.si:
        yield Refusal((*place, "prior", "high"), quoted(prior.high.value), "an upper end above 'low'")
    if requirement.decision.rule == "global risk" and prior is None:
        yield Refusal(
            (*place, "decision"), "'global risk' without 'prior'", "what is known about the items, under 'prior'"
        )


def _audit(campaign: Campaign, names: Names) -> Iterator[Refusal]:
    for index, audit in enumerate(campaign.audit):
        if audit.quantity is not None:
            dimension = names.look_up(audit.quantity, "audit", index, "quantity")
            yield from _agree(dimension, audit.published, "audit", index, "published")
