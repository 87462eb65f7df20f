"""One result as Python sees it, its budget, and both as a notebook shows them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

from metrology.errors import without

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

    from metrology.api.plot import Plot
    from metrology.diagnosis import Cause, Diagnosis
    from metrology.findings import Result
    from metrology.gum.evaluation import BudgetRow


def pandas() -> Any:
    """The package pandas.

    Raises
    ------
    MetrologyError
        Where it is not installed.
    """
    try:
        return import_module("pandas")
    except ImportError:
        raise without("pandas", "export", "to_pandas") from None


@dataclass(frozen=True)
class Budget:
    """The uncertainty budget of one quantity: a sequence of rows, which a notebook shows as a table.

    Parameters
    ----------
    name : str
        Full name of the quantity.
    rows : tuple of BudgetRow
        Each with ``input``, ``component``, ``value``, ``u``, ``unit``, ``distribution``, ``dof``, ``sensitivity``,
        ``contribution`` and ``share`` of u².
    """

    name: str
    rows: tuple[BudgetRow, ...]

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[BudgetRow]:
        return iter(self.rows)

    def to_pandas(self) -> pd.DataFrame:
        """Return the rows as a table of pandas, which the extra ``export`` brings.

        Returns
        -------
        DataFrame
            A row a component, in the order of the report; values, u and contributions in SI.

        Raises
        ------
        MetrologyError
            Where pandas is not installed.
        """
        return pandas().DataFrame([vars(row) for row in self.rows])

    def _repr_html_(self) -> str:
        rows = [
            (row.input, row.component, f"{row.value:.6g}", f"{row.u:.3g}", row.unit, f"{100 * row.share:.1f} %")
            for row in sorted(self.rows, key=lambda row: -abs(row.share))
        ]
        return table(f"Uncertainty budget of {self.name}", ("input", "component", "value", "u", "unit", "share"), rows)


@dataclass(frozen=True)
class Quantity:
    """One result: a number with its standard uncertainty, interval, budget and distribution.

    Parameters
    ----------
    result : Result
        The entry of ``results.json``.
    _draws, _reconstructed
        Set by `Results`.
    """

    result: Result
    _draws: Callable[[str], Any]
    _reconstructed: str

    @property
    def name(self) -> str:
        """Full name, such as ``al-1100-elongation.k``."""
        return self.result.name

    @property
    def value(self) -> float:
        """Value, in SI."""
        return self.result.value

    @property
    def u(self) -> float:
        """Standard uncertainty, in SI."""
        return self.result.u

    @property
    def unit(self) -> str:
        """SI unit written out, such as ``N/m``."""
        return self.result.unit

    @property
    def dof(self) -> float | None:
        """Effective degrees of freedom; None where infinite or undefined."""
        return self.result.dof

    @property
    def interval(self) -> tuple[float | None, float | None]:
        """Coverage interval that the report states."""
        return self.result.interval

    @property
    def draws(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Monte Carlo draws of the quantity, shape (trials,), in SI; those of all results belong together by trial."""
        found: np.ndarray[tuple[int], np.dtype[np.float64]] = self._draws(self.name)
        return found

    def budget(self) -> Budget:
        """Return the uncertainty budget.

        Returns
        -------
        Budget
            By the GUM uncertainty framework (JCGM 100:2008, 5.1): the contributions add up to its u, in squares.
        """
        return Budget(self.name, self.result.budget)

    def plot(self) -> Plot:
        """Draw what Monte Carlo found: density, and the interval by the GUM uncertainty framework and the shortest one.

        Returns
        -------
        Plot
            In the unit that the report prints.

        Raises
        ------
        LookupError
            Where there were no trials that could be counted.
        """
        from metrology.api.plot import finished
        from metrology.report.figures import density, label

        if not self.result.monte_carlo.density:
            raise LookupError(f"{self.name} has no distribution")
        return finished(f"density/{self.name}", density.draw(self.result, label=label(self._reconstructed)))

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        value, u, unit = shown(self.result)
        return f"{value} ± {u} {unit}".strip()

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        return f"<span title='{escape(self.name)}'>{escape(str(self))}</span>"


def shown(result: Result) -> tuple[str, str, str]:
    """Value and u to two digits of u, in the unit that the report prints."""
    from metrology.gum.rounding import significant
    from metrology.units import convert, factor

    unit = result.display_unit
    value, u = significant(convert(result.value, unit), result.u / factor(unit))
    return value, u, "" if unit == "1" else unit


def ends(result: Result) -> str:
    """The coverage interval in the unit that the report prints."""
    from metrology.gum.rounding import significant
    from metrology.units import convert, factor

    size = result.u / factor(result.display_unit)
    found = [significant(convert(end, result.display_unit), size)[0] for end in result.interval if end is not None]
    return f"{found[0]} … {found[1]}" if len(found) == 2 else "–"


def causes(diagnosis: Diagnosis) -> list[tuple[str, str, str, str, str]]:
    """Test, cause, verdict, probability and size of everything that is given as a cause or one of a group."""
    from metrology.language.display import chance

    found = [one for one in diagnosis.causes if one.effect in diagnosis.possible]
    return [(diagnosis.test, one.title, one.verdict, chance(one.probability), _sizes(one)) for one in found]


def _sizes(cause: Cause) -> str:
    from metrology.gum.rounding import significant

    pairs = [significant(one.value, one.u) if one.u > 0 else (f"{one.value:g}",) for one in cause.parameters]
    return ", ".join(
        f"{one.name} = {' ± '.join(pair)} {one.unit}" for one, pair in zip(cause.parameters, pairs, strict=True)
    )


def table(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of HTML, in which text is text."""
    head = "".join(f"<th>{escape(text)}</th>" for text in headings)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><caption>{escape(title)}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
