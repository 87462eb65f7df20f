"""What overlies a decay: lines of one frequency, and small steps that slow motion follows in part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plain_cases import decayed

from metrology.diagnostics import decay
from metrology.diagnostics.decay import Decay
from metrology.diagnostics.overlays import lines
from metrology.diagnostics.release import Line
from metrology.timeseries import Channel


@pytest.mark.long
@pytest.mark.parametrize(("frequencies", "turns", "found"), [
    ((7.0, 7.01, 6.99), 20.0, ["other"]),
    ((7.0, 7.01, 9.0), 20.0, ["other"]),
    ((5.0, 7.0, 9.0), 20.0, []),  # what something else leaves in the spectrum of each record
    ((7.0, 7.01, 6.99), 1.5, []),  # slow motion
])  # fmt: skip
def test_law_a_line_has_one_frequency_and_turns(frequencies: tuple[float, ...], turns: float, found: list[str]) -> None:
    test, _ = decayed("peek", 3, {}, count=3)
    prepared = Decay(test)
    prepared.records = [
        replace(one, lines=(Line(frequency, 5 * one.noise, False, one.noise, turns),))
        for one, frequency in zip(prepared.records, frequencies, strict=True)
    ]
    overlays = list(lines(prepared))
    assert [one.effect for one in overlays] == found
    assert all(f"{sum(6.9 < one < 7.1 for one in frequencies)} of 3" in one.sentence for one in overlays)


@pytest.mark.long
@pytest.mark.parametrize(
    ("size", "named", "group"), [(0.12, (), {"drift", "hop"}), (0.2, ("hop",), set()), (0.3, ("hop",), set())]
)
def test_planted_steps_too_small_to_be_taken_out_are_no_drift(size: float, named: tuple[str], group: set[str]) -> None:
    """Steps of a part of the noise of a reading."""
    test, _ = decayed("peek", 4, {}, count=3)
    u = float(np.mean([one.noise for one in Decay(test).records]))
    rng = np.random.default_rng(4)

    def stepped(one: Channel) -> Channel:
        when = one.time[0] + rng.uniform(0.4, 0.6) * float(one.time[-1] - one.time[0])
        return replace(one, value=one.value + size * u * (one.time > when))

    found = decay(replace(test, records=tuple(map(stepped, test.records))), rng=rng)
    assert found.named == named
    assert set().union(*found.groups) == group
    assert found.verdict == ("ambiguous" if group else "explained")


@pytest.mark.long
@pytest.mark.parametrize("form", [lambda part: part, lambda part: 1 / (1 + np.exp(-(part - 0.5) / 0.1))])
def test_planted_small_drift_is_no_step(form) -> None:
    """As small as the steps above, even where most of it comes in a short time."""
    test, _ = decayed("peek", 4, {}, count=3)
    u = float(np.mean([one.noise for one in Decay(test).records]))

    def drifting(one: Channel) -> Channel:
        part = (one.time - one.time[0]) / (one.time[-1] - one.time[0])
        return replace(one, value=one.value + 0.3 * u * form(part))

    found = decay(replace(test, records=tuple(map(drifting, test.records))), rng=np.random.default_rng(4))
    assert found.named == ("drift",)
