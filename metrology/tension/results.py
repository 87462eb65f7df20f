"""Every result of a tension test: unit, equation, and what a test has to declare for it."""

from __future__ import annotations

from dataclasses import dataclass

UNITS = {
    "EA": "N", "k": "N/m", "E": "Pa", "EA_sec": "N", "k_sec": "N/m", "E_sec": "Pa",
    "EA_tan": "N", "k_tan": "N/m", "E_tan": "Pa",
    "C": "m/N", "F_max": "N", "R_m": "Pa", "eps_b": "1", "tenacity": "N·m/kg",
}  # fmt: skip
"""Every result with its SI unit, each after those from which it follows."""
EQUATIONS = {
    "EA": "EA = (dF/dε)·(1 + δ_F)/(1 + δ_ε)", "k": "k = EA/L", "E": "E = EA/A",
    "EA_sec": "EA_sec = (F₂ − F₁)/(ε₂ − ε₁)·(1 + δ_F)/(1 + δ_ε)",
    "k_sec": "k_sec = EA_sec/L", "E_sec": "E_sec = EA_sec/A",
    "EA_tan": "EA_tan = (dF/dε at the point)·(1 + δ_F)/(1 + δ_ε)",
    "k_tan": "k_tan = EA_tan/L", "E_tan": "E_tan = EA_tan/A",
    "C": "C = dx/dF − L/EA",
    "F_max": "F_max = largest force", "R_m": "R_m = F_max/A", "eps_b": "ε_b = ε(F_b)·(1 + δ_ε)·L_g0/L_g",
    "tenacity": "f = F_max/λ",
}  # fmt: skip
BY_CROSSHEAD = "EA = L/(dx/dF − C)"
BROKEN_BY_CROSSHEAD = "ε_b = (x_b·(1 + δ_x) − C·F_b·(1 + δ_F))/L"
BY_LENGTHS = "dx/dF = C + L/EA, over specimens of several lengths"
LENGTHS = 3
"""Different lengths from which on the set-up's compliance follows from them: two would leave no scatter."""


@dataclass(frozen=True)
class Facts:
    """What a test declares, by which it is known beforehand which results it gives."""

    strain: bool
    crosshead: bool
    lengths: int
    sample_length: bool
    area: bool
    linear_density: bool
    setup: bool
    to_break: bool
    secant: bool = False
    tangent: bool = False

    @property
    def by_lengths(self) -> bool:
        """Whether specimens of several lengths tell the set-up's compliance."""
        return not self.strain and not self.setup and self.lengths >= LENGTHS

    @property
    def results(self) -> dict[str, str]:
        """Every result with its unit."""
        alone = (self.strain or bool(self.lengths)) and not self.by_lengths
        known = {
            **self._local("sec", declared=self.secant and alone),
            **self._local("tan", declared=self.tangent and alone),
            "EA": self.strain or bool(self.lengths),
            "k": self.sample_length if self.by_lengths else bool(self.lengths),
            "E": self.area and (self.strain or bool(self.lengths)),
            "C": (self.strain and self.crosshead and bool(self.lengths)) or self.by_lengths,
            "F_max": self.to_break,
            "R_m": self.to_break and self.area,
            "eps_b": self.to_break and (self.strain or bool(self.lengths)),
            "tenacity": self.to_break and self.linear_density,
        }
        return {name: unit for name, unit in UNITS.items() if known[name]}

    def _local(self, of: str, *, declared: bool) -> dict[str, bool]:
        """Which results of a secant or a tangent there are."""
        return {f"EA_{of}": declared, f"k_{of}": declared and bool(self.lengths), f"E_{of}": declared and self.area}
