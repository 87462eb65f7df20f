"""Method `tension`: a pull in a testing machine, force and stretch recorded continuously."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from metrology import tension
from metrology.declaration.columns import Column, Table
from metrology.declaration.entry import Refusal
from metrology.errors import Fault
from metrology.message import said
from metrology.method import Analysed, Files, Loading, Method, Output, Task
from metrology.methods.tension import machine
from metrology.methods.tension.preparation import facts, prepared, values
from metrology.methods.tension.schema import (
    TensionInstruments,
    TensionRange,
    TensionSecant,
    TensionSpecimen,
    TensionTangent,
    TensionTest,
)
from metrology.tension.lines import Lines
from metrology.tension.slope import LEAST

if TYPE_CHECKING:
    from metrology.diagnosis import Diagnosis
    from metrology.gum.evaluation import Contribution
    from metrology.method.declared import Declared

__all__ = ["METHOD", "TensionInstruments", "TensionRange", "TensionSpecimen", "TensionTest"]

Ready = tuple[tension.TensionTest, tuple[Lines, ...]]
STRETCH = {"crosshead": "m", "extension": "m", "strain": "1"}


def readings(name: str, test: TensionTest) -> Iterator[Files]:
    """A file for each specimen, with the columns of the instruments that are stated."""
    by = dict(test.instruments)
    used = {key: by[key] for key in STRETCH if by[key] is not None}
    for specimen, stated in test.specimens.items():
        columns = [Column("time", "s", required=stated.readings.time is not None, increasing=True)]
        columns += [Column("force", "N", varies=True)]
        columns += [Column(key, STRETCH[key], gaps=key != "crosshead", varies=True) for key in used]
        columns += [Column(f"{key} 2", STRETCH[key], required=False, gaps=True) for key in used if key != "crosshead"]
        place = ("tests", name, "specimens", specimen, "readings")
        yield Files([(place, stated.readings)], columns, _faults, {"force": by["force"], **used})


def _faults(tables: Sequence[Table]) -> Iterator[Fault]:
    for table in tables:
        if len(table) < LEAST:
            yield Fault(str(table.path), f"{len(table)} readings", f"at least {LEAST}")
            continue
        force = table.numbers["force"]
        if not float(np.max(force)) > 0:
            yield Fault(str(table.path), "forces that never pull", "forces that are positive in tension",
                        "turn the sign of the column")  # fmt: skip
        for key in ("extension", "strain"):
            if key not in table.numbers:
                continue
            seen = np.isfinite(table.numbers[key])
            if seen.sum() < LEAST:
                yield Fault(str(table.path), f"fewer than {LEAST} readings of {key}", "an extensometer that was on")
            elif np.cov(force[seen], table.numbers[key][seen])[0, 1] < 0:
                yield Fault(str(table.path), f"readings of {key} that fall while the force rises",
                            f"{'an' if key == 'extension' else 'a'} {key} along the load, positive in tension",
                            "turn the sign of the column, or name another")  # fmt: skip


def check(campaign: Declared, name: str, test: TensionTest) -> Iterator[Refusal]:
    """Specimens that are there and differ, classes that exist, and a gauge length where one is needed."""
    files = {specimen: stated.readings.name for specimen, stated in test.specimens.items()}
    yield from machine.specimens(name, files, (exclusion.file for exclusion in test.exclusions))
    used = ((role, instrument) for role, instrument in test.instruments if instrument)
    yield from machine.classes(campaign, name, used, unclassed=("crosshead",))
    yield from machine.gauge(campaign, name, test)
    yield from _lengths(campaign, name, test)


def _lengths(campaign: Declared, name: str, test: TensionTest) -> Iterator[Refusal]:
    """Lengths without which a strain, or a result, has no meaning."""
    place, by, known = ("tests", name), test.instruments, facts(campaign, test)
    if by.extension is not None and test.gauge_length is None:
        yield Refusal(place, "'extension' without 'gauge_length'", "'gauge_length', such as '25.0(1) mm'")
    if known.strain:
        return
    if not known.lengths:
        yield Refusal(place, "a crosshead alone, and specimens without 'length'",
                      "the free length, with the sample or with each specimen")  # fmt: skip
    if test.setup_compliance is None and known.by_lengths and any(one.section for one in test.specimens.values()):
        expected = "one section, stated with the sample: the set-up's compliance follows from the lengths"
        yield Refusal((*place, "specimens"), "several lengths, and specimens with sections of their own", expected)


def analyse(task: Task[TensionTest]) -> Analysed[Ready]:
    """Put every specimen and the means over them into the model."""
    ready, known = prepared(task), facts(task.campaign, task.test)
    analysis = tension.analyse(ready, known, values(task))
    task.model.add(analysis.contribution)
    for measurand in analysis.contribution.measurands:
        quantity = measurand.name.removeprefix(f"{task.name}.")
        identity = task.identity(measurand, headline=quantity in OUTPUTS)
        shown = OUTPUTS[quantity.rpartition(".")[2]].shown
        task.model.add_measurand(measurand, replace(identity, display_unit=shown))
    task.model.failures.extend(analysis.failures)
    return Analysed(analysis.finding, (ready, analysis.drawn), analysis.contribution)


def diagnose(task: Task[TensionTest], ready: Ready, rng: np.random.Generator) -> Diagnosis:
    """What parts crosshead and extensometer, and what the lines through the records lack."""
    from metrology.diagnostics import tension as diagnosed

    return task.model.once(diagnosed, *ready, rng=rng, sample=task.test.sample)


def corrected(task: Task[TensionTest], ready: Ready, stated: Contribution, found: Diagnosis) -> Contribution:
    """Results by the lines that the data support, where what was found acts on what they follow from."""
    from metrology.diagnostics.tension import Tension
    from metrology.diagnostics.tension_results import concerns_compliance, concerns_stiffness
    from metrology.tension.correction import corrected

    subject = Tension(*ready)
    if concerns_compliance(subject, found):
        text = (
            "{test} has no C: an effect that was found changes the difference between crosshead and extensometer, and "
            "not in proportion to the force. The diagnosis gives the compliance of the set-up as well."
        )
        task.model.failures.append(said(text, test=task.name))
        kept = tuple(one for one in stated.measurands if not one.name.endswith(".C"))
        stated = replace(stated, measurands=kept)
    return corrected(task.name, subject.stated, stated, found) if concerns_stiffness(subject, found) else stated


def yields(campaign: Declared, test: TensionTest) -> dict[str, str]:
    """Return the means, and of several specimens the results of each."""
    known = facts(campaign, test)
    return dict(known.results)


def loading(campaign: Declared, name: str, test: TensionTest, _finding: object) -> Loading:
    """The record's duration; an extensometer, and a set-up whose compliance is known, read the specimen alone."""
    known, sample = facts(campaign, test), campaign.samples.get(test.sample)
    times = [table.numbers["time"] for table in campaign.tables["tests", name] if "time" in table.numbers]
    stated = sample is not None and sample.length is not None
    alike = known.by_lengths or all(one.length is None for one in test.specimens.values())
    seconds = float(np.median([np.ptp(time) for time in times])) if times else None
    return Loading(seconds, setup=not (known.strain or known.setup or known.by_lengths), whole=stated and alike)


