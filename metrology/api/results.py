"""What came out of a campaign: results by name, verdicts, diagnosis, plots, report, exports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, partial
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from metrology.api.notebook import html
from metrology.api.quantity import Budget, Quantity, pandas

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from uncertainties import UFloat

    from metrology.api.plot import Plots
    from metrology.campaign.schema import Campaign
    from metrology.diagnosis import Diagnosis
    from metrology.findings import Conformity, Findings
    from metrology.gum.monte_carlo import Trials
    from metrology.timeseries import Trace


@dataclass(frozen=True, eq=False)
class Results(Mapping[str, Quantity]):
    """What the readings of a campaign say: results by their full names, verdicts, diagnosis, report.

    A quantity that only one test gives is an attribute too: ``results.k``, ``results.zeta``. Results can be pickled and
    copied; they are equal to themselves alone.

    Parameters
    ----------
    campaign : Campaign
        What was evaluated.
    findings : Findings
        Everything, as ``results.json`` has it.
    _traces
        Set by `run`.
    """

    campaign: Campaign
    findings: Findings
    _traces: Mapping[str, Trace]
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __getstate__(self) -> dict[str, Any]:
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def __getitem__(self, name: str) -> Quantity:
        if name not in self._quantities:
            raise KeyError(f"no result {name!r}; there are {', '.join(self)}")
        return self._quantities[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._quantities)

    def __len__(self) -> int:
        return len(self._quantities)

    def __getattr__(self, name: str) -> Quantity:
        if name.startswith("_"):
            raise AttributeError(name)
        found = self._of(name)
        if len(found) == 1:
            return found[0]
        names = ", ".join(f"results[{one.name!r}]" for one in found)
        raise AttributeError(
            f"{name!r} is ambiguous: {names}" if found else f"no result {name!r}; there are {', '.join(self)}"
        )

    def _of(self, quantity: str | None) -> list[Quantity]:
        """Results of all tests that give a quantity."""
        return [one for one in self._quantities.values() if one.result.quantity == quantity]

    @cached_property
    def _quantities(self) -> Mapping[str, Quantity]:
        reconstructed = self.findings.campaign.reconstructed
        return MappingProxyType({one.name: Quantity(one, self._drawn, reconstructed) for one in self.findings.results})

    def _drawn(self, name: str) -> Any:
        return self.draws[name]

    @cached_property
    def draws(self) -> Mapping[str, np.ndarray[tuple[int], np.dtype[np.float64]]]:
        """Joint Monte Carlo draws of all results by name, each of shape (trials,), in SI.

        They are those that the report rests on; since it keeps none, the model is built anew on first use.
        """
        from metrology import chain
        from metrology.gum.law import propagate
        from metrology.gum.monte_carlo import Plan
        from metrology.gum.monte_carlo import run as trials
        from metrology.gum.sampling import sampler

        model = chain.build(self.campaign)
        number = max((one.monte_carlo.trials for one in self.findings.results), default=0)
        if not number:
            return MappingProxyType({})
        law = propagate(model.measurands, model.knowledge)
        settings = self.campaign.monte_carlo
        plan = Plan(self.campaign.coverage_probability, self.campaign.seed, settings.digits, settings.max_trials)
        measurands = [line.measurand for line in law.linear]
        still = partial(_still, number / plan.block)
        drawn = trials(measurands, sampler(model.knowledge, law.joint), plan, still).outputs
        return MappingProxyType({one.name: row for one, row in zip(measurands, drawn, strict=True)})

    @property
    def curves(self) -> Mapping[str, Trace]:
        """Every sample behind the plots over time, as arrays by column: ``results.curves["decay/swing/swing.csv"]``.

        Keys are the name of the plot, then the release, or the run and the channel. ``time`` / s of shape (n,), and
        the others of its shape in the SI unit of the channel, a gap NaN: ``pandas.DataFrame(results.curves[key])``.
        """
        return MappingProxyType(dict(self._traces))

    def budget(self, name: str | None = None) -> Budget:
        """Return the uncertainty budget of a result.

        Parameters
        ----------
        name : str, optional
            Its full name, or its short one where only one test gives that quantity; the only one where nothing is said.

        Returns
        -------
        Budget
            Rows of contributions, in SI.

        Raises
        ------
        KeyError
            Where there is no such result, or several and none is named.
        """
        if name is None and len(self) != 1:
            raise KeyError(f"which of {', '.join(self)}")
        short = self._of(name)
        return (short[0] if len(short) == 1 else self[name or next(iter(self))]).budget()

    @property
    def verdicts(self) -> tuple[Conformity, ...]:
        """Verdict on every requirement: ``requirement``, ``verdict``, ``probability``, ``sentence`` and more."""
        return self.findings.conformity

    @property
    def diagnosis(self) -> tuple[Diagnosis, ...]:
        """Where a model is wrong and why: ``test``, ``verdict``, ``sentence``, ``causes`` and more."""
        return self.findings.diagnosis

    @property
    def notices(self) -> tuple[str, ...]:
        """What must be known before a number is used, as page 1 of the report says it in full, the gravest first."""
        from metrology.language.attention import attention

        return tuple(f"{kind}: {sentence}" for kind, sentence in attention(self.findings))

    def plot(self, test: str | None = None) -> Plots:
        """Draw the plots of the report, which a notebook shows with their captions.

        Parameters
        ----------
        test : str, optional
            Those of one test, by its name in the campaign; all of them where nothing is said.

        Returns
        -------
        Plots
            In the order of the report.

        Raises
        ------
        KeyError
            Where there is no such test.
        """
        from metrology.api.plot import of_test
        from metrology.report import figures

        tests = [one.id for one in self.findings.tests]
        if test is not None and test not in tests:
            raise KeyError(f"no test {test!r}; there are {', '.join(tests)}")
        return of_test(figures.jobs(self.findings, self._traces, every=True), test)

    def report(self, folder: Path | str, *, templates: Path | None = None) -> Path:
        """Write ``report.pdf``, ``report.html``, ``results.json`` and ``results.csv``, all or none of them.

        Parameters
        ----------
        folder : Path or str
            Made where it is missing.
        templates : Path, optional
            Folder with templates of the laboratory's own.

        Returns
        -------
        Path
            The PDF.

        Raises
        ------
        MetrologyError
            Where the folder cannot be written, or readings changed since they were evaluated.
        """
        from metrology.campaign.sources import read_sources
        from metrology.report import write

        sources = read_sources(self.campaign)
        write(self.findings, Path(folder), sources=sources, templates=templates, traces=self._traces)
        return Path(folder) / "report.pdf"

    def export(self, form: str, path: Path | str, *, use: Sequence[str] = ()) -> None:
        """Write the results for a simulation or another estimator (``docs/exports.md``).

        Parameters
        ----------
        form : str
            ``moordyn`` or ``mujoco``, a file; ``table`` or ``petab``, a folder of files.
        path : Path or str
            The file or the folder.
        use : sequence of str
            Full names of results, where several give one quantity of a sample.

        Raises
        ------
        MetrologyError
            For everything that the form needs and the results do not have.
        """
        from metrology.export.forms import write

        write(form, self.findings, Path(path), use=use)

    def to_json(self) -> bytes:
        """Return ``results.json``.

        Returns
        -------
        bytes
            JSON in UTF-8, by the schema that ``metrology schema results`` prints.
        """
        from metrology.findings import to_json

        return to_json(self.findings)

    def to_pandas(self) -> pd.DataFrame:
        """Return value, u, unit and interval of every result as a table of pandas, which the extra ``export`` brings.

        Returns
        -------
        DataFrame
            A row a result, by its full name; values in SI.

        Raises
        ------
        MetrologyError
            Where pandas is not installed.
        """
        pd = pandas()
        rows = [
            {"name": one.name, "quantity": one.result.quantity, "value": one.value, "u": one.u, "unit": one.unit,
             "low": one.interval[0], "high": one.interval[1]}
            for one in self.values()
        ]  # fmt: skip
        return pd.DataFrame(rows).set_index("name") if rows else pd.DataFrame()

    def ufloats(self) -> dict[str, UFloat]:
        """Return the results as variables of `uncertainties`, with their correlations.

        Returns
        -------
        dict
            A variable for each result that has a value and a finite u, by full name, in SI. Products, quotients and
            whatever else is made of them have the u of the law of propagation (JCGM 100:2008, 5.2.2).
        """
        import numpy as np
        from uncertainties import correlated_values_norm

        usable = [one for one in self.values() if isfinite(one.value) and isfinite(one.u)]
        places = {one.name: index for index, one in enumerate(usable)}
        matrix = np.eye(len(usable))
        for pair in self.findings.correlations:
            if pair.a in places and pair.b in places:
                a, b = places[pair.a], places[pair.b]
                matrix[a, b] = matrix[b, a] = pair.coefficient
        made = correlated_values_norm([(one.value, one.u) for one in usable], matrix) if usable else ()
        return dict(zip(places, made, strict=True))

    def __repr__(self) -> str:
        return "\n".join(f"{one.name} = {one}" for one in self.values()) or "no results"

    def _repr_html_(self) -> str:
        return html(self)


def _still(blocks: float, made: Trials) -> float:
    """How many times as many blocks of trials are wanted as were made."""
    return blocks / len(made.batches)
