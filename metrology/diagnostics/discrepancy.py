"""A modulus or stiffness off its reference: what each possible cause would be, and whether the data allow it."""

from __future__ import annotations

import math

from metrology.diagnosis import Discrepancy
from metrology.diagnostics.discrepancy_causes import every_cause
from metrology.diagnostics.discrepancy_setting import Setting
from metrology.elongation import ElongationTest
from metrology.message import said


def explain(test: ElongationTest, setting: Setting) -> Discrepancy:
    """What could part a modulus from its reference, cause by cause, each computed from the data of the test.

    A stiffness off its reference has the same causes but for section and length, which it does not take. With
    ρ = E/E_ref: a section of ρ·A; a length of L/ρ; a frame of compliance C = (1 − ρ)/k in series; clamps
    that slip by (1 − ρ) of the extension in every repeat; forces that are 1/ρ of the stated ones; an indicator that
    shows 1/ρ of the travel; or a reference of E itself.

    Parameters
    ----------
    test : ElongationTest
        Whose readings are asked.
    setting : Setting
        What is known around it.
    """
    result, reference, k = setting.found, setting.reference, setting.stiffness
    rho = result.value / reference.value
    # What k brings to u(E) counts; what section and length bring is weighed cause by cause.
    u_rho = rho * math.hypot(result.relative, reference.relative)
    own = rho * math.hypot(k.relative, reference.relative)
    U = 2 * math.hypot(result.u or 0.0, reference.u or 0.0)
    normalised = abs(result.value - reference.value) / U if U > 0 else None
    if setting.en is not None:
        normalised = abs(setting.en)
    found = tuple(
        sorted(every_cause(test, setting, rho, own), key=lambda one: (one.judgement != "allowed", one.tension or 0.0))
    )
    allowed = tuple(one.title for one in found if one.judgement == "allowed")
    text = (
        "{symbol} is {percent:.1f} % below its reference ({beyond})."
        if rho < 1
        else "{symbol} is {percent:.1f} % above its reference ({beyond})."
    )
    sentence = said(
        "{texts:space}",
        texts=(
            said(text, symbol=setting.quantity, percent=100 * abs(1 - rho), beyond=_beyond(normalised)),
            said("These data and what is stated allow: {causes:lowered comma}.", causes=allowed)
            if allowed
            else said("These data and what is stated allow: none of the causes by itself."),
        ),
    )
    return Discrepancy(
        setting.quantity,
        result.value,
        result.u or 0.0,
        reference.value,
        reference.u,
        reference.source,
        rho,
        u_rho,
        normalised,
        found,
        sentence,
    )


def _beyond(normalised: float | None) -> str:
    if normalised is None:
        return said("nothing was stated of either")
    text = (
        "E_n = {size:.2f}, beyond the stated uncertainties"
        if normalised > 1
        else "E_n = {size:.2f}, within the stated uncertainties"
    )
    return said(text, size=float(normalised))
