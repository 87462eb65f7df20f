"""The equation of motion and its integration between located events.

Plain Python throughout: `engines` runs it as it is, with vectorised segments, or compiled, all modules in one. The
physics stands in `equation`; `regimes` says where one regime ends and which one follows; the rest solves it: exactly,
by matrix exponentials, where a regime is linear (the matrices are read off the equation itself, so that it stands
nowhere else), by Dormand and Prince's 8(5,3) pairs where it is not.
"""

from metrology.rig.kernel import equation, exponential, layout, march, regimes, samples, steps, zeros

MODULES = (layout, equation, regimes, exponential, zeros, samples, steps, march)
"""Of these the later ones use the earlier ones'."""
