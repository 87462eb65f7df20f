"""Do the 95 % bands of a prediction hold 95 % of the readings, with all inputs drawn from what is stated of them?"""

from dataclasses import replace

import numpy as np
import pytest
from response_cases import HELD_OUT, MATERIALS, PRIORS, SHORT, runs_of, stated, truth_of
from truth_response import Instruments

from metrology.estimation import fit
from metrology.verify import open_loop

RATES = Instruments(rates=(50.0, 0.0, 100.0))


@pytest.mark.study
def test_law_bands_hold_95_percent_of_the_readings():
    """Errors of one thrust move a whole run, so each run counts as one; two runs of each of 120 campaigns."""
    shares = {"x": [], "T": []}
    for seed in range(120):
        material = tuple(MATERIALS)[seed % 2]
        runs = runs_of(truth_of(material), seed, tests=(*SHORT, *HELD_OUT), instruments=RATES)
        held = [replace(run, purpose="verification") for run in runs[2:]]
        found = fit(stated(material), [*runs[:2], *held], priors=PRIORS)
        for run in held:
            ahead = open_loop(found, run, np.random.default_rng(seed))
            for name in shares:
                y = run.readings(name)
                shares[name].append(float(((y >= ahead.low[name]) & (y <= ahead.high[name])).mean()))
    for name, values in shares.items():
        spread = np.std(values) / np.sqrt(len(values) / 2)
        print(f"{name}: {100 * np.mean(values):.2f} % of the readings in the band, u = {100 * spread:.2f} %")
        assert abs(np.mean(values) - 0.95) < 0.01 + 2 * spread
