"""Plausible findings built by hand, with every section that a report can have: no number here was measured."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from math import exp, log, pi, sqrt
from typing import Any

import numpy as np

from metrology.check import Check
from metrology.consensus import Candidate, Consensus, Disagreement, Member
from metrology.decay import DecayFinding, DecayRecord
from metrology.elongation import ElongationFinding, LoadLevel, RepeatLine
from metrology.findings import (
    SCHEMA,
    Anomaly,
    Assumption,
    AuditRow,
    CampaignItem,
    Comparison,
    Conformity,
    Correlation,
    Document,
    Findings,
    Fit,
    InputFile,
    InstrumentState,
    Moments,
    Opinion,
    Party,
    Provided,
    Result,
    SampleItem,
    TestItem,
)
from metrology.gum.evaluation import BudgetRow, Coverage, MonteCarlo

RECONSTRUCTED = "Readings are reconstructed from published results; they were not measured."
HOSTILE = (
    "<script>alert(1)</script>{{ 7*7 }}{% include 'x' %}<img src=\"file:///etc/passwd\"><link rel=attachment "
    "href='file:///etc/passwd'></style>--> \\frac{1}{0} $x$ & http://evil.example/x url(http://evil.example) "
    "\u202edrowssap\u202c \x07 試験 عربي"
)
#: Sample id: name, k in N/m, u(k), E in Pa, u(E), zeta, mass in kg.
SPECIMENS = {
    "al-1100": ("Al-1100 tape", 24734.25, 335.52, 59.16e9, 3.29e9, 0.14, 1.196),
    "peek": ("PEEK tape", 1810.91, 7.53, 4.35e9, 0.23e9, 0.0040, 1.196),
    "nylon": ("Nylon monofilament, 0.3 mm", 167.64, 1.9, 3.56e9, 0.11e9, 0.0618, 1.196),
    "spectra": (
        "Spectra braid with a rather long commercial name, 2 mm × 1.5 mm",
        753.33,
        9.8,
        1.2e9,
        0.07e9,
        0.1275,
        1.196,
    ),
}


def build(samples: int = 2, *, records: int = 3, reconstructed: bool = True) -> Findings:
    """Findings of a campaign over the first `samples` specimens, with `records` releases a decay test."""
    ids = tuple(SPECIMENS)[:samples]
    results = tuple(result for sample in ids for result in _results(sample))
    return Findings(
        schema=SCHEMA,
        campaign=_campaign(reconstructed=reconstructed),
        software={"metrology": "0.1.0", "numpy": "2.4.6", "python": "3.11.2", "scipy": "1.17.0", "weasyprint": "70.0"},
        inputs=tuple(
            InputFile(name, f"{index:02x}" * 32, 1234 + 77 * index)
            for index, name in enumerate(
                ["campaign.yaml", *(f"{s}-elongation.csv" for s in ids), *(f"{s}-decay.csv.gz" for s in ids)]
            )
        ),
        seed=20261120,
        samples=tuple(_sample(sample) for sample in ids),
        instruments=_instruments(ids),
        tests=tuple(test for sample in ids for test in (_elongation_test(sample), _decay_test(sample, records))),
        fits=(_fit(),),
        results=results,
        correlations=tuple(
            Correlation(a.name, b.name, 0.9 / (1 + abs(i - j)) * (-1) ** (i + j))
            for i, a in enumerate(results)
            for j, b in enumerate(results)
            if i < j and a.sample == b.sample
        ),
        conformity=_conformity(ids),
        comparisons=_comparisons(ids),
        consensus=tuple(_consensus(sample, consistent=i == 0) for i, sample in enumerate(ids)),
        disagreements=_disagreements(ids[1:]),
        audit=_audit(),
        warnings=("The vibrometer was overdue for calibration on the date of 2 tests.",),
        failures=("The direct fit of release 3 did not converge: the record may be too short; try a longer one.",),
        references=(
            "JCGM 100:2008, Evaluation of measurement data — Guide to the expression of uncertainty "
            "in measurement (GUM).",
            "JCGM 101:2008, Supplement 1 to the GUM — Propagation of distributions using a Monte Carlo method.",
            "JCGM 106:2012, The role of measurement uncertainty in conformity assessment.",
        ),
    )


def empty() -> Findings:
    """Findings of a campaign that asks for next to nothing: one derived result."""
    full = build(1)
    return replace(
        full,
        campaign=replace(full.campaign, reconstructed="", remarks="", deviations=()),
        **dict.fromkeys(
            (
                "samples",
                "instruments",
                "tests",
                "fits",
                "correlations",
                "conformity",
                "comparisons",
                "consensus",
                "disagreements",
                "audit",
                "warnings",
                "failures",
            ),
            (),
        ),
        results=(replace(full.results[1], sample="", test="", budget=full.results[1].budget[:1]),),
    )


def hostile(findings: Findings, payload: str = HOSTILE) -> Findings:
    """The same findings with `payload` appended to every text field but units and closed vocabularies."""
    kept = {
        "schema",
        "unit",
        "units",
        "display_unit",
        "x_unit",
        "y_unit",
        "state",
        "verdict",
        "kind",
        "sha256",
        "direction",
        "checklists",
        "parts",
        "stated",
        "languages",
        "decimal_sign",
        "role",
        "place",
        "sampling",
    }

    def poison(value: Any, name: str = "") -> Any:
        if isinstance(value, str):
            return (
                value if (name in kept and value in _CLOSED) or (not value and name == "excluded") else value + payload
            )
        if isinstance(value, tuple):
            return tuple(poison(item, name) for item in value)
        if is_dataclass(value) and not isinstance(value, type):
            return replace(
                value, **{f.name: poison(getattr(value, f.name), f.name) for f in fields(value) if f.name != "schema"}
            )
        if isinstance(value, dict):
            return {key + payload: poison(item) for key, item in value.items()}
        return value

    poisoned: Findings = poison(findings)
    return poisoned


_CLOSED = {
    *(
        "17025",
        "ecss",
        *("certificate", "annex", "quality"),
        "en",
        "point",
        "customer",
        "external provider",
        "applicable",
        "reference",
        "open",
        "closed",
        "laboratory",
        "none",
    ),
    *("provided", "deviations", "opinions", "anomalies", "assumptions", "documents"),
    *("N/m", "Pa", "GPa", "1", "%", "N·s/m", "m", "mm", "µm", "um", "N", "rad/s", "kg", "m/s^2", "kN/m", "s"),
    *(
        "valid",
        "overdue",
        "not calibrated",
        "pass",
        "conditional pass",
        "conditional fail",
        "fail",
        "A",
        "B",
        "loading",
        "unloading",
    ),
    *(f"{index:02x}" * 32 for index in range(16)),
}


def _campaign(*, reconstructed: bool) -> CampaignItem:
    return CampaignItem(
        id="tapes",
        title="Stiffness and damping of two tape tethers",
        report_number="TR-2026-001",
        issued="2026-11-20",
        laboratory=Party("Space Structures Test Laboratory", "1 Example Street, 00000 Exampletown", "lab@example.org"),
        customer=Party("Tether Programme Office", "2 Example Avenue, 00000 Exampletown", "office@example.org"),
        reconstructed=RECONSTRUCTED if reconstructed else "",
        remarks="Requested after the deployment review.",
        authorised_by="J. Doe, head of laboratory",
        probability=0.95,
        deviations=("The conditioning time before the test was 22 h instead of 24 h.",),
        checklists=("17025", "ecss"),
        purpose="Acceptance of spool 3 before its integration",
        place="laboratory",
        sampling="none",
        provided=(Provided("linear density of the tape", "Tether Programme Office", "customer"),),
        opinions=(Opinion("The tape is fit for a second deployment.", "J. Doe, head of laboratory", "modulus"),),
        anomalies=(Anomaly("NCR-7", "clamp slipped at load C", "open", "repeat used after re-clamping"),),
        assumptions=(Assumption("The clamps do not slip."),),
        documents=(Document("SP-12", "Elongation of tapes under dead loads", "3", "applicable"),),
        stated=("provided", "deviations", "opinions", "anomalies", "assumptions", "documents"),
    )


def _sample(sample: str) -> SampleItem:
    name = SPECIMENS[sample][0]
    return SampleItem(
        id=sample,
        name=name,
        material=name.split()[0],
        batch="B-2026-07, spool 3",
        condition="as received",
        received="2026-10-01",
        configuration="cut from spool 3, clamped at both ends",
        section="tape, width 25.000(29) mm, thickness 0.0500(27) mm",
        length="2.9900(12) m",
        linear_density="3.4 g/m",
        references=("E = 69.0(7) GPa (handbook)",),
    )


def _instruments(ids: tuple[str, ...]) -> tuple[InstrumentState, ...]:
    elongation, decay = tuple(f"{s}-elongation" for s in ids), tuple(f"{s}-decay" for s in ids)
    common = {"certificate": "C-123, Calibration House", "calibrated": "2026-03-01"}
    return (
        InstrumentState(
            id="indicator",
            kind="dial indicator",
            model="Example 543",
            serial="SN 0042",
            range="0 mm to 25 mm",
            resolution="0.01 mm",
            due="2027-03-01",
            uncertainty="U = 4 µm (k = 2)",
            state="valid",
            used_by=elongation,
            **common,
        ),
        InstrumentState(
            id="vibrometer",
            kind="laser vibrometer",
            model="Example LV-1",
            serial="SN 7",
            range="±5 mm",
            resolution="1 nm",
            due="2026-09-01",
            uncertainty="U = 0.5 % (k = 2)",
            state="overdue",
            used_by=decay,
            sentence="Overdue by 35 days on 2026-10-06.",
            **common,
        ),
        InstrumentState(
            id="hygrometer",
            kind="hygrometer",
            model="",
            serial="",
            range="",
            resolution="1 %",
            certificate="",
            calibrated="",
            due="",
            uncertainty="",
            state="not calibrated",
            used_by=elongation + decay,
        ),
    )


def _checks() -> tuple[Check, ...]:
    return (
        Check(
            "linearity (lack of fit)",
            1.31,
            0.28,
            True,
            "No lack of fit: the line describes the loads within their scatter.",
        ),
        Check(
            "zero shift between repeats",
            2.9,
            0.012,
            False,
            "The zero shifts between repeats by more than the resolution explains.",
        ),
        Check("loading against unloading", None, None, None, "Not tested: no unloading readings."),
    )


def _elongation_test(sample: str) -> TestItem:
    _, k, u_k, *_ = SPECIMENS[sample]
    rng = np.random.default_rng(7)
    loads = np.array([19.6, 39.2, 58.8]) * (1.0 if k > 5000 else 0.1)
    repeats = [f"{repeat}" for repeat in range(1, 6) for _ in range(6)]
    direction = (["loading"] * 3 + ["unloading"] * 3) * 5
    force = np.tile(np.concatenate([loads, loads[::-1]]), 5)
    extension = np.round((force / k + 2e-5 + rng.normal(0, 8e-6, force.size)) / 1e-5) * 1e-5
    excluded = [""] * force.size
    excluded[13], extension[13] = "indicator knocked", extension[13] + 1.6e-4
    fitted = 2e-5 + force / k
    return TestItem(
        id=f"{sample}-elongation",
        method="elongation",
        title="Elongation under dead loads",
        standard="Procedure SP-12, edition 3 (2026)",
        procedure="SP-12, edition 3",
        specification="TS-04, issue 2",
        as_run="SP-12-AR-017",
        setup="frame 2, upper clamp fixed",
        sample=sample,
        date="2026-10-05",
        operator="A. Operator",
        environment=("temperature 21.30(50) °C", "relative humidity 45.0(50) %", "pressure 1013.0(30) hPa"),
        instruments=("indicator", "hygrometer"),
        deviations=("The fourth load was left out.",) if sample == "peek" else (),
        exclusions=("line 14 of the readings: indicator knocked",),
        elongation=ElongationFinding(
            force=tuple(force),
            extension=tuple(extension),
            residual=tuple(extension - fitted),
            repeat=tuple(repeats),
            direction=tuple(direction),
            excluded=tuple(excluded),
            intercept=2e-5,
            slope=1 / k,
            slope_u=u_k / k**2,
            levels=tuple(
                LoadLevel(label, f, f / k + 2e-5, 8e-6, 10, k * (1 + 0.002 * i), u_k * 2.1, 3e-6 * (-1) ** i)
                for i, (label, f) in enumerate(zip("ABC", loads, strict=True))
            ),
            repeats=tuple(
                RepeatLine(str(r), d, k * (1 + 0.004 * rng.normal()), u_k * 1.7, 1e-5 * rng.normal() * (r > 1))
                for r in range(1, 6)
                for d in ("loading", "unloading")
            ),
            checks=_checks(),
            equations=("F = m g (1 - rho_a / rho_m)", "x = x_0 + F / k", "k = 1 / b"),
            notes=("Air buoyancy changes the force by 0.015 %.",),
        ),
    )


def _decay_test(sample: str, records: int) -> TestItem:
    return TestItem(
        id=f"{sample}-decay",
        method="decay",
        title="Free decay",
        standard="Procedure SP-13, edition 1 (2026)",
        procedure="SP-13, edition 1",
        specification="TS-04, issue 2",
        as_run="SP-13-AR-017",
        setup="frame 2, upper clamp fixed",
        sample=sample,
        date="2026-10-06",
        operator="A. Operator",
        environment=("temperature 21.10(50) °C",),
        instruments=("vibrometer", "hygrometer"),
        deviations=(),
        exclusions=(),
        decay=DecayFinding(
            records=tuple(_record(sample, index) for index in range(records)),
            mass=1.196,
            filter="Band-pass, second order, zero phase, 0.5 to 2 times the natural frequency; transverse "
            "motion and mains removed.",
            damping="Viscous: the decay rate does not change with amplitude (slope 0.4 standard "
            "uncertainties from zero).",
            checks=_checks()[:1],
            equations=(
                "delta = ln(A_1 / A_(n+1)) / n",
                "zeta = delta / sqrt(4 pi^2 + delta^2)",
                "c = 2 zeta sqrt(k m)",
            ),
        ),
    )


def _record(sample: str, index: int) -> DecayRecord:
    _, k, _, _, _, zeta, mass = SPECIMENS[sample]
    rng = np.random.default_rng(index)
    omega = sqrt(k / mass)
    damped = omega * sqrt(1 - zeta**2)
    end = min(3.0 / (zeta * omega), 60 * 2 * pi / omega)
    time = np.linspace(0, end, 4000)
    fit = 1.2e-3 * np.exp(-zeta * omega * time) * np.cos(damped * time)
    filtered = fit + 2e-6 * rng.normal(size=time.size).cumsum() / 30
    noisy = filtered + 1.5e-5 * rng.normal(size=time.size) + 4e-5 * np.sin(2 * pi * 0.9 * time)
    peak_time = np.arange(0, end * damped / pi) * pi / damped
    amplitude = 1.2e-3 * np.exp(-zeta * omega * peak_time) * (1 + 0.01 * rng.normal(size=peak_time.size))
    rate = zeta * omega * (1 + 0.03 * rng.normal(size=peak_time.size))
    floor = 9e-5
    return DecayRecord(
        record=f"{sample}-decay-{index + 1}.csv",
        time=tuple(time),
        displacement=tuple(noisy),
        filtered=tuple(filtered),
        fit=tuple(fit),
        peak_time=tuple(peak_time),
        peak_amplitude=tuple(amplitude),
        peak_used=tuple(bool(a > floor) for a in amplitude),
        noise_floor=floor,
        log_decrement=2 * pi * zeta / sqrt(1 - zeta**2),
        zeta_decrement=zeta * 1.002,
        zeta_decrement_u=zeta * 0.011,
        omega_decrement=omega,
        omega_decrement_u=omega * 2e-4,
        zeta_fit=zeta * 0.997,
        zeta_fit_u=zeta * 0.009,
        omega_fit=omega * 1.0002,
        omega_fit_u=omega * 1.5e-4,
        amplitude=tuple(amplitude),
        rate=tuple(rate),
        rate_u=(0.04 * zeta * omega,) * rate.size,
        filter_bias=2.3e-4,
        sentence="Both ways agree within their uncertainties.",
    )


def _fit() -> Fit:
    x = np.linspace(0, 25e-3, 11)
    y = 1e-6 + 1.2e-4 * x + 4e-7 * np.sin(9 * np.arange(11))
    curve = np.linspace(0, 25e-3, 60)
    return Fit(
        name="indicator-line",
        model="line",
        parameters=("a", "b"),
        values=(1.02e-6, 1.2e-4),
        u=(2.4e-7, 1.7e-5),
        units=("m", "1"),
        correlation=((1.0, -0.866), (-0.866, 1.0)),
        dof=9.0,
        residual_standard_deviation=4.1e-7,
        chi_squared=None,
        p_value=None,
        sentence="No lack of fit was found.",
        x=tuple(x),
        y=tuple(y),
        x_unit="m",
        y_unit="m",
        curve_x=tuple(curve),
        curve_y=tuple(1e-6 + 1.2e-4 * curve),
        curve_u=tuple(2e-7 + 1.5e-5 * abs(curve - 12.5e-3)),
    )


def _results(sample: str) -> tuple[Result, ...]:
    _, k, u_k, e, u_e, zeta, mass = SPECIMENS[sample]
    omega, c = sqrt(k / mass), 2 * zeta * sqrt(k * mass)
    test, decay = f"{sample}-elongation", f"{sample}-decay"
    return (
        _result(f"{test}.k", "k", k, u_k, ("N/m", "N/m"), "k = 1 / b", 12.4),
        _result(f"{sample}.E", "E", e, u_e, ("Pa", "GPa"), "E = k * L / (w * t)", None, law_valid=False),
        _result(
            f"{decay}.omega_n",
            "omega_n",
            omega,
            omega * 2e-4,
            ("rad/s", "rad/s"),
            "omega_n = omega_d / sqrt(1 - zeta^2)",
            41.0,
        ),
        _result(f"{decay}.zeta", "zeta", zeta, zeta * 0.011, ("1", "%"), "zeta = delta / sqrt(4 pi^2 + delta^2)", 8.0),
        _result(f"{decay}.c", "c", c, c * 0.013, ("N·s/m", "N·s/m"), "c = 2 zeta sqrt(k m)", 9.1),
    )


def _result(
    name: str,
    quantity: str,
    value: float,
    u: float,
    units: tuple[str, str],
    equation: str,
    dof: float | None,
    *,
    law_valid: bool = True,
) -> Result:
    scope = name.rpartition(".")[0]
    method = "derived" if quantity == "E" else scope.rpartition("-")[2]
    factor = 2.0 if dof is None else 2.0 + 2.4 / dof
    return Result(
        name=name,
        sample=scope.removesuffix("-elongation").removesuffix("-decay"),
        test="" if quantity == "E" else scope,
        method=method,
        quantity=quantity,
        value=value,
        u=u,
        framework=Moments(value, u),
        unit=units[0],
        dof=dof,
        dof_note="" if dof else "infinite: every component is of Type B",
        display_unit=units[1],
        coverage=Coverage(0.95, factor, value - factor * u, value + factor * u),
        monte_carlo=_monte_carlo(value, u, law_valid=law_valid),
        budget=_budget(value, u, units[0]),
        advice="The thickness of the section dominates; with u = 0.0013 mm instead of 0.0027 mm the "
        "result's u would halve.",
        equation=equation,
    )


def _monte_carlo(value: float, u: float, *, law_valid: bool) -> MonteCarlo:
    skew = 0.0 if law_valid else 0.35
    edges = np.linspace(value - 4 * u, value + 4.6 * u, 61)
    z = (0.5 * (edges[1:] + edges[:-1]) - value) / u
    density = np.exp(-0.5 * z**2) * (1 + skew * np.tanh(z)) / (u * sqrt(2 * pi))
    verdict = (
        "The GUM uncertainty framework is confirmed to 2 digits (JCGM 101, clause 8)."
        if law_valid
        else "The GUM uncertainty framework is not confirmed: its interval ends too low, by its skewness."
    )
    return MonteCarlo(
        mean=value,
        u=u * 1.003,
        low=value - 1.94 * u,
        high=value + (1.97 + skew) * u,
        shortest_low=value - 1.92 * u,
        shortest_high=value + (1.93 + skew) * u,
        p=0.95,
        trials=170000,
        converged=True,
        law_valid=law_valid,
        verdict=verdict,
        tolerance=10.0 ** int(log(u) / log(10) - 1) / 2,
        d_low=0.001 * u,
        d_high=0.3 * u,
        edges=tuple(edges),
        density=tuple(density),
    )


def _budget(value: float, u: float, unit: str) -> tuple[BudgetRow, ...]:
    rows = [
        (
            "al-1100.thickness",
            "micrometer readings along the tape",
            "thickness of the section",
            5e-5,
            2.7e-6,
            "m",
            "normal",
            "A",
            11.0,
            0.62,
        ),
        ("al-1100.width", "certificate", "width of the section", 25e-3, 2.9e-5, "m", "rectangular", "B", None, 0.02),
        (
            "al-1100.length",
            "steel tape",
            "free length between the clamps",
            2.99,
            1.2e-3,
            "m",
            "rectangular",
            "B",
            None,
            0.01,
        ),
        (
            "al-1100-elongation.b",
            "repeatability",
            "slope of the line",
            4.04e-5,
            5.3e-7,
            "m/N",
            "Student",
            "A",
            27.0,
            0.28,
        ),
        ("indicator", "resolution", "correction of the indicator", 0.0, 2.9e-6, "m", "rectangular", "B", None, 0.05),
        (
            "gravity",
            "gravity map",
            "local acceleration of free fall",
            9.806,
            5.8e-4,
            "m/s^2",
            "rectangular",
            "B",
            None,
            0.03,
        ),
        (
            "mass-C",
            "certificate of the weight set, class M1",
            "mass of load C",
            6.0,
            1e-4,
            "kg",
            "normal",
            "B",
            50.0,
            -0.01,
        ),
    ]
    return tuple(
        BudgetRow(
            input=name,
            component=component,
            description=description,
            value=x,
            u=u_x,
            unit=x_unit,
            distribution=distribution,
            kind=kind,
            dof=dof,
            sensitivity=sqrt(abs(share)) * u / u_x * (-1) ** i,
            contribution=sqrt(abs(share)) * u * (-1) ** i,
            share=share,
            source="certificate C-123",
        )
        for i, (name, component, description, x, u_x, x_unit, distribution, kind, dof, share) in enumerate(rows)
    )


def _conformity(ids: tuple[str, ...]) -> tuple[Conformity, ...]:
    verdicts = ("pass", "conditional pass", "conditional fail", "fail")
    offsets = (4.0, 0.9, -0.8, -5.0)
    return tuple(
        Conformity(
            requirement=f"R{i + 1}",
            text=f"The stiffness of {sample} shall be at least the value of the drawing.",
            result=f"{sample}-elongation.k",
            quantity="k",
            value=SPECIMENS[sample][1],
            u=SPECIMENS[sample][2],
            unit="N/m",
            display_unit="kN/m",
            lower=SPECIMENS[sample][1] - offsets[i] * SPECIMENS[sample][2],
            upper=None,
            rule="guard band w = 1.00 U",
            guard_band=2 * SPECIMENS[sample][2],
            acceptance_lower=SPECIMENS[sample][1] - (offsets[i] - 2) * SPECIMENS[sample][2],
            acceptance_upper=None,
            probability=0.5 + 0.5 * (1 - exp(-abs(offsets[i]))) * (1 if offsets[i] > 0 else -1),
            verdict=verdicts[i],
            specific_risk=0.001 * 10**i / 2,
            global_consumer_risk=0.012 if i == 0 else None,
            global_producer_risk=0.034 if i == 0 else None,
            rule_risk=0.0228,
            agreed="2026-09-15",
            source="TS-04 issue 2, 3.1",
            close_out="closed by this report",
            sentence=f"k of {sample} meets the requirement with the stated probability of conformity.",
        )
        for i, sample in enumerate(ids)
    )


def _comparisons(ids: tuple[str, ...]) -> tuple[Comparison, ...]:
    return tuple(
        Comparison(
            title="static against dynamic stiffness",
            a=f"{sample}-elongation.k",
            b=f"{sample}-decay.k",
            value_a=SPECIMENS[sample][1],
            u_a=SPECIMENS[sample][2],
            value_b=SPECIMENS[sample][1] * 1.01,
            u_b=SPECIMENS[sample][2] * 0.4,
            unit="N/m",
            display_unit="kN/m",
            difference=-0.01 * SPECIMENS[sample][1],
            u_difference=1.1 * SPECIMENS[sample][2],
            en=-0.37 - i,
            agrees=i == 0,
            sentence="They agree within their uncertainties."
            if i == 0
            else "They differ by more than their uncertainties explain.",
        )
        for i, sample in enumerate(ids)
    )


def _consensus(sample: str, *, consistent: bool) -> Consensus:
    k, u = SPECIMENS[sample][1:3]
    members = (
        Member(f"{sample}-elongation.k", f"{sample}-elongation", "elongation", k, u, 60.0, 0.4, -0.3),
        Member(f"{sample}-decay.k", f"{sample}-decay", "decay", 1.01 * k, 0.8 * u, 0.007, 0.6, 0.3),
        Member(f"{sample}-decay.k", f"{sample}-decay", "decay", 1.2 * k, u, None, None, None, "it has no uncertainty"),
    )
    return Consensus(
        sample, "k", "N/m", "kN/m", members, 1.006 * k, 0.6 * u, 0.95, 0.99 * k, 1.02 * k, None if consistent else 1,
        consistent, 0.3 if consistent else 9.1, 0.6 if consistent else 0.003, 0.5 if consistent else 3.0,
        0.0 if consistent else 0.02, "The 2 results were combined.",
    )  # fmt: skip


def _disagreements(samples: tuple[str, ...]) -> tuple[Disagreement, ...]:
    candidates = (
        Candidate("set-up", "compliance of a set-up", 0.9, 3.2, "C", 1.7e-7, 2e-8, "m/N", 0.4),
        Candidate("scatter", "scatter between the tests", 0.0996, 0.0, "τ", 0.02, 0.01, "1", None),
        Candidate("chance", "chance alone", 0.0004, -5.0, "", None, None, "1", 0.003),
    )
    made = Disagreement("k", samples, "ambiguous", "These results do not decide.", candidates)
    return (made,) if samples else ()


def _audit() -> tuple[AuditRow, ...]:
    return (
        AuditRow(
            "k of Al-1100 (Table II)",
            "the paper",
            "24734.25 ± 335.52 N/m",
            "24734.25 ± 335.52 N/m",
            "0.00 N/m",
            True,
            "Agrees.",
        ),
        AuditRow(
            "difference to the reference modulus",
            "the paper, page 6",
            "14 %",
            "16.6 %",
            "2.6 %",
            False,
            "Published 14 %, recomputed 16.6 %: 69.0 is 16.6 % larger than 59.16.",
        ),
    )
