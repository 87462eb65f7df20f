"""Free decays and elongation tests of the independent generators, as the diagnosis takes them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import truth_decay
import truth_elongation

from metrology.decay import DecayTest
from metrology.elongation import ElongationTest, Load, Reading
from metrology.gum import Component, Input, Normal, Rectangular
from metrology.timeseries import Channel


def stretched(material: str, seed: int, planted: dict[str, float]) -> ElongationTest:
    """Elongation test with effects of these sizes; a slip or misreading at a place drawn by the seed."""
    rng = np.random.default_rng(seed)
    one = replace(truth_elongation.MATERIALS[material], **planted)
    one = replace(one, where=int(rng.integers(2, (1 + one.unloads) * len(one.masses) - 3)))
    rows = truth_elongation.readings(one, rng)
    loads = tuple(
        Load(f"m{at}", Input(f"t.load m{at}", mass, (Component("balance", Normal(one.mass_u)),), "kg"))
        for at, mass in enumerate(one.masses)
    )
    return ElongationTest(
        "t", loads, tuple(Reading(*row, line=at + 2) for at, row in enumerate(rows)),
        Component("resolution", Rectangular(one.division / 2)), Input("gravity", truth_elongation.GRAVITY, (), "m/s²"),
        Input("air density", 0.0, (), "kg/m³"), Input("weight density", 8000.0, (), "kg/m³"),
        indicator=(Component("certificate", Normal(one.indicator)),),
    )  # fmt: skip


def decayed(
    material: str, seed: int, planted: dict[str, float], *, count: int = 5
) -> tuple[DecayTest, truth_decay.Decaying]:
    """Free-decay test with effects of these sizes, and its truth."""
    truth, eye = truth_decay.planted(truth_decay.MATERIALS[material], truth_decay.Vibrometer(), planted)
    made = truth_decay.releases(truth, eye, count, np.random.default_rng(seed))
    records = tuple(Channel(f"record-{at}", t, x, "m") for at, (t, x) in enumerate(made))
    return DecayTest("d", records, Input("d.mass", truth.m, unit="kg"), "k"), truth
