"""What goes into the evaluation of a free-decay test: records of the releases, mass, and what is known of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from metrology.coordinate import SENSED, Coordinate, Sensed
from metrology.decay.separated import Separated
from metrology.decay.separation import separate
from metrology.decay.shared_modes import with_shared
from metrology.decay.start import Unusable
from metrology.errors import Fault, MetrologyError
from metrology.gum.inputs import Input
from metrology.timeseries import Channel


@dataclass(frozen=True)
class DecayTest:
    """One free-decay test: several releases of one mass on one sample.

    Parameters
    ----------
    name : str
        Unique name of the test; its measurands are `{name}.zeta`, `{name}.omega_n`, `{name}.c` and `{name}.k`.
    records : tuple of Channel
        Displacement (m), velocity (m/s) or acceleration (m/s²) of the plate, or angle of a body (rad) or its
        derivatives, against time in s, one channel a release. Steps need not be even.
    mass : Input
        The mass that oscillates, in kg: plate, released mass and a third of the sample's own. For angles the moment of
        inertia in kg·m²; then k is in N·m/rad and c in N·m·s/rad.
    stiffness : str
        Name, among all inputs and measurands of the campaign, of the static stiffness k that goes into c = 2ζ√(k·m).
        It is looked up there, so that what k and other results share keeps them correlated. `{name}.k` is the
        oscillation's own: c = 2·ζ·m·ω_n then.
    clock : Input, optional
        What a second of the clock lasts beyond a second, relative (a number near zero): ω_n and k_dyn take it, ζ does
        not.
    scale : Input, optional
        Relative correction of displacements (a number near zero). It cancels in every ratio of amplitudes: no result
        takes it, and a note says so.
    mains : float
        Frequency of the mains in Hz.
    expected : float, optional
        About where the longitudinal mode lies, √(k/m) in rad/s; without it, it is the strongest that decays.
    resolution : float
        Smallest difference that the instrument shows, as stated, in the unit of the records; 0 where nothing is.
    """

    name: str
    records: tuple[Channel, ...]
    mass: Input
    stiffness: str
    clock: Input | None = None
    scale: Input | None = None
    mains: float = 50.0
    expected: float | None = None
    resolution: float = 0.0

    def __post_init__(self) -> None:
        units = {record.unit for record in self.records}
        faults = [
            Fault(f"{self.name} {record.name}", f"readings in {record.unit}", f"one of {', '.join(SENSED)}")
            for record in self.records
            if record.unit not in SENSED
        ]
        if len(units) > 1 and not faults:
            faults.append(Fault(f"{self.name}.readings", " and ".join(sorted(units)), "one unit in all records"))
        if not self.records:
            faults.append(Fault(f"{self.name}.readings", "no record", "the record of one release at least"))
        if not self.mass.value > 0:
            faults.append(
                Fault(f"{self.name}.mass", f"{self.mass.value:g} kg", "a mass above zero, such as '1.196(1) kg'")
            )
        if faults:
            raise MetrologyError(*faults)

    @property
    def sensed(self) -> Sensed:
        """What the records are."""
        return SENSED[self.records[0].unit]

    @property
    def coordinate(self) -> Coordinate:
        """Whether a mass moves, or a body turns that has a moment of inertia for mass."""
        return self.sensed.coordinate

    @cached_property
    def separated(self) -> tuple[Separated | Unusable, ...]:
        """Every record taken apart, or why it cannot be."""

        def parted(record: Channel) -> Separated | Unusable:
            try:
                return separate(record, mains=self.mains, expected=self.expected)
            except Unusable as reason:
                return reason

        found = [parted(record) for record in self.records]
        shared = iter(with_shared([one for one in found if not isinstance(one, Unusable)]))
        return tuple(one if isinstance(one, Unusable) else next(shared) for one in found)
