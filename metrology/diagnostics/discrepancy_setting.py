"""What is known around an elongation test whose modulus or stiffness is off its reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Known:
    """A quantity with its standard uncertainty and where it comes from; `u` None: none was stated."""

    value: float
    u: float | None
    source: str = ""

    @property
    def relative(self) -> float:
        """u/|value|, zero where none was stated."""
        return (self.u or 0.0) / abs(self.value)


@dataclass(frozen=True)
class Other:
    """Another sample in the same rig: its stiffness and length, and its modulus and reference."""

    name: str
    stiffness: Known
    modulus: Known
    reference: Known | None = None


@dataclass(frozen=True)
class Setting:
    """What is known around an elongation test.

    Parameters
    ----------
    stiffness, modulus, length, reference : Known
        k / (N/m), E / Pa, L / m of this test, and what was expected of `quantity`.
    section : mapping of str to Known
        Factors of the section that E takes: width, thickness / m; or the area / m².
    dynamic : Known, optional
        k / (N/m) of the same sample in a free decay.
    others : sequence of Other
        Samples in the same rig.
    en : float, optional
        E_n of the comparison with the reference; without it, it is computed with U = 2u.
    quantity : str
        What differs from its reference: E, or k, which takes neither section nor length.
    """

    stiffness: Known
    modulus: Known
    length: Known
    reference: Known
    section: dict[str, Known]
    dynamic: Known | None = None
    others: Sequence[Other] = ()
    en: float | None = None
    quantity: str = "E"

    @property
    def found(self) -> Known:
        """What differs from its reference."""
        return self.modulus if self.quantity == "E" else self.stiffness
