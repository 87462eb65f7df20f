"""The public interface of Python: load a campaign, evaluate it, look at what came out.

Everything here is stable within a version of the package; other modules are not. Numbers are in SI.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from html import escape
from math import isfinite
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from metrology.api.quantity import Budget, Quantity, ends, shown, table
from metrology.errors import Fault, MetrologyError

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from uncertainties import UFloat

    from metrology.campaign.schema import Campaign
    from metrology.diagnosis import Diagnosis
    from metrology.findings import Conformity, Findings
    from metrology.timeseries import Trace

__all__ = ["Budget", "Quantity", "Results", "load", "run"]


def load(path: Path | str, *, allow_code: bool = False) -> Campaign:
    """Read a campaign file and its readings, and check all of it.

    Parameters
    ----------
    path : Path or str
        The campaign file, or the folder that holds ``campaign.yaml``.
    allow_code : bool
        Run the Python files that the campaign names under ``diagnosis``.

    Returns
    -------
    Campaign
        Frozen; its attributes are the keys of the file (``docs/campaign.md``).

    Raises
    ------
    MetrologyError
        With every fault, its file and line.
    """
    from metrology.campaign.load import load as load_file

    path = Path(path)
    return load_file(path / "campaign.yaml" if path.is_dir() else path, allow_code=allow_code)


def run(
    campaign: Campaign | Mapping[str, Any] | Path | str,
    *,
    folder: Path | str = ".",
    allow_code: bool = False,
    coverage: bool = True,
    progress: Callable[[str], None] | None = None,
) -> Results:
    """Evaluate a campaign.

    Parameters
    ----------
    campaign : Campaign, mapping, Path or str
        As `load` returned it, a file, or the content of a campaign file as a dictionary.
    folder : Path or str
        Where the readings of a campaign lie that is a dictionary.
    allow_code : bool
        Run the Python files that the campaign names under ``diagnosis``.
    coverage : bool
        Repeat the tests by simulation, to see how often the intervals hold what they should.
    progress : callable, optional
        Takes what is being done, in a few words.

    Returns
    -------
    Results
        By their full names, in SI.

    Raises
    ------
    MetrologyError
        With every fault of the campaign and its readings.

    Examples
    --------
    >>> stated = {"format": "metrology-campaign/1", "id": "r", "title": "Resistance", "seed": 1}
    >>> stated |= {"quantities": {"V": "4.999(3) V", "I": "19.66(1) mA"}}
    >>> stated |= {"derived": [{"quantity": "R", "expression": "V / I", "unit": "ohm"}]}
    >>> run(stated).R
    254.27 ± 0.20 ohm
    """
    from metrology import chain

    loaded = _of_mapping(campaign, Path(folder), allow_code=allow_code) if isinstance(campaign, Mapping) else campaign
    if isinstance(loaded, Path | str):
        loaded = load(loaded, allow_code=allow_code)
    findings, traces = chain.traced(loaded, progress=progress or (lambda _text: None), coverage=coverage)
    return Results(loaded, findings, traces)


def _of_mapping(stated: Mapping[str, Any], folder: Path, *, allow_code: bool) -> Campaign:
    """Write a dictionary as a campaign file, and read it as strictly as any other."""
    import yaml

    from metrology.campaign.load import of_document
    from metrology.declaration.document import parse

    class Dumper(yaml.SafeDumper):
        def ignore_aliases(self, _data: Any) -> bool:
            return True

    try:
        text = yaml.dump(_plain(stated), Dumper=Dumper, sort_keys=False, allow_unicode=True, width=1000)
    except yaml.YAMLError as error:
        got = f"a value that no campaign file can hold ({' '.join(str(error).split())[:80]})"
        raise MetrologyError(Fault("campaign", got, "texts, numbers, dates, lists and dictionaries")) from None
    return of_document(parse(folder / "campaign.yaml", text.encode()), allow_code=allow_code)


def _plain(value: Any) -> Any:
    """Dictionaries and lists of what YAML can hold; numbers of NumPy as those of Python."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, Path):
        return value.as_posix()
    return value.item() if hasattr(value, "item") and getattr(value, "ndim", 1) == 0 else value


