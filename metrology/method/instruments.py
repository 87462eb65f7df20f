"""What instruments bring into a measurement model: resolution, certificate, correction; and the modulus from k."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Any

from metrology import units
from metrology.declaration.entry import Refusal
from metrology.expression import Expression
from metrology.gum.bounded import Rectangular
from metrology.gum.distributions import Normal
from metrology.gum.inputs import Component, Input
from metrology.message import said
from metrology.sample import modulus
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.declaration.conduct import Test
    from metrology.declaration.identity import Instrument
    from metrology.declaration.quantity import Stated
    from metrology.method.declared import Declared
    from metrology.method.model import Model
    from metrology.method.record import Task


def check_reads(campaign: Declared, instrument: str, unit: str, *place: str | int) -> Iterator[Refusal]:
    """Refuse an instrument without a resolution of the dimension of `unit`.

    Parameters
    ----------
    campaign : Declared
        With its instruments.
    instrument : str
        Name of one of them.
    unit : str
        A unit of the dimension that it has to read.
    *place : str or int
        Keys of the campaign file that lead to the name.

    Yields
    ------
    Refusal
        None where the resolution fits.
    """
    stated = campaign.instruments.get(instrument)
    if stated is None:
        return
    due = units.dimension(unit)
    if stated.resolution is None:
        expected = f"an instrument with 'resolution', {due.name}"
        got, fix = f"'{instrument}', of which no resolution is stated", f"add it under instruments.{instrument}"
        yield Refusal(place, got, expected, fix)
    elif stated.resolution.dimension != due:
        got = f"'{instrument}', with a resolution of '{stated.resolution.value}'"
        yield Refusal(place, got, f"an instrument that reads {due.name}")


GRAVITY = (9.76, 9.84)
"""m/s²: free fall on the surface of the Earth is 9.764 to 9.834 (Hirt et al., Geophys. Res. Lett. 40 (2013) 4279)."""


def check_gravity(stated: Stated | None, *place: str | int) -> Iterator[Refusal]:
    """Refuse an acceleration of free fall that is nowhere on Earth, unless its source is stated.

    Parameters
    ----------
    stated : Stated or None
        Acceleration, in m/s² inside.
    *place : str or int
        Keys of the campaign file that lead to it.

    Yields
    ------
    Refusal
        None where the value is within `GRAVITY`.
    """
    if stated is not None and not GRAVITY[0] <= stated.si <= GRAVITY[1] and not stated.source:
        expected = f"{GRAVITY[0]} m/s^2 to {GRAVITY[1]} m/s^2, or a value with its 'source'"
        yield Refusal(place, quoted(stated.value), expected)


def resolution(instrument: Instrument) -> Component:
    """Return the rounding of one reading: rectangular, half a division wide.

    Parameters
    ----------
    instrument : Instrument
        With a resolution.

    Returns
    -------
    Component
        In the SI unit of the indication.

    Notes
    -----
    JCGM 100:2008 F.2.2.1.
    """
    assert instrument.resolution is not None
    source = said("division of the instrument")
    return Component(said("resolution"), Rectangular(instrument.resolution.si / 2), source=source)


def of_indication(instrument: Instrument, unit: str) -> tuple[Component, ...]:
    """Return what makes one indication uncertain, as far as it is stated in `unit`: certificate, and what else is.

    Parameters
    ----------
    instrument : Instrument
        With certificate and further uncertainties.
    unit : str
        SI unit of an indication, or ``"1"`` for a share of it.

    Returns
    -------
    tuple of Component
        In `unit`.
    """
    more = instrument.components(unit)
    stated = instrument.certificate
    if stated is None or stated.expanded_uncertainty is None or stated.expanded_uncertainty.si_unit != unit:
        return more
    dof, source = stated.dof or float("inf"), said("certificate {number}", number=stated.number)
    # What is traced to one standard shares its share: an amount is another error at each place of a scale.
    cause = stated.cause if unit == "1" else ""
    return (Component(said("certificate"), Normal(stated.u), dof, source=source, cause=cause), *more)


def of_all_indications(name: str | None, instrument: Instrument | None) -> Input | None:
    """Return what makes all indications uncertain alike: what is stated as a share of the indication.

    Where nothing is stated, the scale is an input that is taken as exact; an amount acts reading by reading.

    Parameters
    ----------
    name : str or None
        Of the instrument.
    instrument : Instrument or None
        None where the test names none.

    Returns
    -------
    Input or None
        ``{name}.scale``, relative, about 0.
    """
    if instrument is None:
        return None
    components = of_indication(instrument, "1")
    if not components and not instrument.is_exact:
        return None
    description = said("relative correction of {name}", name=str(name))
    return Input(f"{name}.scale", 0.0, components, "1", description, is_stated=True)


def shared(model: Model, test: str, stated: Stated | None, supposed: Input) -> Input:
    """Return what surrounds a test as an input: one with every other test that states the same, else one of its own.

    Parameters
    ----------
    model : Model
        The measurement model so far.
    test : str
        Name of the test.
    stated : Stated or None
        What the test states.
    supposed : Input
        What holds where nothing is stated, with the name that it has.

    Returns
    -------
    Input
        To be added to the model, if it is not there.
    """
    name = supposed.name
    own = stated.input(name, supposed.description) if stated else supposed
    others = (other for key, other in model.inputs.items() if key == name or key.endswith(f".{name}"))
    same = next((other for other in others if replace(other, name=name, description=own.description) == own), None)
    if same is not None:
        return same
    return replace(own, name=f"{test}.{name}") if name in model.inputs else own


def fitted_curve(
    name: str, expression: str | None, parameters: tuple[str, ...], *, origin: float = 0.0
) -> Callable[[Mapping[str, Any], Any], Any]:
    """Return the fitted line or curve as a function of a namespace that holds its parameters, and of x in SI.

    Parameters
    ----------
    name : str
        Of the fit.
    expression : str or None
        Of the curve, with the name ``x``; None for a line.
    parameters : tuple of str
        Names of the parameters of the curve.
    origin : float
        x at which the line has its intercept, in SI.

    Returns
    -------
    callable
        ``curve(namespace, x)``, y in SI.
    """
    if expression is None:
        return lambda namespace, x: namespace[f"{name}.intercept"] + namespace[f"{name}.slope"] * (x - origin)
    parsed = Expression.parse(expression)

    def curve(namespace: Mapping[str, Any], x: Any) -> Any:
        return parsed.evaluate({"x": x} | {parameter: namespace[f"{name}.{parameter}"] for parameter in parameters})

    return curve


def has_modulus(campaign: Declared, test: Test) -> bool:
    """Whether E = k·L/A can be computed: length and section of the sample are known.

    Parameters
    ----------
    campaign : Declared
        With its samples.
    test : Test
        Names the sample.

    Returns
    -------
    bool
        True also where the sample is not declared, which is a fault by itself.
    """
    sample = campaign.samples.get(test.sample)
    return sample is None or (sample.length is not None and sample.section is not None)


def add_modulus(task: Task[Any]) -> None:
    """Add E = k·L/A of a line that is pulled, where section and length of the sample are known.

    Parameters
    ----------
    task : Task
        Of a test that gives k; its measurement model is added to.
    """
    name, sample = task.name, task.test.sample
    if {f"{name}.k", f"{sample}.A", f"{sample}.length"} <= task.model.names:
        task.add(modulus(f"{name}.E", k=f"{name}.k", length=f"{sample}.length", area=f"{sample}.A"))


def known_stiffness(task: Task[Any]) -> dict[str, float]:
    """Stiffness of the sample in N/m by where it is known from: a reference, other tests, the modulus of reference.

    Parameters
    ----------
    task : Task
        Of the test that asks.

    Returns
    -------
    dict of str to float
        In N/m, the reference value first.
    """
    name, test, values = task.test.sample, task.name, task.model.estimates()
    references = task.campaign.samples[name].references
    found = {"the reference value": references["k"].si} if "k" in references else {}
    for other, stated in task.campaign.tests.items():
        k = values.get(f"{other}.k")
        if stated.sample == name and other != test and k is not None:
            found[f"test {other}"] = k
    if "E" in references and {f"{name}.A", f"{name}.length"} <= values.keys():
        found["the modulus of reference"] = references["E"].si * values[f"{name}.A"] / values[f"{name}.length"]
    return {source: k for source, k in found.items() if 0 < k < inf}
