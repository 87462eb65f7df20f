"""Method `response`: a module on the line, its motion, and the model judged by runs that were kept out of the fit.

`schema`, `known` and `units` are its part of the campaign file, `checks` what must hold there; `runs`, `preparation`
and `evaluation` hand a test to the analysis, and are the only ones that need the rig.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from metrology.coordinate import TURNED
from metrology.method import Analysed, Method, Output, Task
from metrology.method.instruments import has_modulus
from metrology.methods.response import schema
from metrology.methods.response.checks import check_response, parameters, readings
from metrology.methods.response.known import Known, Spread
from metrology.methods.response.schema import ResponseTest
from metrology.methods.response.units import parameter_unit
from metrology.response import ResponseFinding

if TYPE_CHECKING:
    import numpy as np

    from metrology.diagnosis import Diagnosis
    from metrology.gum.evaluation import Contribution
    from metrology.method.declared import Declared
    from metrology.methods.response.evaluation import Ready


def yields(campaign: Declared, test: ResponseTest) -> dict[str, str]:
    """Return what the runs give: k and c where they are sought, E where it can be computed from k."""
    turned = TURNED if test.rig.coordinate == "angle" else {}
    return {
        name: turned.get(output.unit, output.unit)
        for name, output in OUTPUTS.items()
        if test.yields(name) and (name != "E" or has_modulus(campaign, test))
    }


def analyse(task: Task[ResponseTest]) -> Analysed[Ready]:
    """Put what was sought into the model, with the verdict on the model of the rig."""
    from metrology.methods.response import evaluation

    return evaluation.analyse(task)


def diagnose(task: Task[ResponseTest], ready: Ready, rng: np.random.Generator) -> Diagnosis:
    """What the model of the rig lacks."""
    from metrology.methods.response import evaluation

    return evaluation.diagnose(task, ready, rng)


def corrected(task: Task[ResponseTest], ready: Ready, stated: Contribution, found: Diagnosis) -> Contribution:
    """k, c and what follows from them by the model that the data support."""
    from metrology.methods.response import evaluation

    return evaluation.corrected(task, ready, stated, found)


def carried(campaign: Declared, test: ResponseTest, name: str) -> str:
    """Unit of a parameter of the equation of motion, the laboratory's own forces included."""
    return parameter_unit(name, test, parameters(campaign))


OUTPUTS = {
    "k": Output("N/m", "N/m", "stiffness"),
    "c": Output("N·s/m", "N·s/m", "damping coefficient"),
    "zeta": Output("1", "%", "damping ratio"),
    "omega_n": Output("rad/s", "rad/s", "natural angular frequency"),
    "E": Output("Pa", "GPa", "modulus of elasticity"),
}
METHOD = Method(
    title="Response of a module on the line",
    standard="Laboratory method, docs/methods/response.md; JCGM 100:2008; ASME V&V 20-2009",
    shown="What a response test showed.",
    columns="`time / s` (increasing), any of `x / m`, `v / m/s`, `T / N`, `F / N`; an empty cell is a gap",
    remark="`k` and `c` exist where they are sought, `E` where `k` is and length and section of the sample are given.",
    # Fit, noise, intervals, evidence, verification.
    references=(
        "paper", "vv20", "sprague", "irvine", "marquardt", "neldermead", "profile", "geyer", "gasser", "golub",
        "mackay", "jackknife",
    ),
    test=ResponseTest,
    entries=(
        schema.ResponseInstruments, schema.StatedRig, Known, Spread, schema.Given, schema.Identify, schema.StartValues,
        schema.StatedNoise, schema.StatedRun, schema.Thrusting, schema.Start,
    ),
    outputs=OUTPUTS,
    yields=yields,
    takes=("elongation", "decay"),
    whole="",
    readings=readings,
    check=check_response,
    analyse=analyse,
    finding=ResponseFinding,
    diagnose=diagnose,
    corrected=corrected,
    explain=None,
    loading=None,
    carried=carried,
)  # fmt: skip
