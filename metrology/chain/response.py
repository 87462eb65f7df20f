"""Response tests of a campaign: runs as measured, what is known of the rig, and what comes out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from metrology import units
from metrology.campaign.response import ResponseTest, StatedRun, Thrusting
from metrology.campaign.response_known import INERT, KNOWN, amount
from metrology.campaign.response_units import due
from metrology.chain import diagnosis
from metrology.chain.plan import Identity, Plan
from metrology.coordinate import Coordinate
from metrology.errors import Fault, MetrologyError
from metrology.response.finding import plotted
from metrology.sample import modulus

if TYPE_CHECKING:
    import numpy as np

    from metrology.campaign.response import Given as StatedGiven
    from metrology.campaign.schema import Campaign
    from metrology.campaign.tables import Table
    from metrology.identify import MeasuredRun, Prior, Settings
    from metrology.response import ResponseFinding
    from metrology.response.analysis import Given
    from metrology.response.analysis import ResponseTest as Test
    from metrology.rig import Force, Rig
    from metrology.timeseries import Trace
    from metrology.verify import VerificationFinding

Progress = Callable[[str], None]
STANDS_FOR = {"k": "stiffness", "c": "damping"}
DISPLAYED = {"zeta": "%"}
TENTH_OF_CRITICAL = 0.1
PLOTTED = 50
"""Numbers in a row from which on they are for plots."""
QUICK = 20_000
"""Trials that are enough for the value of another test that a simulation begins with."""


def add_response(plan: Plan, campaign: Campaign, name: str, test: ResponseTest, progress: Progress) -> ResponseFinding:
    """Add a response test to the plan, with the verdict on its model, and return what it showed.

    Raises
    ------
    MetrologyError
        For runs that cannot be what they claim, each fault with its place in the campaign file.
    """
    import numpy as np

    from metrology import verify
    from metrology.response.analysis import analyse

    rng = np.random.default_rng([campaign.seed, *name.encode()])
    ready = prepared(plan, campaign, name, test)
    try:
        analysis = analyse(ready, rng, progress=progress)
    except MetrologyError as error:
        raise MetrologyError(*(_placed(campaign, name, test, fault) for fault in error.faults)) from None
    plan.add_inputs(analysis.inputs)
    plan.ensembles.extend(analysis.ensembles)
    for measurand in analysis.measurands:
        plan.add_measurand(measurand, _identity(name, test, measurand.name, measurand.unit))
    _add_modulus(plan, name, test)
    plan.failures.extend(f"{name}: {sentence}" for sentence in analysis.finding.failures)
    if analysis.verification is not None:
        plan.verification.append(_plain(asdict(verify.thinned(analysis.verification))))
        plan.traces.update(_traces(name, analysis.verification))
    if analysis.identified is not None:
        from metrology.response.presentation import residuals

        plan.traces.update({f"response/{name}/{key}": trace for key, trace in residuals(analysis.identified).items()})
    diagnosis.add_response(plan, campaign, ready, analysis.identified, progress)
    return _explained(analysis.finding, test)


def _traces(name: str, verification: VerificationFinding) -> dict[str, Trace]:
    """Every sample of the held-out runs, for the screen."""
    from metrology.verify import trace

    return {
        f"verification/{name}/{run.run}/{series.channel}": trace(series)
        for run in verification.runs
        for series in run.series
    }


def _explained(finding: ResponseFinding, test: ResponseTest) -> ResponseFinding:
    """Say of a rig that turns what its letters stand for, and why there is no E."""
    if test.rig.coordinate == "position":
        return finding
    notes = [
        "the rig turns: x and v are angle and angular velocity, F and T torques, and m is the moment of inertia, in "
        "the equation of every effect as well"
    ]
    if "k" in test.free:
        notes.append(
            "no modulus follows from k: E = k·L/A holds for a line that is pulled, not for one that is twisted"
        )
    return replace(finding, notes=(*finding.notes, *notes))


def _plain(value: Any) -> Any:
    """Return the value as JSON gives it back, lists in place of tuples; long ones, for plots, with seven digits."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return list(plotted(value)) if len(value) > PLOTTED else [_plain(entry) for entry in value]
    return value


def _placed(campaign: Campaign, name: str, test: ResponseTest, fault: Fault) -> Fault:
    """Return a fault of a run with the place where the campaign file declares that run."""
    run, _, rest = fault.where.partition(".")
    if run not in test.runs:
        return Fault(f"{campaign.at('tests', name)}: {fault.where}", fault.got, fault.expected, fault.mend)
    where = f"{campaign.at('tests', name, 'runs', run)} {rest}".rstrip()
    return Fault(where, fault.got, fault.expected, fault.mend)


def _identity(name: str, test: ResponseTest, full: str, unit: str) -> Identity:
    quantity = full.removeprefix(f"{name}.")
    headline = quantity in (*test.free, "zeta", "omega_n")
    return Identity(quantity, "response", test.sample, name, DISPLAYED.get(quantity, unit), headline=headline)


def _add_modulus(plan: Plan, name: str, test: ResponseTest) -> None:
    """Add E = k·L/A where k was sought, of a line on a straight path, and section and length are known."""
    if test.rig.coordinate == "angle":
        return
    needed = {f"{name}.k", f"{test.sample}.A", f"{test.sample}.length"}
    if "k" in test.free and needed <= plan.names:
        measurand = modulus(f"{name}.E", k=f"{name}.k", length=f"{test.sample}.length", area=f"{test.sample}.A")
        plan.add_measurand(measurand, Identity("E", "response", test.sample, name, "GPa"))


