"""Area, mass per length and modulus of a sample."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from uncertainties import ufloat

from metrology import sample
from metrology.errors import MetrologyError

SIZES = {"round": (0.3e-3,), "ellipse": (2e-3, 1.5e-3), "tape": (25e-3, 0.05e-3), "area": (1.25e-6,)}


@pytest.mark.parametrize("shape", sample.SECTIONS)
def test_twice_area_serves_floats_arrays_and_variables(shape: str) -> None:
    kind = sample.SECTIONS[shape]
    plain = kind.area(*SIZES[shape])
    assert kind.area(*(np.full(3, size) for size in SIZES[shape])) == pytest.approx(np.full(3, plain))
    varied = kind.area(*(ufloat(size, 0.01 * size) for size in SIZES[shape]))
    assert varied.nominal_value == pytest.approx(plain)
    powers = {"round": 2.0, "ellipse": 2**0.5, "tape": 2**0.5, "area": 1.0}
    assert varied.std_dev / plain == pytest.approx(0.01 * powers[shape])


@pytest.mark.parametrize("shape", sample.SECTIONS)
def test_limit_area_vanishes_with_its_size(shape: str) -> None:
    kind = sample.SECTIONS[shape]
    assert kind.area(*(0.0 for _ in kind.dimensions)) == 0


def test_limit_ellipse_of_equal_axes_is_round() -> None:
    assert sample.ellipse_area(2e-3, 2e-3) == pytest.approx(sample.round_area(2e-3)) == pytest.approx(pi * 1e-6)


def test_reference_area_of_table_one() -> None:
    assert f"{1e6 * sample.round_area(0.3e-3):.4f}" == "0.0707"


def test_closed_form_area_and_modulus_as_measurands() -> None:
    area = sample.area("al", "tape")
    modulus = sample.modulus("t.E", k="t.k", length="al.length", area="al.A")
    namespace = {"al.width": 25e-3, "al.thickness": 0.05e-3, "t.k": 24734.25, "al.length": 2.990}
    namespace["al.A"] = area.function(namespace)
    assert (area.name, area.unit, modulus.unit) == ("al.A", "m²", "Pa")
    assert f"{modulus.function(namespace) / 1e9:.2f}" == "59.16"


def test_refusal_unknown_shape() -> None:
    with pytest.raises(MetrologyError) as refused:
        sample.area("al", "square")
    assert str(refused.value) == "sample.section.shape: got 'square'; expected one of round, ellipse, tape, area"