@dataclass(frozen=True)
class Results(Mapping[str, Quantity]):
    """What the readings of a campaign say: results by their full names, verdicts, diagnosis, report.

    A quantity that only one test gives is an attribute too: ``results.k``, ``results.zeta``.

    Parameters
    ----------
    campaign : Campaign
        What was evaluated.
    findings : Findings
        Everything, as ``results.json`` has it.
    """

    campaign: Campaign
    findings: Findings
    _traces: Mapping[str, Trace]

    def __getitem__(self, name: str) -> Quantity:
        return self._quantities[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._quantities)

    def __len__(self) -> int:
        return len(self._quantities)

    def __getattr__(self, name: str) -> Quantity:
        if name.startswith("_"):
            raise AttributeError(name)
        found = [one for one in self._quantities.values() if one.result.quantity == name]
        if len(found) == 1:
            return found[0]
        names = ", ".join(f"results[{one.name!r}]" for one in found)
        raise AttributeError(
            f"{name!r} is ambiguous: {names}" if found else f"no result {name!r}; there are {', '.join(self)}"
        )

    @cached_property
    def _quantities(self) -> Mapping[str, Quantity]:
        return MappingProxyType({one.name: Quantity(one, self._drawn) for one in self.findings.results})

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

        model, number = (
            chain.build(self.campaign),
            max((one.monte_carlo.trials for one in self.findings.results), default=0),
        )
        if not number:
            return MappingProxyType({})
        law = propagate(model.measurands, model.knowledge)
        settings = self.campaign.monte_carlo
        plan = Plan(self.campaign.coverage_probability, self.campaign.seed, settings.digits, settings.max_trials)
        measurands = [line.measurand for line in law.linear]
        still = partial(_still, number / plan.block)
        drawn = trials(measurands, sampler(model.knowledge, law.joint), plan, still).outputs
        return MappingProxyType({one.name: row for one, row in zip(measurands, drawn, strict=True)})

    def budget(self, name: str | None = None) -> Budget:
        """Return the uncertainty budget of a result.

        Parameters
        ----------
        name : str, optional
            Full name of the result; may be left out where there is only one.

        Returns
        -------
        Budget
            Rows of inputs and components, in SI.

        Raises
        ------
        KeyError
            Without a name where there are several results, or for a name that none has.
        """
        if name is None and len(self) != 1:
            raise KeyError(f"which of {', '.join(self)}")
        return self[name or next(iter(self))].budget()

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
        from metrology.language.notices import attention

        return tuple(f"{kind}: {sentence}" for kind, sentence in attention(self.findings))

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

    def to_json(self) -> bytes:
        """Return ``results.json``.

        Returns
        -------
        bytes
            UTF-8; by the schema that ``metrology schema results`` prints.
        """
        from metrology.findings import to_json

        return to_json(self.findings)

    def to_pandas(self) -> pd.DataFrame:
        """Return value, u, unit and interval of every result as a table of pandas, which has to be installed.

        Returns
        -------
        DataFrame
            A row for each result, by its full name; numbers in SI.
        """
        import pandas as pd

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
        dict of str to UFloat
            By full name, in SI; without results that are not finite.
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
        rows = [(one.name, *shown(one.result), ends(one.result)) for one in self.values()]
        campaign = self.findings.campaign
        text = table(campaign.title, ("result", "value", "u", "unit", f"{campaign.probability:.0%} interval"), rows)
        if self.verdicts:
            judged = [(one.requirement, one.verdict, one.sentence) for one in self.verdicts]
            text += table("Verdicts", ("requirement", "verdict", ""), judged)
        if self.diagnosis:
            found = [(one.test, one.verdict, one.sentence) for one in self.diagnosis]
            text += table("Diagnosis", ("test", "verdict", ""), found)
        return text + "".join(f"<p>Note: {escape(sentence)}</p>" for sentence in self.notices)


def _still(blocks: float, batches: Any) -> float:
    """How many times as many blocks of trials are wanted as were made."""
    return blocks / len(batches)
