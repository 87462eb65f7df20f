"""A response test as the analysis takes it: rig, runs, and what the campaign file says is known of them."""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot
from typing import TYPE_CHECKING

from metrology import units
from metrology.errors import Fault, MetrologyError
from metrology.message import said
from metrology.methods.response.clock import with_rate
from metrology.methods.response.known import INERT, KNOWN, amount
from metrology.methods.response.runs import measured_runs
from metrology.methods.response.schema import ResponseTest
from metrology.methods.response.units import due

if TYPE_CHECKING:
    from metrology.estimation import Prior, Settings
    from metrology.method.declared import Declared
    from metrology.method.model import Model
    from metrology.methods.response.schema import Given as StatedGiven
    from metrology.response.test import Given
    from metrology.response.test import ResponseTest as Test
    from metrology.rig import Rig

STANDS_FOR = {"k": "stiffness", "c": "damping"}
TENTH_OF_CRITICAL = 0.1
QUICK = 20_000
"""Trials that are enough for the value of another test that a simulation begins with."""


def prepared(model: Model, campaign: Declared, name: str, test: ResponseTest) -> Test:
    """Return the test as the analysis takes it."""
    from metrology.diagnostics.own import check_forces
    from metrology.response.test import ResponseTest as Prepared

    given = {
        key: _given(model, campaign, f"{name}.{word}", stated)
        for key, word in STANDS_FOR.items()
        if (stated := getattr(test, word)) is not None
    }
    rig, runs = _rig(campaign, test, given), measured_runs(campaign, name, test)
    check_forces(campaign.own, rig, runs[0].run)
    return Prepared(
        name=name,
        sample=test.sample,
        rig=rig,
        runs=runs,
        free=test.free,
        priors=_with_clock(test, (*_priors(test), *_stated_priors(campaign, test))),
        given=given,
        settings=_settings(test),
        certificates=_certificates(campaign, test),
    )


def _given(model: Model, campaign: Declared, name: str, stated: StatedGiven) -> Given:
    from metrology import gum
    from metrology.response.test import Given

    if stated.value is not None:
        known = stated.value.input(name)
        return Given(name, known.value, known.u, stated.value.source or said("stated"), known)
    quantity = f"{stated.test}.{'k' if name.endswith('.stiffness') else 'c'}"
    if quantity not in model.identities:
        message = Fault(
            campaign.at("tests", name.partition(".")[0]), f"'{stated.test}', which has no result", "a test that has"
        )
        raise MetrologyError(message)
    at = next(index for index, measurand in enumerate(model.measurands) if measurand.name == quantity)
    evaluation = gum.evaluate(model.measurands[: at + 1], model.knowledge, seed=campaign.seed, max_trials=QUICK)
    estimate = evaluation.estimates[quantity]
    return Given(quantity, *estimate.reported, said("test {test}", test=quantity.rpartition(".")[0]))


def _rig(campaign: Declared, test: ResponseTest, given: Mapping[str, Given]) -> Rig:
    from metrology.rig import Rig

    stated, sample = test.rig, campaign.samples[test.sample]
    start = test.identification.start if test.identification else None
    k = given["k"].value if "k" in given else start.k.si if start and start.k else 0.0
    usual = 2 * TENTH_OF_CRITICAL * (k * stated.inert.si) ** 0.5
    c = given["c"].value if "c" in given else start.c.si if start and start.c else usual
    weighs = stated.line_weight != "none"
    return Rig(
        m=stated.inert.si,
        k=k,
        c=c,
        taut=stated.taut.si,
        length=sample.length.si if weighs and sample.length else 0.0,
        weight=sample.linear_density.si * stated.gravity.si if weighs and sample.linear_density else 0.0,
        line_weight=stated.line_weight,
        cap=stated.cap.si,
        attachment=stated.attachment,
        gravity=stated.gravity.si,
        effects={name: value.si for name, value in test.model.items()},
        own=tuple(effect.own for effect in campaign.own if effect.force),
        coordinate=stated.coordinate,
    )


def _priors(test: ResponseTest) -> tuple[Prior, ...]:
    """What is known within an uncertainty: inputs of the rig, and effects that the model carries."""
    from metrology.estimation import Prior

    sizes_of = {name: value.u for name, value in test.model.items() if value.u > 0}
    found = [Prior(name, common=u, source=said("model of the campaign")) for name, u in sizes_of.items()]
    for key, (parameter, unit) in KNOWN.items():
        spread = getattr(test.known, key)
        if spread is None:
            continue
        whole = test.rig.inert.si if key in INERT else None
        sizes = {part: amount(text, due(unit, test), whole) / (whole or 1.0) for part, text in spread.amounts().items()}
        if parameter in sizes_of:
            # Where the model says more of an input than the laboratory knew before, only its scatter is left to say.
            found = [one for one in found if one.name != parameter]
            sizes["common"] = sizes_of[parameter]
        found.append(Prior(parameter, sizes.get("common", 0.0), sizes.get("per_run", 0.0), source=spread.source))
    return tuple(found)


def clock_rate(test: ResponseTest) -> float:
    """Relative standard uncertainty of the rate of the clock; 0 where none is stated."""
    stated = test.known.clock_rate
    return amount(stated.common, "1") if stated and stated.common else 0.0


def _with_clock(test: ResponseTest, priors: tuple[Prior, ...]) -> tuple[Prior, ...]:
    return with_rate(priors, clock_rate(test)) if clock_rate(test) else priors


def _stated_priors(campaign: Declared, test: ResponseTest) -> tuple[Prior, ...]:
    """What the rig and the sample state with an uncertainty of their own, where `known` does not say it."""
    from metrology.estimation import Prior

    rig, sample, known = test.rig, campaign.samples[test.sample], test.known
    found = []
    if rig.inert.u > 0 and not (known.mass or known.inertia):
        found.append(Prior("mass.factor", rig.inert.u / rig.inert.si, source=said("stated with the rig")))
    if rig.taut.u > 0 and not known.free_length:
        found.append(Prior("free_length.shift", rig.taut.u, source=said("stated with the rig")))
    if rig.line_weight == "none" or not (sample.length and sample.linear_density):
        return tuple(found)
    density = sample.linear_density
    relative = hypot(density.u / density.si, rig.gravity.u / rig.gravity.si)
    if sample.length.u > 0:
        found.append(Prior("length", sample.length.u, source=said("length of the sample")))
    if relative > 0:
        source = said("linear density of the sample and gravity")
        found.append(Prior("weight", relative * density.si * rig.gravity.si, source=source))
    return tuple(found)


def _settings(test: ResponseTest) -> Settings:
    from metrology.estimation import Settings

    stated = test.identification.bounds if test.identification else {}
    return Settings(bounds={name: (low.si, high.si) for name, (low, high) in stated.items()})


def _certificates(campaign: Declared, test: ResponseTest) -> dict[str, float]:
    """Standard uncertainty of a reading by the certificates, by channel, where they say it in the channel's unit."""
    found = {}
    roles = {"x": ("position", "m"), "v": ("velocity", "m/s"), "T": ("tension", "N")}
    for channel, (role, unit) in roles.items():
        instrument = campaign.instruments.get(getattr(test.instruments, role) or "")
        certificate = instrument.certificate if instrument else None
        stated = certificate.expanded_uncertainty if certificate else None
        if certificate is not None and stated is not None and stated.si_unit == units.si_unit(due(unit, test)):
            found[channel] = certificate.u
    return found
