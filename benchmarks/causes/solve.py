"""Integration of an equation of motion with regimes: SciPy's DOP853 between events, each found to rounding."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

Rate = Callable[[float, np.ndarray], Sequence[float]]
Guard = Callable[[float, np.ndarray], float]
RTOL, ATOL = 1e-10, 1e-13
MANY = 20_000


def stretch(
    rate: Rate, span: tuple[float, float], y: np.ndarray, guards: Sequence[Guard], stamps: np.ndarray, max_step: float
) -> tuple[np.ndarray, float, np.ndarray, int | None]:
    """One regime: it holds while all guards are positive.

    Returns the states at those stamps that it reaches, the end and the state there, and which guard ended it.
    """
    solver = DOP853(rate, span[0], y, span[1], max_step=max_step, rtol=RTOL, atol=ATOL)
    rows, at = np.empty((len(y), len(stamps))), int(np.searchsorted(stamps, span[0]))
    first = at
    for _ in range(MANY):
        message = solver.step()
        if solver.status == "failed":
            raise ArithmeticError(message)
        before, now, end, which = solver.t_old, solver.t, solver.t, None
        crossed = [i for i, guard in enumerate(guards) if guard(now, solver.y) < 0]
        last = int(np.searchsorted(stamps, now))
        if crossed or last > at:
            dense = solver.dense_output()
        if crossed:
            end, which = min((_root(guards[i], dense, before, now), i) for i in crossed)
            last = int(np.searchsorted(stamps, end))
        if last > at:
            rows[:, at:last] = dense(stamps[at:last])
            at = last
        if crossed:
            return rows[:, first:at], end, dense(end), which
        if solver.status == "finished":
            return rows[:, first:at], now, solver.y.copy(), None
    raise ArithmeticError("too many steps")


def _root(guard: Guard, dense: Callable[[float], np.ndarray], before: float, now: float) -> float:
    def value(t: float) -> float:
        return guard(t, dense(t))

    begin = before
    if value(begin) <= 0:  # a regime begins where its guard is zero
        begin = before + 1e-6 * (now - before)
        if value(begin) <= 0:
            return before
    return float(brentq(value, begin, now, xtol=1e-14, rtol=1e-14))
