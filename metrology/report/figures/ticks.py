"""Round numbers to mark along an axis."""

from __future__ import annotations

from math import ceil, floor, log10


def ticks(low: float, high: float, count: int) -> tuple[list[float], int]:
    """Round numbers from `low` to `high`, about `count` and two at least, and the decimals that they need.

    Examples
    --------
    >>> ticks(23710.0, 25890.0, 5)
    ([24000.0, 24500.0, 25000.0, 25500.0], 0)
    """
    raw = (high - low) / count
    power = 10.0 ** floor(log10(raw))
    step = next(round_step * power for round_step in (1, 2, 5, 10) if round_step * power >= raw * 0.999)
    decimals = max(0, -floor(log10(step) + 1e-9))
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return ([i * step for i in range(first, last + 1)], decimals) if last > first else ticks(low, high, count + 1)


def decades(low: float, high: float) -> list[float]:
    """Values to mark between two logarithms to base ten: powers of ten, with their 2 and 5 where these are few.

    Examples
    --------
    >>> decades(-1.2, 0.1), decades(-3.0, 1.0)
    ([0.1, 0.2, 0.5, 1.0], [0.001, 0.01, 0.1, 1.0, 10.0])
    """
    steps = (1, 2, 5) if high - low < 2.2 else (1,)
    every = max(1, ceil((high - low) / 6))
    powers = range(floor(low), floor(high + 1e-9) + 1)
    found = [float(f"{step}e{power}") for power in powers if power % every == 0 for step in steps]
    return [value for value in found if low - 1e-9 <= log10(value) <= high + 1e-9]
