"""A campaign that extends another: the same readings, with a model that carries more."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.declaration.document import read
from metrology.declaration.entry import Refusal
from metrology.declaration.scalars import MAX_NAME
from metrology.errors import MetrologyError
from metrology.methods import METHODS
from metrology.units.dimensions import quoted

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign

Size = tuple[float, float | None]
EXTENDED = "-extended"
NOTE = """\
# The campaign {name} with the model that its diagnosis found, under `model:`.
# Written by metrology; the next run of the campaign writes it anew or takes it away.
# The sizes were found in the very runs to which k and c are fitted again here: together with these they count twice, so
# that uncertainties come out a little too small. Measure them by themselves, and put in their place what you find.
"""


def check_extends(campaign: Campaign) -> Iterator[Refusal]:
    """What is wrong with the campaign that this one extends.

    A campaign reads no file outside its folder, so that one from a stranger can be run without a look at all its
    paths. One that extends another reads in that one's folder instead: one place, in one line of the file, where a
    campaign file must lie already. Copies of the readings would do as well, but then two sets of them would have to
    be kept alike.
    """
    if campaign.extends is None:
        return
    place, expected = ("extends",), "the campaign file that this one extends"
    path = Path(campaign.extends)
    if path.is_absolute() or any(letter in campaign.extends for letter in "\\:\0"):
        yield Refusal(
            place, quoted(campaign.extends), expected, "write the path from the folder of this file, with '/'"
        )
        return
    try:
        other = read(campaign.path.parent / path).data
    except MetrologyError:
        other = None
    if not isinstance(other, dict) or other.get("format") != campaign.format:
        got = f"{quoted(campaign.extends)}, which is no campaign file that can be read"
        yield Refusal(place, got, expected, "give the path from the folder of this file")
    elif "extends" in other:
        got = f"{quoted(campaign.extends)}, which extends another one itself"
        yield Refusal(place, got, expected, f"extend {quoted(str(other['extends']))}")


def extended(campaign: Campaign, models: Mapping[str, Mapping[str, Size]], folder: Path) -> bytes:
    """Return the campaign with effects added to the models of its tests, as a file in `folder`.

    Parameters
    ----------
    campaign : Campaign
        As it was loaded.
    models : mapping
        Values and standard uncertainties in SI, by test and parameter of `docs/model.md`.
    folder : Path
        Where the file is to lie; readings stay where they are.
    """
    import yaml

    assert campaign._document is not None
    origin = campaign.path.parent / campaign.extends if campaign.extends else campaign.path
    data: dict[str, Any] = dict(campaign._document.data)
    data["id"] = campaign.id[: MAX_NAME - len(EXTENDED)] + EXTENDED
    data["title"] = f"{campaign.title} (extended model)"
    data["extends"] = Path(os.path.relpath(origin.resolve(), folder.resolve())).as_posix()
    if campaign.report.number:
        data["report"] = data["report"] | {"number": campaign.report.number + EXTENDED}
    tests = dict(data["tests"])
    for name, model in models.items():
        tests[name] = tests[name] | {"model": tests[name].get("model", {}) | _written(campaign, name, model)}
    data["tests"] = tests
    text = yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=120)
    return (NOTE.format(name=campaign.id) + text).encode()


def _written(campaign: Campaign, test: str, model: Mapping[str, Size]) -> dict[str, str]:
    """Parameters as a campaign file states them."""
    stated, found = campaign.tests[test], {}
    carried = METHODS[stated.method].carried
    assert carried is not None
    for name, (value, u) in model.items():
        si = carried(campaign, stated, name)
        unit = "" if si == "1" else f" {si}"
        found[name] = f"{value:.8g} ± {u:.3g}{unit}" if u else f"{value:.8g}{unit}"
    return found
