"""The plots of the report as a notebook shows them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, overload

if TYPE_CHECKING:
    from metrology.report.figures.style import Plot as Drawn

_FONT = "'DejaVu Sans', Verdana, sans-serif"


@dataclass(frozen=True)
class Plot:
    """One plot of the report, which a notebook shows as a picture.

    Parameters
    ----------
    name : str
        What the report calls it: subject, then what it is of, such as ``elongation/pull``.
    svg : str
        The picture as a file of its own: ``Path("pull.svg").write_text(plot.svg, encoding="utf-8")``.
    alt, caption : str
        What it shows in words, with its numbers; what stands beneath it in the report.
    """

    name: str
    svg: str
    alt: str
    caption: str

    def __repr__(self) -> str:
        return f"{self.name}: {self.alt}"

    def _repr_svg_(self) -> str:
        return self.svg


class Plots(Sequence[Plot]):
    """Plots in the order of the report; a notebook shows all of them, each with its caption.

    Parameters
    ----------
    plots : sequence of Plot
        In their order.
    """

    def __init__(self, plots: Sequence[Plot]) -> None:
        self._plots = tuple(plots)

    @overload
    def __getitem__(self, index: int) -> Plot: ...
    @overload
    def __getitem__(self, index: slice) -> Plots: ...
    def __getitem__(self, index: int | slice) -> Plot | Plots:
        return Plots(self._plots[index]) if isinstance(index, slice) else self._plots[index]

    def __len__(self) -> int:
        return len(self._plots)

    def __iter__(self) -> Iterator[Plot]:
        return iter(self._plots)

    def __repr__(self) -> str:
        return "\n".join(map(repr, self)) or "no plots"

    def _repr_html_(self) -> str:
        shown = (f"<figure>{one.svg}<figcaption>{escape(one.caption)}</figcaption></figure>" for one in self)
        return "".join(shown) or "<p>no plots</p>"


def of_test(jobs: Mapping[str, Callable[[], Drawn]], test: str | None) -> Plots:
    """Draw the plots of a test, or all of them; the picture of the certificate, which is one of them, is left out."""
    found = (key for key in jobs if key != "story")
    return Plots([finished(key, jobs[key]()) for key in found if test is None or test in key.split("/")[1:]])


def finished(name: str, drawn: Drawn) -> Plot:
    """A plot that stands alone: with its size, its font, and white behind it."""
    look = f'width="{drawn.width:.0f}pt" height="{drawn.height:.0f}pt" style="background:#fff;max-width:100%"'
    head = f'<svg role="img" aria-label="{escape(drawn.alt)}" {look} font-family="{_FONT}" '
    return Plot(name, drawn.svg.replace("<svg ", head, 1), drawn.alt, drawn.caption)
