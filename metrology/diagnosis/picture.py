"""What makes a cause visible: curves over one quantity, as values that JSON can hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from metrology.doc import Doc

Floats = tuple[float, ...]
Role = Literal["measured", "before", "after", "limit"]


@dataclass(frozen=True)
class Curve:
    """Points of a picture, with the standard uncertainty of each where they are means.

    `role`: whether it shows what was measured, residuals of the model before or after the extension, or a limit.
    """

    name: Annotated[str, Doc("Name.")]
    role: Role
    x: Annotated[Floats, Doc("Values along the abscissa.")]
    y: Annotated[Floats, Doc("Values along the ordinate.")]
    u: Annotated[Floats, Doc("Standard uncertainty, in SI.")] = ()


@dataclass(frozen=True)
class Picture:
    """What makes a cause visible: a few curves over one quantity.

    `key`: what is drawn, one word to a kind of picture; `joined`: lines rather than points; `logarithmic`: which
    axes; `sentence`: how to read it.
    """

    key: str
    title: Annotated[str, Doc("Title as the report prints it.")]
    x: Annotated[str, Doc("Values along the abscissa.")]
    x_unit: Annotated[str, Doc("Unit of x.")]
    y: Annotated[str, Doc("Values along the ordinate.")]
    y_unit: Annotated[str, Doc("Unit of y.")]
    curves: Annotated[tuple[Curve, ...], Doc("The curves of the picture.")]
    sentence: str
    joined: bool = False
    logarithmic: Literal["no", "x", "both"] = "no"
