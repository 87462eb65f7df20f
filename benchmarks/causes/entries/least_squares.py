"""Plain least squares: the model as stated. It names nothing, and says whether its residuals are white noise."""

from __future__ import annotations

import sys

from benchmarks.causes.answers import Answer

from .base import fit
from .records import load


def main(folder: str) -> int:
    """Print the answer."""
    done = fit(load(folder))
    verdict = "nothing missing" if done.noise_only else "unexplained"
    held_out = (done.held_out, done.held_out) if done.held_out else None
    print(Answer(verdict, k=done.k, c=done.c, held_out=held_out).text())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