def prepared(plan: Plan, campaign: Campaign, name: str, test: ResponseTest) -> Test:
    """Return the test as the analysis takes it."""
    from metrology.diagnose.own import check_forces
    from metrology.response import analysis

    given = {
        key: _given(plan, campaign, f"{name}.{word}", stated)
        for key, word in STANDS_FOR.items()
        if (stated := getattr(test, word)) is not None
    }
    rig, runs = _rig(campaign, test, given), measured_runs(campaign, name, test)
    check_forces(campaign.own, rig, runs[0].run)
    return analysis.ResponseTest(
        name=name,
        sample=test.sample,
        rig=rig,
        runs=runs,
        free=test.free,
        priors=_priors(test),
        given=given,
        settings=_settings(test),
        certificates=_certificates(campaign, test),
    )


def _given(plan: Plan, campaign: Campaign, name: str, stated: StatedGiven) -> Given:
    from metrology import gum
    from metrology.response.analysis import Given

    if stated.value is not None:
        known = stated.value.input(name)
        return Given(name, known.value, known.u, stated.value.source or "stated", known)
    quantity = f"{stated.test}.{'k' if name.endswith('.stiffness') else 'c'}"
    if quantity not in plan.identities:
        message = Fault(
            campaign.at("tests", name.partition(".")[0]), f"'{stated.test}', which has no result", "a test that has"
        )
        raise MetrologyError(message)
    at = next(index for index, measurand in enumerate(plan.measurands) if measurand.name == quantity)
    evaluation = gum.evaluate(plan.measurands[: at + 1], plan.knowledge, seed=campaign.seed, max_trials=QUICK)
    estimate = evaluation.estimates[quantity]
    return Given(quantity, estimate.value, estimate.u, f"test {stated.test}")


def _rig(campaign: Campaign, test: ResponseTest, given: Mapping[str, Given]) -> Rig:
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
    from metrology.identify import Prior

    sizes_of = {name: value.u for name, value in test.model.items() if value.u > 0}
    found = [Prior(name, common=u, source="model of the campaign") for name, u in sizes_of.items()]
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


def _settings(test: ResponseTest) -> Settings:
    from metrology.identify import Settings

    stated = test.identification.bounds if test.identification else {}
    return Settings(bounds={name: (low.si, high.si) for name, (low, high) in stated.items()})


def _certificates(campaign: Campaign, test: ResponseTest) -> dict[str, float]:
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


# ---- runs -----------------------------------------------------------------------------------------------------------
def measured_runs(campaign: Campaign, name: str, test: ResponseTest) -> tuple[MeasuredRun, ...]:
    """Return the runs of a test with their readings."""
    from metrology.campaign.response_checks import run_tables

    tables = run_tables(campaign.tables["tests", name], test)
    excluded = {(exclusion.file, exclusion.line) for exclusion in test.exclusions}
    noise = {channel: stated.si for channel, stated in dict(test.noise).items() if stated is not None}
    return tuple(
        _run(run_name, run, tables[run_name], (excluded, noise), test.rig.coordinate)
        for run_name, run in test.runs.items()
    )


def _run(
    name: str,
    run: StatedRun,
    tables: tuple[Table, ...],
    told: tuple[set[tuple[str | None, int | None]], Mapping[str, float]],
    coordinate: Coordinate,
) -> MeasuredRun:
    import numpy as np

    from metrology.identify import MeasuredRun
    from metrology.rig import Run

    excluded, noise = told
    stamps: dict[str, Any] = {}
    readings: dict[str, Any] = {}
    use: dict[str, Any] = {}
    for table in tables:
        dropped = [line for file, line in excluded if line is not None and file in (None, table.source.path)]
        for channel in ("x", "v", "T"):
            if channel in table.numbers:
                stamps[f"t_{channel}"], readings[channel] = table.numbers["time"], table.numbers[channel]
                if dropped:
                    use[channel] = ~np.isin(table.lines, dropped)
    begin = min(float(table.numbers["time"][0]) for table in tables)
    return MeasuredRun(
        name,
        Run(
            x0=run.start.position.si,
            v0=run.start.velocity.si,
            t0=begin,
            held_until=run.held_until.si if run.held_until else None,
            force=_force(run.thrust, tables),
            **stamps,
        ),
        noise={channel: size for channel, size in noise.items() if channel in readings},
        use=use,
        purpose=run.purpose,
        coordinate=coordinate,
        **readings,
    )


def _force(stated: tuple[Thrusting, ...] | None, tables: tuple[Table, ...]) -> Force | None:
    from metrology.rig import Force

    for table in tables:
        if "F" in table.numbers:
            return Force(table.numbers["time"], table.numbers["F"], "linear")
    if not stated:
        return None
    profile: dict[float, float] = {}
    for part in stated:
        profile[part.from_.si] = part.size.si
        if part.to is not None:
            profile[part.to.si] = 0.0
    return Force(_array(list(profile)), _array(list(profile.values())))


def _array(values: list[float]) -> np.ndarray[Any, Any]:
    import numpy as np

    return np.array(values)
