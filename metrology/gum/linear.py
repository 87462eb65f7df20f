"""Value and sensitivities of measurands at the estimates of their inputs (JCGM 100:2008, 5.1.3)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from math import isfinite, nan
from typing import Any, NamedTuple

from metrology.errors import Fault, MetrologyError
from metrology.gum.evaluation import Measurand
from metrology.gum.inputs import Knowledge
from metrology.message import said


class Namespace(Mapping[str, Any]):
    """Quantities by name, which remembers the names that were read."""

    def __init__(self, quantities: dict[str, Any]) -> None:
        self.quantities = quantities
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> Any:
        quantity = self.quantities[name]
        self.read.add(name)
        return quantity

    def __iter__(self) -> Iterator[str]:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)


class Linear(NamedTuple):
    """A measurand at the estimates of its inputs: value, sensitivities c_i = ∂y/∂x_i, and all inputs that it reads.

    `failure` is a sentence where the value (then NaN) or a sensitivity does not exist.
    """

    measurand: Measurand
    value: float
    sensitivities: Mapping[str, float]
    reads: Set[str]
    failure: str = ""


def linearise(measurands: Sequence[Measurand], knowledge: Knowledge) -> tuple[Linear, ...]:
    """Value and sensitivities of every measurand, by the derivatives that `uncertainties` carries along.

    A measurand may read the inputs and every measurand before it.

    Parameters
    ----------
    measurands : sequence of Measurand
        In order of use.
    knowledge : Knowledge
        The inputs, in SI.

    Returns
    -------
    tuple of Linear
        For each measurand its value, its sensitivities by input, and what it reads.

    Raises
    ------
    MetrologyError
        A measurand reads a name that is neither an input nor an earlier measurand.

    Notes
    -----
    JCGM 100:2008 5.1.3.
    """
    from metrology.gum import variable

    members = {member for ensemble in knowledge.ensembles for member in ensemble.members}
    quantities: dict[str, Any] = {
        name: variable.Variable(item.value, name) if item.u or name in members else float(item.value)
        for name, item in knowledge.inputs.items()
    }
    reads: dict[str, Set[str]] = {}
    found = []
    for measurand in measurands:
        linear = _linear(measurand, quantities, reads)
        reads[measurand.name] = linear.reads
        found.append(linear)
    return tuple(found)


def _linear(measurand: Measurand, quantities: dict[str, Any], reads: Mapping[str, Set[str]]) -> Linear:
    namespace = Namespace(quantities)
    failure = ""
    try:
        result = measurand.function(namespace)
    except KeyError as error:
        raise MetrologyError(_unknown(measurand, error)) from error
    except (ArithmeticError, ValueError) as error:
        text = "The equation has no value at the estimates of its inputs ({error})."
        result, failure = nan, said(text, error=str(error))
    quantities[measurand.name] = result
    inputs = {name for read in namespace.read for name in reads.get(read, (read,))}
    value = float(getattr(result, "nominal_value", result))
    if not isfinite(value):
        failure = failure or said("The equation has no finite value at the estimates.")
        return Linear(measurand, nan, {}, inputs, failure)
    slopes = {variable.tag: float(slope) for variable, slope in getattr(result, "derivatives", {}).items()}
    undefined = [name for name, slope in slopes.items() if not isfinite(slope)]
    if undefined:
        text = "The derivative with respect to {names:comma} does not exist at the estimates."
        failure = said(text, names=tuple(sorted(undefined)))
        return Linear(measurand, value, {}, inputs, failure)
    return Linear(measurand, value, slopes, inputs)


def _unknown(measurand: Measurand, error: KeyError) -> Fault:
    return Fault(measurand.name, f"an equation that reads {error}", "inputs, or measurands that come before it")
