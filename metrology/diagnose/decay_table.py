"""Causes that a free decay may hide, and what each means for the laboratory."""

from __future__ import annotations

import math

from metrology.diagnose.candidate import Candidate, Size

INF = math.inf


def _line(name: str, *, decays: bool) -> tuple[Size, ...]:
    rate = (Size(f"{name}.rate", "1/s", 0.0, -1.0, 1e3, 0.1, True),) if decays else ()
    return (
        Size(f"{name}.sin", "m", 0.0, -INF, INF, 1e-6, own=True),
        Size(f"{name}.cos", "m", 0.0, -INF, INF, 1e-6, own=True),
        Size(f"{name}.frequency", "Hz", 1.0, 1e-3, 1e5, 0.01, True),
        *rate,
    )


TABLE: dict[str, Candidate] = {
    one.name: one
    for one in (
        Candidate(
            "friction", "Dry (Coulomb) friction", "m·x″ + c·x′ + k·x = −F_c·sign(x′)",
            (Size("friction.force", "N", 0.0, 0.0, INF, 1e-4),),
            "the decay rate grows as the amplitude falls, in proportion to its inverse; the plate stops off its zero",
            "ζ and c come out too large, c by 4·F_c/(π·ω·A), more so the smaller the amplitude A; k hardly changes",
            "let the plate hang free of guides and cables, and evaluate the first periods",
            "releases from half and from twice the amplitude: the rate times the amplitude stays the same",
        ),
        Candidate(
            "quadratic drag", "Quadratic damping", "m·x″ + c·x′ + k·x = −b₂·|x′|·x′",
            (Size("drag.quadratic", "N·s²/m²", 0.0, 0.0, INF, 1e-2),),
            "the decay rate falls with the amplitude, in proportion to it",
            "ζ and c come out too large, by 8·b₂·ω·A/(3π) in c at the amplitude A; k hardly changes",
            "use a smaller release or a smaller plate, or a screen against the air",
            "a release at half the amplitude, or a plate of twice the area",
        ),
        Candidate(
            "cubic", "Amplitude-dependent frequency (hardening or softening)", "m·x″ + c·x′ + k·x + k₃·x³ = 0",
            (Size("cubic.stiffness", "N/m³", 0.0, -INF, INF, 1e6),),
            "the frequency moves with the square of the amplitude; a line at three times the frequency",
            "ω_n and the dynamic k are those of a mean amplitude A, k off by 3·k₃·A²/4; c by half that share",
            "state k and c with their amplitude, or extrapolate to none",
            "elongation in steps over the same extension, or releases from several amplitudes",
        ),
        Candidate(
            "damping", "Amplitude-dependent damping of the sample", "m·x″ + (c + c₁·|x|)·x′ + k·x = 0",
            (Size("damping.amplitude", "N·s/m²", 0.0, -INF, INF, 1.0),),
            "the decay rate changes with the amplitude, in proportion to it",
            "c is a mean over the amplitudes of the record, off by 4·c₁·A/(3π) at the amplitude A; k hardly changes",
            "state c with its amplitude",
            "another mass on the same sample: c₁ stays, the drag of air b₂ grows with the speed",
        ),
        Candidate(
            "setup", "Compliance of the set-up in series", "1/k_seen = 1/k + C",
            (Size("setup.compliance", "m/N", 0.0, 0.0, INF, 1e-7),),
            "none in these records: exactly a lower k and another c",
            "k_dyn comes out too small by 1/(1 + C·k), c by its square",
            "aim the vibrometer at the specimen's both ends",
            "a second vibrometer on the frame, or the same sample on a frame of known, different stiffness",
        ),
        Candidate(
            "drift", "Drift of the sensor, or motion slower than the record", "y = … + Σ a_n·P_n(2t/T − 1), n = 1 … 4",
            (Size("drift", "m", 0.0, 0.0, INF, 1e-6),),
            "the mean of the record moves from its begin to its end",
            "peaks of one sign are too large, of the other too small; k and c hardly change where both are used",
            "let the vibrometer warm up; keep its stand off the frame",
            "a record of the plate at rest, as long as the others; a longer record shows a swing as a swing",
        ),
        Candidate(
            "other", "Transverse or pendulum motion", "y = … + e^{−λt}·(a·sin 2πft + b·cos 2πft)",
            _line("other", decays=True),
            "a beat, or a second line in the spectrum, that decays with a rate of its own",
            "ζ from peaks is biased where the beat is slow; k hardly changes",
            "release straight, on the axis",
            "a second vibrometer across the axis",
        ),
        Candidate(
            "mains", "Mains in the record", "y = … + a·sin 2πft + b·cos 2πft, f a multiple of the mains",
            _line("mains", decays=False),
            "a line at a multiple of the mains frequency that does not decay",
            "small peaks are biased, and ζ and c with them; k hardly changes",
            "part supply and earth of the vibrometer from the rest",
            "a record of the plate at rest",
        ),
    )
}  # fmt: skip
"""Every candidate of a free-decay test."""
