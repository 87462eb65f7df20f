"""What runs on the rig lack that a candidate needs: a channel, a thrust, a line of another kind."""

from __future__ import annotations

from collections.abc import Sequence

from metrology.estimation import MeasuredRun
from metrology.message import said
from metrology.rig import Rig


def lacking_in(rig: Rig, runs: Sequence[MeasuredRun]) -> dict[str, str]:
    """Needs of candidates that these runs do not meet, each with the reason."""
    channels = {name for run in runs for name in run.channels}
    measured = (
        ("x", said("no position was measured")), ("v", said("no velocity was measured")),
        ("T", said("no tension was measured")),
    )  # fmt: skip
    lacking: dict[str, str] = {name: words for name, words in measured if name not in channels}
    if not channels & {"x", "v"}:
        lacking["motion"] = said("no motion was measured")
    if not any(run.run.force is not None for run in runs):
        lacking["thrust"] = said("no thrust acts in these runs")
    if rig.attachment != "tether":
        lacking["tether"] = said("the line pushes as well as it pulls")
    if rig.attachment != "both ways":
        lacking["both ways"] = said("the line does not push: a cubic term acts alike there")
    if not rig.length > 0:
        lacking["length"] = said("the free length of the line is not stated")
    return lacking
