"""How often a reading of a held-out run lies inside the 95 % prediction band of the extended model.

``python studies/prediction.py [--each N] [--out docs/studies/prediction.md]``: an effect is planted at d = 40 by the
independent generator, the model that carries it is fitted to a step and an impulse, and two runs at another thrust are
predicted open loop, nothing of them being re-estimated. Beside it: the model without the effect.
"""

from __future__ import annotations

import argparse
import zlib
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from judging import REACHED
from planting import EVERY, MATERIALS, PLANS, SHORT, drawn, sized, stated

from metrology import __version__
from metrology.estimation import fit
from metrology.rig import Rig
from metrology.verify.prediction import open_loop

EFFECTS = ("friction", "drag", "quadratic drag", "tilt", "cubic", "damping", "slip", "thrust lag", "cell drift")
"""Effects of one parameter that a fit can seek from their true size on."""
PLAN, D = "few", 40.0


def inside(rig: Rig, runs: list, free: tuple[str, ...], rng: np.random.Generator) -> tuple[int, int]:
    """Readings of the held-out runs inside their bands, and all; none where the fit fails or the motion is lost."""
    count = len(SHORT)
    found = fit(rig, runs[:count], free=free, priors=PLANS[PLAN][1])
    right, of = 0, 0
    for run in runs[count:] if found.status == "ok" else ():
        ahead = open_loop(found, run, rng)
        for channel in run.channels if ahead is not None else ():
            y, used = run.readings(channel), run.used(channel)
            within = (y >= ahead.low[channel]) & (y <= ahead.high[channel])
            right, of = right + int(within[used].sum()), of + int(used.sum())
    return right, of


def case(effect: str, material: str, turn: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """Readings inside the bands of the extended and of the plain model."""
    seed = 80_000 + 10 * (zlib.crc32(f"{effect} {material}".encode()) % 1000) + turn
    fields, reached = sized(effect, material, PLAN, D, seed)
    if not REACHED < reached / D < 1.4:  # A size that stops the module, or does nothing more.
        return (0, 0), (0, 0)
    runs = drawn(material, PLANS[PLAN][0], fields, seed)
    plain = stated(material, on_k=1.0, on_c=1.0)
    sizes = {name: value(fields) for name, value in EVERY[effect].values.items()}
    rng = np.random.default_rng(seed)
    extended = inside(plain.with_values(sizes), runs, ("k", "c", *sizes), rng)
    return extended, inside(plain, runs, ("k", "c"), rng)


def main() -> None:
    """Run the study and write its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=2, help="campaigns of every effect and material")
    parser.add_argument("--out", type=Path, default=Path("docs/studies/prediction.md"))
    given = parser.parse_args()
    lines, judged, total = [], [], np.zeros((2, 2))
    for effect in EFFECTS:
        own = np.array([case(effect, material, turn) for material in MATERIALS for turn in range(given.each)])
        total += own.sum(axis=0)
        after, before = (100 * own[:, at, 0].sum() / max(own[:, at, 1].sum(), 1) for at in (0, 1))
        judged.append(int((own[:, 0, 1] > 0).sum()))
        lines.append(f"| {effect} | {judged[-1]} | {before:.1f} % | {after:.1f} % |")
    before, after = (100 * total[at, 0] / max(total[at, 1], 1) for at in (1, 0))
    made = f"Version {__version__}, {datetime.now(UTC):%Y-%m-%d}."
    text = "\n".join(
        [
            "# Readings inside the 95 % prediction band", "",
            f"{made} `python studies/prediction.py --each {given.each}`.", "",
            "Held-out runs at another thrust, predicted open loop by a model fitted to a step and an impulse; effects",
            f"planted at d = {D:g} by `tests/truth_full.py`, in all four materials. Asked for: 90 % to 98 %.", "",
            "| planted | campaigns | without the effect | extended |", "|---|---|---|---|", *lines,
            f"| all | {sum(judged)} | {before:.1f} % | {after:.1f} % |", "",
        ]
    )  # fmt: skip
    given.out.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
