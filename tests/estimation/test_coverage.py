"""Do 95 % intervals cover the truth, with all inputs drawn from what is stated of them?"""

import numpy as np
import pytest
from response_cases import MATERIALS, PRIORS, runs_of, stated, truth_of
from truth_response import Instruments

from metrology.estimation import fit

RATES = Instruments(rates=(50.0, 50.0, 100.0))


def misses(seeds, materials):
    """For every campaign and parameter: whether its interval misses the truth, and the pull."""
    missed, pulls = [], []
    for seed in seeds:
        material = materials[seed % len(materials)]
        found = fit(stated(material), runs_of(truth_of(material), seed, instruments=RATES), priors=PRIORS)
        assert found.status == "ok", found.sentence
        for name, true in zip("kc", MATERIALS[material], strict=True):
            entry = found.parameter(name)
            missed.append(not (entry.low or 0.0) <= true <= entry.high)
            pulls.append((entry.value - true) / entry.u)
    return np.array(missed), np.array(pulls)


@pytest.mark.long
def test_law_intervals_cover_small_seeded_part():
    missed, pulls = misses(range(100, 112), tuple(MATERIALS))
    # 24 intervals at 95 %: more than 5 misses have a probability of 1 in 1000.
    assert missed.sum() <= 5
    assert np.std(pulls) < 1.6


@pytest.mark.study
def test_law_intervals_cover_in_93_to_97_percent():
    missed, pulls = misses(range(1000, 1500), tuple(MATERIALS))
    print(
        f"{len(pulls)} intervals of 500 campaigns: {100 * (1 - missed.mean()):.2f} % cover, pulls {np.std(pulls):.3f}"
    )
    assert 0.93 <= 1 - missed.mean() <= 0.97
