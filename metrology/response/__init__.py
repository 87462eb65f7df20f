"""Response test: k and c from the motion of a module on the line, and the model judged by runs kept out of the fit.

`finding` holds what the report shows and imports nothing heavy; `analysis` does the work, and needs the rig.
"""

from metrology.response.finding import (
    ChannelFit,
    FittedRun,
    GivenValue,
    InputAfter,
    PaperResult,
    ResponseFinding,
    Sought,
)

__all__ = ["ChannelFit", "FittedRun", "GivenValue", "InputAfter", "PaperResult", "ResponseFinding", "Sought"]
