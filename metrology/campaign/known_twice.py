"""What a campaign file says twice of a sample and not alike: a notice, since either may be what was meant."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot
from typing import TYPE_CHECKING

from metrology.gum.comparison import en
from metrology.gum.rounding import readable
from metrology.message import said
from metrology.sample import section

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.samples import Sample


def differences(campaign: Campaign) -> Iterator[str]:
    """Densities that differ by more than their uncertainties, and quantities of a sample that are made of another's."""
    for name, sample in campaign.samples.items():
        yield from _density(name, sample)
    for index, derived in enumerate(campaign.derived):
        meaning = campaign.names.meanings.get(("derived", index), {})
        of = {full: other for full in meaning.values() if (other := _sample(campaign, full))}
        if derived.sample and of and derived.sample not in of.values():
            others = tuple(f"{full} ({other})" for full, other in of.items())
            text = (
                "{name} is stated as one of sample {sample}, and every result in it is of another one: {others:comma}."
            )
            yield said(text, name=derived.name, sample=derived.sample, others=others)


def _sample(campaign: Campaign, full: str) -> str:
    """Sample of the test that gives a result; empty of any other quantity."""
    test = campaign.tests.get(full.rpartition(".")[0])
    return test.sample if test is not None else ""


def _density(name: str, sample: Sample) -> Iterator[str]:
    """Mass per length over section against the density of the material, where uncertainties of them are stated."""
    if sample.section is None or sample.linear_density is None or sample.density is None:
        return
    shape = section(sample.section.shape)
    stated = [getattr(sample.section, dimension) for dimension in shape.dimensions]
    sizes = [one.si for one in stated]
    area = shape.area(*sizes)
    if not (area > 0 and sample.linear_density.si > 0):
        return  # refused elsewhere
    found = sample.linear_density.si / area
    raised = [shape.area(*sizes[:at], sizes[at] + one.u, *sizes[at + 1 :]) - area for at, one in enumerate(stated)]
    u = found * hypot(sample.linear_density.u / sample.linear_density.si, *(each / area for each in raised))
    if not hypot(u, sample.density.u):
        return
    compared = en(found, u, sample.density.si, sample.density.u)
    if compared.en is None or compared.agrees:
        return
    text = (
        "{name}: the density is {found:figures} by linear density over section, and {density:figures} as stated: "
        "|E_n| = {en:.3g}. It is less where the section holds air, as in a braid; otherwise one of the three is wrong."
    )
    unit = "kg/m^3"
    values = {"found": readable(found, unit, 3), "density": readable(sample.density.si, unit, 3)}
    yield said(text, name=name, en=abs(compared.en), **values)
