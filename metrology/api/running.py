"""From a campaign, in a file or in a dictionary, to its results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.api.results import Results
from metrology.errors import Fault, MetrologyError

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign


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

    try:
        path = Path(path)
    except TypeError:
        raise MetrologyError(Fault("load", f"{path!r:.60}", "the path of a campaign file, or of its folder")) from None
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
        As `load` returned it, a file, or the content of a campaign file as a dictionary, in which a table of arrays
        may stand for a file of readings: a DataFrame, a Dataset of xarray, or columns of shape (n,) by heading,
        ``{"time / s": t, "displacement / mm": x}``.
    folder : Path or str
        Where the files of readings of a campaign lie that is a dictionary.
    allow_code : bool
        Run the Python files that the campaign names under ``diagnosis``.
    coverage : bool
        Repeat the tests by simulation, to see how often the intervals hold what they should.
    progress : callable, optional
        Takes what is being done, in a few words.

    Returns
    -------
    Results
        By full name, such as ``pull.k``.

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
    from metrology.campaign.schema import Campaign

    given: Any = campaign
    if not isinstance(given, Mapping | Path | str | Campaign):
        expected = "a campaign that 'load' returned, the path of a campaign file, or its content as a dictionary"
        raise MetrologyError(Fault("run", f"{given!r:.60}", expected))
    loaded = _of_mapping(campaign, Path(folder), allow_code=allow_code) if isinstance(campaign, Mapping) else campaign
    if isinstance(loaded, Path | str):
        loaded = load(loaded, allow_code=allow_code)
    findings, traces = chain.traced(loaded, progress=progress or (lambda _text: None), coverage=coverage)
    return Results(loaded, findings, traces)


def _of_mapping(stated: Mapping[str, Any], folder: Path, *, allow_code: bool) -> Campaign:
    """Write a dictionary as a campaign file, and read it as strictly as any other."""
    import yaml

    from metrology.api.arrays import of_arrays, taken_out
    from metrology.campaign.load import of_document
    from metrology.declaration.document import parse

    plain, handed = taken_out(stated)

    class Dumper(yaml.SafeDumper):
        def ignore_aliases(self, _data: Any) -> bool:
            return True

    try:
        text = yaml.dump(plain, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=1000)
    except yaml.YAMLError as error:
        got = f"a value that no campaign file can hold ({' '.join(str(error).split())[:80]})"
        raise MetrologyError(Fault("campaign", got, "texts, numbers, dates, lists and dictionaries")) from None
    try:
        document = parse(folder / "campaign.yaml", text.encode())
        document.attached = handed.contents
        return of_document(document, allow_code=allow_code)
    except MetrologyError as error:
        raise of_arrays(error, handed) from None
