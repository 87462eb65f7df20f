"""The names of a campaign's quantities, each with its dimension, and what a name in an expression means.

::

    <quantity>                          of `quantities` and `ensembles`
    <sample>.<property>                 length, linear_density, those of the section, and A, the area of the section
    <instrument>.correction             where the correction is a quantity
    <test>.<result>                     what its method yields
    <fit>.<parameter>, <fit>.<point>    intercept and slope, or the parameters of the expression; points of `predict`
    <quantity>, <sample>.<quantity>     of `derived`
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from metrology import units
from metrology.declaration.document import Place
from metrology.declaration.entry import Refusal, from_text, mean
from metrology.expression import RESERVED, Expression
from metrology.methods import METHODS
from metrology.units.dimensions import Dimension, TextError, quoted

if TYPE_CHECKING:
    from metrology.campaign.judgement import Audit, Derived
    from metrology.campaign.schema import Campaign
    from metrology.declaration.fits import Axis, Fit


@dataclass
class Names:
    """Every name of a campaign.

    Parameters
    ----------
    dimensions : mapping of str to Dimension or None
        By full name; None where the dimension cannot be told for a fault that stands elsewhere.
    places : mapping of str to tuple
        Where each is declared.
    order : list of Derived
        Derived quantities, each after those that it needs.
    meanings : mapping of tuple to dict
        Full name behind each name of an expression, by the place of the entry: ``("derived", 0)``.
    refusals : list of Refusal
        What is wrong, with places from the root of the file.
    """

    dimensions: dict[str, Dimension | None] = field(default_factory=dict)
    places: dict[str, Place] = field(default_factory=dict)
    order: list[Derived] = field(default_factory=list)
    meanings: dict[Place, dict[str, str]] = field(default_factory=dict)
    refusals: list[Refusal] = field(default_factory=list)

    def add(self, name: str, dimension: Dimension | None, *place: str | int) -> None:
        """Declare a name, once, and none of the words of the expression language."""
        if name in RESERVED:
            self.refuse(
                place, quoted(name), "a name that is no function or constant of expressions", f"write '{name}_1'"
            )
        elif name in self.dimensions:
            other = ".".join(str(key) for key in self.places[name])
            self.refuse(place, f"'{name}' a second time", f"another name: it is declared in {other}")
        else:
            self.dimensions[name], self.places[name] = dimension, place

    def refuse(self, place: Place, got: str, expected: str, fix: str = "", *, missing: str = "") -> None:
        """Note what is wrong at a place."""
        self.refusals.append(Refusal(place, got, expected, fix, missing))

    def look_up(self, name: str, *place: str | int) -> Dimension | None:
        """Dimension of a quantity; a fault at `place` where there is none of that name."""
        if name not in self.dimensions:
            known = list(self.dimensions)
            near = mean(name, known) or (f"known are {', '.join(known[:12])}" if known else "no quantity is declared")
            self.refuse(
                place, f"'{name}', an unknown quantity", "the name of a quantity of this campaign", near, missing=name
            )
            return None
        return self.dimensions[name]


def collect(campaign: Campaign) -> Names:
    """Return every name that the campaign declares, except derived quantities; `resolve` adds those."""
    names = Names()
    for name, stated in campaign.quantities.items():
        names.add(name, stated.dimension, "quantities", name)
    for set_name, ensemble in campaign.ensembles.items():
        for name, heading in ensemble.columns.items():
            names.add(name, heading_dimension(heading), "ensembles", set_name, "columns", name)
            for factor in (*ensemble.strata, "within") if ensemble.factors else ():
                names.add(f"{set_name}.s_{factor}", heading_dimension(heading), "ensembles", set_name)
    _collect_samples(campaign, names)
    _collect_corrections(campaign, names)
    for name, test in campaign.tests.items():
        for result, unit in METHODS[test.method].yields(campaign, test).items():
            names.add(f"{name}.{result}", units.dimension(unit), "tests", name)
    for name, fit in campaign.fits.items():
        for parameter, dimension in _of_fit(fit):
            names.add(f"{name}.{parameter}", dimension, "fits", name)
    return names


def _collect_corrections(campaign: Campaign, names: Names) -> None:
    for name, instrument in campaign.instruments.items():
        if instrument.correction is not None and instrument.correction.value is not None:
            names.add(f"{name}.correction", instrument.correction.value.dimension, "instruments", name, "correction")


def _collect_samples(campaign: Campaign, names: Names) -> None:
    for name, sample in campaign.samples.items():
        for key, stated in sample.properties.items():
            within = () if key in type(sample).model_fields else ("section",)
            names.add(f"{name}.{key}", stated.dimension, "samples", name, *within, key)
        if sample.section is not None:
            names.add(f"{name}.A", units.dimension("m^2"), "samples", name, "section")


def heading_dimension(heading: str) -> Dimension | None:
    """Dimension of a column by its heading, ``V / mV``; None where the unit cannot be read."""
    try:
        return units.dimension(heading.partition("/")[2].strip() or "1")
    except TextError:
        return None


def axis_dimension(axis: Axis) -> Dimension | None:
    """Dimension of an axis of a fit."""
    if axis.column is not None:
        return heading_dimension(axis.column)
    try:
        return units.dimension(axis.unit)
    except TextError:
        return None


def _of_fit(fit: Fit) -> Iterator[tuple[str, Dimension | None]]:
    x, y = axis_dimension(fit.x), axis_dimension(fit.y)
    if fit.model.is_line:
        yield "intercept", y
        yield "slope", y / x if x is not None and y is not None else None
    for name, start in fit.model.start.items():
        yield name, start.dimension
    for point in fit.predict:
        yield point.name, x if point.x is None else y


def resolve(campaign: Campaign, names: Names) -> None:
    """Add the derived quantities: what the names in their expressions mean, their dimensions, and their order."""
    pending: dict[int, set[str]] = {}
    for index, derived in enumerate(campaign.derived):
        place = ("derived", index)
        if derived.sample is not None and derived.sample not in campaign.samples:
            continue
        names.add(derived.name, _unit_dimension(names, derived, index), *place, "quantity")
    for index, derived in enumerate(campaign.derived):
        meaning = _meaning(campaign, names, derived, ("derived", index))
        names.meanings["derived", index] = meaning
        pending[index] = {name for name in meaning.values() if names.places.get(name, ("",))[0] == "derived"}
        _check_dimension(names, derived, index)
    for index, audit in enumerate(campaign.audit):
        if audit.expression is not None:
            names.meanings["audit", index] = _meaning(campaign, names, audit, ("audit", index))
    _sort(campaign, names, pending)


def _unit_dimension(names: Names, derived: Derived, index: int) -> Dimension | None:
    try:
        return units.dimension(derived.unit)
    except TextError as error:
        names.refusals.append(from_text(error, "derived", index, "unit"))
        return None


def _meaning(campaign: Campaign, names: Names, entry: Derived | Audit, place: Place) -> dict[str, str]:
    """Full name behind each name of an entry's expression; faults for those that mean nothing."""
    try:
        wanted = Expression.parse(entry.expression or "").names
    except TextError as error:
        names.refusals.append(from_text(error, *place, "expression"))
        return {}
    for name in entry.where.keys() - wanted:
        near = mean(name, sorted(wanted)) or "remove it"
        names.refuse(
            (*place, "where", name), f"'{name}', which the expression does not use", "a name of the expression", near
        )
    meaning = {}
    for name in sorted(wanted):
        if name in entry.where:
            meaning[name] = entry.where[name]
            names.look_up(entry.where[name], *place, "where", name)
        elif (full := _in_scope(campaign, names, entry, name, place)) is not None:
            meaning[name] = full
    return meaning


