"""What must hold between the entries of a campaign file: names exist, dimensions agree, dates are possible."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date
from math import inf
from typing import TYPE_CHECKING, Any

from metrology import units
from metrology.campaign.correlations import check_correlations
from metrology.campaign.diagnosis import check_diagnosis
from metrology.campaign.frequencies import check_frequencies
from metrology.campaign.judgement import RectangularPrior
from metrology.campaign.temperatures import check_temperatures
from metrology.declaration.conduct import Test
from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal, from_text, unknown
from metrology.declaration.readings import Readings
from metrology.method import Method
from metrology.methods import METHODS
from metrology.sample import section
from metrology.units.dimensions import Dimension, TextError, quoted

if TYPE_CHECKING:
    from metrology.campaign.judgement import Requirement
    from metrology.campaign.names import Names
    from metrology.campaign.schema import Campaign
    from metrology.declaration.quantity import Stated


def check(campaign: Campaign, names: Names) -> list[Refusal]:
    """Everything that is wrong between the entries, with places from the root of the file."""
    found = [*_size(campaign), *_tests(campaign), *_samples(campaign)]
    found += _replaces(campaign)
    found += _instruments(campaign)
    found += _unknown("derived", campaign)
    found += _ensembles(campaign)
    found += check_correlations(campaign, names)
    found += _comparisons(campaign, names)
    found += _requirements(campaign, names)
    found += _audit(campaign, names)
    found += check_temperatures(campaign, names)
    found += check_frequencies(campaign, names)
    found += check_diagnosis(campaign)
    return found + names.refusals


LARGEST = 200
"""Tests, fits and derived quantities in one campaign: their results, some four of a test, have 320 000 correlations."""


def _size(campaign: Campaign) -> Iterator[Refusal]:
    """Whether the correlation of every result with every other one can be kept."""
    count = len(campaign.tests) + len(campaign.fits) + len(campaign.derived)
    if count > LARGEST:
        got = f"{count} tests, fits and derived quantities"
        fix = "write a campaign for each lot: 'metrology batch' makes their reports, 'metrology collect' one table"
        yield Refusal(("tests",), got, f"at most {LARGEST}, since every correlation between their results is kept", fix)


DENSITIES = (100.0, 22600.0)
"""kg/m³: from a loose braid, most of whose section is air, to osmium, the densest material."""
FILLED = 2.0
"""Ratio of mass per length over section to the density of the material beyond which one of the three is wrong: braids
fill half of their section and more."""


def _samples(campaign: Campaign) -> Iterator[Refusal]:
    """Density of the material, and mass per length over section, against each other and against any material."""
    for name, sample in campaign.samples.items():
        if sample.density is not None and not DENSITIES[0] <= sample.density.si <= DENSITIES[1]:
            got, expected = quoted(sample.density.value), f"{DENSITIES[0]:.4g} kg/m^3 to {DENSITIES[1]:.4g} kg/m^3"
            yield Refusal(("samples", name, "density"), got, expected, "check the number and its unit")
        if sample.section is None or sample.linear_density is None:
            continue
        shape = section(sample.section.shape)
        area = shape.area(*(getattr(sample.section, dimension).si for dimension in shape.dimensions))
        density = sample.linear_density.si / area if area > 0 else inf
        low, high = DENSITIES
        if sample.density is not None and sample.density.si > 0:
            low, high = sample.density.si / FILLED, sample.density.si * FILLED
        if not low <= density <= high:
            got = f"{quoted(sample.linear_density.value)} over a section of {1e6 * area:.4g} mm^2, {density:.3g} kg/m^3"
            expected = f"{low:.4g} kg/m^3 to {high:.4g} kg/m^3"
            yield Refusal(("samples", name, "linear_density"), got, expected, "check the section and the units")


def _unknown(part: str, campaign: Campaign) -> Iterator[Refusal]:
    for index, derived in enumerate(campaign.derived):
        if derived.sample is not None:
            yield from unknown(derived.sample, list(campaign.samples), "sample", part, index, "sample")


def _tests(campaign: Campaign) -> Iterator[Refusal]:
    for name, test in campaign.tests.items():
        place = ("tests", name)
        yield from unknown(test.sample, list(campaign.samples), "sample", *place, "sample")
        for role, instrument in test.instruments:
            if instrument is not None:
                yield from unknown(instrument, list(campaign.instruments), "instrument", *place, "instruments", role)
        yield from _dates(campaign, name, test)
        yield from _exclusions(test, place)
        yield from _accepted(test, place)
        yield from METHODS[test.method].check(campaign, name, test)


def _accepted(test: Test, place: Place) -> Iterator[Refusal]:
    """One person answers for a check: of two the report would name one."""
    seen: set[str] = set()
    for index, one in enumerate(test.accepted):
        if one.check in seen:
            where = (*place, "accepted", index, "check")
            yield Refusal(where, f"'{one.check}' a second time", "every check accepted once", "keep one of the two")
        seen.add(one.check)


def _exclusions(test: Test, place: Place) -> Iterator[Refusal]:
    """Some methods leave a file of readings out as a whole, the others single lines."""
    method = METHODS[test.method]
    for index, exclusion in enumerate(test.exclusions):
        where = (*place, "exclusions", index)
        if not method.whole:
            if exclusion.line is None:
                yield Refusal(where, "no 'line'", "the line of the reading that is not used")
        elif exclusion.line is not None:
            got = f"a line of a {method.title.lower()}, in which a gap cannot stand"
            yield Refusal((*where, "line"), got, f"a whole {method.whole}, by its 'file'", "leave 'line' out")
        elif exclusion.file is None:
            files = ", ".join(_names(method, str(place[1]), test))
            yield Refusal(where, "no 'file'", f"a {method.whole}, one of {files}")


def _names(method: Method[Any, Any], name: str, test: Test) -> Iterator[str]:
    """Names of the readings of a test."""
    for files in method.readings(name, test):
        for _, stated in files.files:
            yield Readings.model_validate(stated).name


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


def _instruments(campaign: Campaign) -> Iterator[Refusal]:
    for name, instrument in campaign.instruments.items():
        if instrument.correction is not None and instrument.correction.fit is not None:
            place = ("instruments", name, "correction", "fit")
            yield from unknown(instrument.correction.fit, list(campaign.fits), "fit", *place)
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
                yield from unknown(member, list(ensemble.columns), "column", *place, key, member)
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
