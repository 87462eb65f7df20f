"""The record of a method: everything in which one method of the laboratory differs from the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from metrology.declaration.conduct import Test

if TYPE_CHECKING:
    import numpy as np

    from metrology.declaration.columns import Column, Table
    from metrology.declaration.document import Place
    from metrology.declaration.entry import Entry, Refusal
    from metrology.declaration.readings import Readings
    from metrology.diagnosis import Diagnosis, Discrepancy
    from metrology.diagnostics.discrepancy_setting import Setting
    from metrology.errors import Fault, Notice
    from metrology.gum.evaluation import Contribution, Measurand
    from metrology.method.declared import Declared
    from metrology.method.model import Identity, Model

T = TypeVar("T", bound=Test)
R = TypeVar("R")
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Output:
    """A result of a method: SI unit of its dimension, unit in which the report prints it, and what it is called."""

    unit: str
    shown: str
    word: str


@dataclass(frozen=True)
class Files:
    """Readings files of a test that are read alike and judged together.

    Parameters
    ----------
    files : sequence of (Place, Readings)
        Place in the campaign file of each, and how it is read; a text is the path of a file.
    columns : sequence of Column
        What they hold.
    check : callable
        What is wrong with the tables, or to be noted, once all of them could be read.
    ranges : mapping of str to str
        Column → instrument that reads it: readings beyond the range that this declares are refused.
    stretch : str
        Column that reads how much longer the sample is, where one does.
    """

    files: Sequence[tuple[Place, Readings | str]]
    columns: Sequence[Column]
    check: Callable[[Sequence[Table]], Iterator[Refusal | Fault | Notice]]
    ranges: Mapping[str, str] = field(default_factory=dict)
    stretch: str = ""


@dataclass(frozen=True)
class Task(Generic[T]):
    """One test on its way into the measurement model of its campaign."""

    model: Model
    campaign: Declared
    name: str
    test: T
    method: Method[T, Any]
    progress: Progress

    def add(self, measurand: Measurand, *, headline: bool = True) -> None:
        """Add a result of the test, ``<test>.<result>``; `headline` results stand on page 1."""
        self.model.add_measurand(measurand, self.identity(measurand, headline=headline))

    def identity(self, measurand: Measurand, *, headline: bool) -> Identity:
        """What a result of the test belongs to, and how it is shown."""
        from metrology.method.model import Identity

        quantity = measurand.name.removeprefix(f"{self.name}.")
        output = self.method.outputs.get(quantity)
        shown = output.shown if output is not None and output.unit == measurand.unit else measurand.unit
        called = self.test.kind or self.test.method
        return Identity(quantity, called, self.test.sample, self.name, shown, headline=headline)


@dataclass(frozen=True)
class Relaxing:
    """A relaxation that a test finds of its sample: relaxation time / s, and the part of the stiffness that it takes.

    The part is of what faster relaxations leave: k₁/(k + k₁) of a Zener element. Each u is half of the expanded one.
    """

    name: str
    time: float
    time_u: float
    part: float
    part_u: float


@dataclass(frozen=True)
class Loading:
    """How a test loads its sample, by which its results are set against those of other tests of the sample.

    Parameters
    ----------
    seconds : float, optional
        Time in which the sample answers; None where it is not known.
    setup : bool
        Whether what bears the sample gives way in its results: k/(1 + C·k) is what it reads.
    whole : bool
        Whether its k is that of the whole sample, of the length that the campaign states of it.
    relaxing : tuple of Relaxing
        Relaxations that its record resolves.
    resolved : (float, float), optional
        Shortest and longest relaxation time / s that its record resolves; None where it is no record of one.
    """

    seconds: float | None = None
    setup: bool = True
    whole: bool = True
    relaxing: tuple[Relaxing, ...] = ()
    resolved: tuple[float, float] | None = None


class Finding(Protocol):
    """What the report shows of a test: a frozen dataclass of values that JSON can hold, each field with its `Doc`."""

    @property
    def equations(self) -> tuple[str, ...]:
        """Equations of the method, as text."""


@dataclass(frozen=True)
class Analysed(Generic[R]):
    """What a test showed, what its diagnosis begins at, and what it put into the model that a diagnosis may correct."""

    finding: Finding
    ready: R
    stated: Contribution | None = None


@dataclass(frozen=True, kw_only=True)
class Method(Generic[T, R]):
    """A method of the laboratory; ``METHOD`` of its module ``metrology/methods/<name>.py`` (``docs/extend.md``).

    The name of the module is the word for it in campaign files, and names what stands outside: how its plots are drawn,
    ``metrology/report/figures/<name>.py``; its part of the report, ``templates/<name>.html``; and its description,
    ``docs/methods/<name>.md``. Every field is required.
    """

    title: str = field(metadata={"doc": "What it is called in the report."})
    standard: str = field(metadata={"doc": "What it follows, with edition."})
    shown: str = field(metadata={"doc": "One sentence on its entry in `results.json`."})
    columns: str = field(
        metadata={"doc": "Columns of its readings in words, for the documentation of the campaign file."}
    )
    remark: str = field(metadata={"doc": "What else its users must know of its keys; empty where nothing."})
    references: tuple[str, ...] = field(metadata={"doc": "Keys of `metrology.references` that its reports cite."})
    test: type[T] = field(metadata={"doc": "Class of its tests in the campaign file."})
    entries: tuple[type[Entry], ...] = field(metadata={"doc": "Classes of the entries below the keys of `test`."})
    outputs: Mapping[str, Output] = field(metadata={"doc": "Every result that it can give, by its symbol."})
    yields: Callable[[Declared, T], Mapping[str, str]] = field(
        metadata={"doc": "The results that a test gives, each with its unit, by what the campaign declares."}
    )
    takes: tuple[str, ...] = field(
        metadata={"doc": "Methods whose results its tests may take: they are evaluated before."}
    )
    whole: str = field(
        metadata={"doc": "What one of its files is called, where only whole files are excluded; empty where lines are."}
    )
    readings: Callable[[str, T], Iterator[Files]] = field(metadata={"doc": "The files of a test, by its name."})
    check: Callable[[Declared, str, T], Iterator[Refusal]] = field(
        metadata={"doc": "What is wrong with a test between the entries of the file."}
    )
    analyse: Callable[[Task[T]], Analysed[R]] = field(
        metadata={"doc": "Puts inputs and results of a test into the model; what the test showed."}
    )
    finding: type[Finding] = field(metadata={"doc": "Class of what a test showed."})
    diagnose: Callable[[Task[T], R, np.random.Generator], Diagnosis] | None = field(
        metadata={"doc": "What the model of a test lacks; None where the method has no diagnosis."}
    )
    corrected: Callable[[Task[T], R, Contribution, Diagnosis], Contribution] | None = field(
        metadata={
            "doc": "The contribution of a test by the model that the data support, in place of that by the stated one; "
            "None where the method has no diagnosis."
        }
    )
    explain: Callable[[R, Setting], Discrepancy] | None = field(
        metadata={"doc": "What could part a result from its reference; None where the method has no table of causes."}
    )
    loading: Callable[[Declared, str, T, Any], Loading] | None = field(
        metadata={"doc": "How a test, by its finding, loads its sample; None: as a whole, through a set-up, in 1/ω_n."}
    )
    carried: Callable[[Declared, T, str], str] | None = field(
        metadata={"doc": "Unit of a parameter that `model` of its tests carries; None where they have no such key."}
    )