def _in_scope(campaign: Campaign, names: Names, entry: Derived | Audit, name: str, place: Place) -> str | None:
    """Full name of a plain one, in the sample's scope, then globally; None, with a fault, for none or several."""
    sample = getattr(entry, "sample", None)
    if sample is not None and sample not in campaign.samples:
        return None
    if sample is not None:
        tests = [test for test, stated in campaign.tests.items() if stated.sample == sample]
        found = [full for owner in (sample, *tests) if (full := f"{owner}.{name}") in names.dimensions]
        found = [full for full in found if full != getattr(entry, "name", None)] or found
        if len(found) > 1:
            choice = " or ".join(f"'{full}'" for full in found)
            names.refuse(
                (*place, "expression"), f"'{name}', which may be {choice}", "one meaning", "say which under 'where'"
            )
            return None
        if found:
            return found[0]
    dimension = names.look_up(name, *place, "expression")
    return name if dimension is not None or name in names.dimensions else None


def _check_dimension(names: Names, derived: Derived, index: int) -> None:
    """Compare the dimension of the expression with that of the unit."""
    meaning = names.meanings["derived", index]
    mine = names.places.get(derived.name) == ("derived", index, "quantity")
    due = names.dimensions[derived.name] if mine else None
    try:
        expression = Expression.parse(derived.expression)
        known = {name: names.dimensions.get(full) for name, full in meaning.items()}
        if due is None or expression.names - known.keys() or None in known.values():
            return
        got = expression.dimension({name: dimension for name, dimension in known.items() if dimension is not None})
    except TextError as error:
        if names.refusals and names.refusals[-1].loc[:2] == ("derived", index):
            return
        names.refusals.append(from_text(error, "derived", index, "expression"))
        return
    if got != due:
        place = ("derived", index, "unit")
        names.refuse(place, f"{quoted(derived.unit)}, {due.name}", f"a unit of {got.name}, which the expression gives")


def _sort(campaign: Campaign, names: Names, pending: Mapping[int, set[str]]) -> None:
    """Order the derived quantities so that each comes after what it needs; refuse circles."""
    waiting = dict(pending)
    done: set[str] = set()
    while waiting:
        ready = [index for index, needs in waiting.items() if needs <= done]
        if not ready:
            for index in waiting:
                needs = ", ".join(sorted(waiting[index] - done))
                got = f"'{campaign.derived[index].name}', which needs itself by way of {needs}"
                names.refuse(("derived", index, "expression"), got, "quantities that do not go in circles")
            return
        for index in ready:
            names.order.append(campaign.derived[index])
            done.add(campaign.derived[index].name)
            del waiting[index]
