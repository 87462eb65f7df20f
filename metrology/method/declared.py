"""What a method may ask of the campaign that declares its tests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from metrology.declaration.columns import Table
    from metrology.declaration.conduct import Test
    from metrology.declaration.document import Key
    from metrology.declaration.fits import Fit
    from metrology.declaration.identity import Instrument
    from metrology.declaration.samples import Sample
    from metrology.rig.own import OwnEffect


class Diagnosing(Protocol):
    """How the tests are diagnosed: causes that are not tried, and files with effects of the laboratory's own."""

    @property
    def without(self) -> tuple[str, ...]: ...  # noqa: D102 - as the field of the campaign file
    @property
    def effects(self) -> tuple[str, ...]: ...  # noqa: D102


class Declared(Protocol):
    """A campaign as its methods see it: everything by its name in the file, readings by section and name.

    `own` are the effects of the laboratory's own, empty where their code was not run; `at` says where an entry stands.
    """

    @property
    def seed(self) -> int: ...  # noqa: D102 - as the fields of the campaign file
    @property
    def samples(self) -> Mapping[str, Sample]: ...  # noqa: D102
    @property
    def instruments(self) -> Mapping[str, Instrument]: ...  # noqa: D102
    @property
    def fits(self) -> Mapping[str, Fit]: ...  # noqa: D102
    @property
    def tests(self) -> Mapping[str, Test]: ...  # noqa: D102
    @property
    def diagnosis(self) -> Diagnosing: ...  # noqa: D102
    @property
    def tables(self) -> Mapping[tuple[str, str], tuple[Table, ...]]: ...  # noqa: D102
    @property
    def own(self) -> tuple[OwnEffect, ...]: ...  # noqa: D102
    def at(self, *place: Key) -> str: ...  # noqa: D102
