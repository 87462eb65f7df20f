"""Method `relaxation`: an elongation, or a load, that is held, and what the specimen answers over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from metrology import relaxation
from metrology.declaration.columns import Column, Table
from metrology.declaration.entry import Refusal
from metrology.errors import Fault
from metrology.method import Analysed, Files, Loading, Method, Output, Relaxing, Task
from metrology.methods.relaxation.preparation import facts, prepared, shared, values
from metrology.methods.relaxation.schema import RelaxationInstruments, RelaxationSpecimen, RelaxationTest
from metrology.methods.tension import machine
from metrology.relaxation.blocks import LEAST

if TYPE_CHECKING:
    from metrology.method.declared import Declared

__all__ = ["METHOD", "RelaxationInstruments", "RelaxationSpecimen", "RelaxationTest"]

STRETCH = {"crosshead": "m", "extension": "m", "strain": "1"}
SWEEP = (
    Column("frequency", "Hz", increasing=True), Column("storage", "Pa"), Column("loss", "Pa"),
    Column("u storage", "Pa", required=False), Column("u loss", "Pa", required=False),
)  # fmt: skip


def readings(name: str, test: RelaxationTest) -> Iterator[Files]:
    """A file for each specimen with time, force and stretch; the DMA sweep comes last."""
    column, reader = test.instruments.reader
    columns = [Column("time", "s", increasing=True), Column("force", "N", gaps=True, varies=True)]
    columns += [Column(column, STRETCH[column], gaps=True, varies=True)]
    faults = partial(_faults, setup=test.setup_compliance.si if test.setup_compliance is not None else 0.0)
    for specimen, stated in test.specimens.items():
        place = ("tests", name, "specimens", specimen, "readings")
        yield Files([(place, stated.readings)], columns, faults, {"force": test.instruments.force, column: reader})
    if test.dma is not None:
        yield Files([(("tests", name, "dma"), test.dma)], SWEEP, _sweep_faults)


def _faults(tables: Sequence[Table], *, setup: float) -> Iterator[Fault]:
    for table in tables:
        channels = np.array([numbers for key, numbers in table.numbers.items() if key != "time"])
        together = channels[:, np.isfinite(channels).all(axis=0)]
        if (count := together.shape[1]) < LEAST:
            yield Fault(str(table.path), f"{count} readings of force and stretch together", f"at least {LEAST}")
            continue
        force, stretch = together - together.mean(axis=1, keepdims=True)
        low, high = force.argmin(), force.argmax()
        if not float(force @ stretch) > 0:
            got, expected = "a force that falls as the stretch grows", "forces that are positive in tension"
            yield Fault(str(table.path), got, expected, "turn the sign of the column")
        elif setup >= (whole := float((stretch[high] - stretch[low]) / (force[high] - force[low]))):
            got = f"{1e6 * whole:.3g} um/N of specimen and set-up together, and a set-up of {1e6 * setup:.3g} um/N"
            expected = "a 'setup_compliance' that leaves something to the specimen"
            yield Fault(str(table.path), got, expected, "correct its unit or its value")


def _sweep_faults(tables: Sequence[Table]) -> Iterator[Fault]:
    for table in tables:
        if not float(np.min(table.numbers["frequency"])) > 0:
            yield Fault(str(table.path), "a frequency of zero or less", "frequencies greater than zero")


def check(campaign: Declared, name: str, test: RelaxationTest) -> Iterator[Refusal]:
    """Specimens that are there and differ, classes that exist, and lengths where they are needed."""
    place = ("tests", name)
    files = {specimen: stated.readings.name for specimen, stated in test.specimens.items()}
    yield from machine.specimens(name, files, (exclusion.file for exclusion in test.exclusions))
    by, known = test.instruments, facts(campaign, test)
    yield from machine.classes(campaign, name, (("force", by.force), by.reader))
    yield from machine.gauge(campaign, name, test)
    if by.extension is not None and test.gauge_length is None:
        yield Refusal(place, "'extension' without 'gauge_length'", "'gauge_length', such as '25.0(1) mm'")
    if test.setup_compliance is not None and by.crosshead is None:
        yield Refusal((*place, "setup_compliance"), f"'{test.setup_compliance.value}' with an extensometer",
                      "nothing: grips and frame act on a crosshead alone")  # fmt: skip
    if test.dma is not None and "E_0" not in known.results:
        yield Refusal((*place, "dma"), "a DMA sweep, and no modulus to compare it with",
                      "the section of the sample, and its length where a crosshead is read")  # fmt: skip


def analyse(task: Task[RelaxationTest]) -> Analysed[None]:
    """Put every specimen and the means over them into the model."""
    ready, known = prepared(task), facts(task.campaign, task.test)
    analysis = task.model.once(relaxation.analyse, ready, known, values(task), shared(task, ready))
    task.model.add(analysis.contribution)
    for measurand in analysis.contribution.measurands:
        task.add(measurand, headline=measurand.name.removeprefix(f"{task.name}.") not in ("relaxed", "alpha"))
    task.model.failures.extend(analysis.failures)
    return Analysed(analysis.finding, None)


def yields(campaign: Declared, test: RelaxationTest) -> dict[str, str]:
    """Return the results that the record may support: of a power law there is no equilibrium."""
    return dict(facts(campaign, test).results)


def loading(campaign: Declared, name: str, test: RelaxationTest, finding: relaxation.RelaxationFinding) -> Loading:
    """The stated time, else the longest ramp; extensometers, and set-ups taken off, leave the specimen alone."""
    sample, crosshead = campaign.samples.get(test.sample), test.instruments.crosshead is not None
    cut = any(one.length is not None for one in test.specimens.values())
    known = sample is not None and sample.length is not None
    seconds = test.at.si if test.at is not None else max(one.ramp for one in finding.specimens)
    resolved = relaxation.resolved(finding)
    relaxing: tuple[Relaxing, ...] = ()
    if test.held == "elongation":
        relaxing = tuple(Relaxing(f"branch {at} of {name}", *one) for at, one in enumerate(relaxation.mean(finding), 1))
    return Loading(
        seconds, setup=crosshead and test.setup_compliance is None, whole=not cut and (crosshead or known),
        relaxing=relaxing, resolved=resolved if test.held == "elongation" else None,
    )  # fmt: skip


OUTPUTS = {
    "k_0": Output("N/m", "N/m", "instantaneous stiffness"),
    "k_inf": Output("N/m", "N/m", "equilibrium stiffness"),
    "k_t": Output("N/m", "N/m", "stiffness at the stated time"),
    "E_0": Output("Pa", "GPa", "instantaneous modulus"),
    "E_inf": Output("Pa", "GPa", "equilibrium modulus"),
    "E_t": Output("Pa", "GPa", "modulus at the stated time"),
    "relaxed": Output("1", "%", "part of the stiffness that relaxes"),
    "alpha": Output("1", "1", "fall of ln k with ln t at the stated time"),
}
METHOD = Method(
    title="Relaxation",
    standard="Laboratory method, docs/methods/relaxation.md; JCGM 100:2008",
    shown="What a relaxation or creep test showed.",
    columns="`time / s`, `force / N`, and `crosshead / mm`, `extension / um` or `strain / %`; one file a specimen; a "
    "DMA sweep has `frequency / Hz`, `storage / GPa`, `loss / MPa`",
    remark="`held: load` makes it a creep test. `k_t`, `E_t` and `alpha`, −d ln k/d ln t, exist where `at` is stated, "
    "`E_0`, `E_inf` and `E_t` where the section is known. A record that supports a power law gives no `k_inf`, and of "
    "a held elongation no `k_0`.",
    references=("ferry", "tschoegl", "mackay", "hac", "iso7500", "iso9513", "iso13528"),
    test=RelaxationTest,
    entries=(RelaxationInstruments, RelaxationSpecimen),
    outputs=OUTPUTS,
    yields=yields,
    takes=(),
    whole="specimen",
    readings=readings,
    check=check,
    analyse=analyse,
    finding=relaxation.RelaxationFinding,
    diagnose=None,
    corrected=None,
    explain=None,
    loading=loading,
    carried=None,
)