OUTPUTS = {
    "k": Output("N/m", "N/m", "stiffness"),
    "EA": Output("N", "kN", "axial stiffness"),
    "E": Output("Pa", "GPa", "modulus of elasticity"),
    "EA_sec": Output("N", "kN", "secant axial stiffness"),
    "k_sec": Output("N/m", "N/m", "secant stiffness"),
    "E_sec": Output("Pa", "GPa", "secant modulus"),
    "EA_tan": Output("N", "kN", "tangent axial stiffness"),
    "k_tan": Output("N/m", "N/m", "tangent stiffness"),
    "E_tan": Output("Pa", "GPa", "tangent modulus"),
    "C": Output("m/N", "nm/N", "compliance of the set-up"),
    "F_max": Output("N", "N", "largest force"),
    "R_m": Output("Pa", "MPa", "tensile strength"),
    "eps_b": Output("1", "%", "strain at break"),
    "tenacity": Output("N·m/kg", "cN/tex", "tenacity"),
}
METHOD = Method(
    title="Tension in a testing machine",
    standard="Laboratory method, docs/methods/tension.md; JCGM 100:2008",
    shown="What a tension test showed.",
    columns="`force / N`, `time / s` (optional), `crosshead / mm`, `extension / um` or `strain / %`; one file a "
    "specimen",
    remark="`E` exists where the section is known, `k` where a length is, `C` where crosshead and extensometer were "
    "read or specimens have three lengths or more.",
    references=("iso7500", "iso9513", "hac"),
    test=TensionTest,
    entries=(TensionInstruments, TensionRange, TensionSecant, TensionTangent, TensionSpecimen),
    outputs=OUTPUTS,
    yields=yields,
    takes=(),
    whole="specimen",
    readings=readings,
    check=check,
    analyse=analyse,
    finding=tension.TensionFinding,
    diagnose=diagnose,
    corrected=corrected,
    explain=None,
    loading=loading,
    carried=None,
)
