"""Gather the messages of the report, bring every catalogue up to date with them, and say what lacks a translation.

Usage: catalogue.py [--check]
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, get_args, get_type_hints

from babel.messages.catalog import Catalog
from babel.messages.pofile import read_po, write_po
from jinja2.ext import babel_extract

from metrology.language.catalogue import DOMAIN, LOCALE
from metrology.message import JOINTS, Code
from metrology.report.html import SCRIPTS, said_by

if TYPE_CHECKING:
    from metrology.diagnostics.candidate import Candidate

ROOT = Path(__file__).parents[1]
LANGUAGES = tuple(code for code in get_args(Code) if code != "en")
OTHERS = ("batch.html", "overview.html", "watch.html", "watched.html")
"""Templates of pages that stay English."""
TEMPLATES = tuple(sorted({path.name for path in (ROOT / "templates").glob("*.html")} - set(OTHERS)))
SAYS = {"said": 1, "say": 1, "plain": 1, "_content": 1, "counted": 2, "count": 2}
"""Functions that take messages, and how many."""
NAMED = {"Check": 0, "Doubt": 0, "Explanation": 1}
"""Records with a name that a report prints, and which of their arguments it is."""
DAY = datetime(2026, 11, 25, tzinfo=UTC)
"""Of the catalogues, so that writing them again changes nothing else."""
COMMENT = "Report of metrology: certificate and annex. Terms by VIM (JCGM 200) and GUM (JCGM 100)."

EQUATION = re.compile(r"[^\W\d_][^\s{}:]{0,9} = [^{}:\n]*[^{}:.\n]$")
"""A text that is an equation, without places for values."""
PHASES = ("slack", "spike", "rebound", "decay", "steady", "coast", "all")
"""Of a run (`metrology.verify.phases`)."""

INTERNAL = ("fitting the base model", "elastic")
"""Texts for other functions of the same names."""

Message = tuple[str | tuple[str, str], str]
"""Message, or the two of a plural; context."""


def found() -> list[Message]:
    """Every message, each once: of the code, of the templates, and words of the findings that a report says."""
    messages = [*_of_code(), *_of_templates(), *_of_words()]
    plurals = {one[0] for one, _ in messages if isinstance(one, tuple)}
    return [one for one in dict.fromkeys(messages) if one[0] not in plurals and one[0]]


# ---- code -----------------------------------------------------------------------------------------------------------
def _of_code() -> Iterator[Message]:
    for path in sorted((ROOT / "metrology").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if any(f"{name}(" in text for name in SAYS):
            yield from _Calls(ast.parse(text)).messages()


class _Calls:
    """Messages in the calls of one module; a name stands for the texts that it is given."""

    def __init__(self, tree: ast.Module) -> None:
        self.module = tree

    def messages(self) -> Iterator[Message]:
        """Messages in the order of the text."""
        yield from self._within(self.module, [])

    def _within(self, node: ast.AST, scopes: list[ast.AST]) -> Iterator[Message]:
        inner = [*scopes, node] if isinstance(node, ast.FunctionDef | ast.Module | ast.Lambda) else scopes
        if isinstance(node, ast.Call) and (count := SAYS.get(_name(node.func), 0)):
            taken = [one for one in self._taken(node.args, inner) if one not in INTERNAL]
            if count == 1:
                yield from ((one, "") for one in taken)
            else:
                yield from ((pair, "") for pair in zip(taken[::2], taken[1::2], strict=False))
        for child in ast.iter_child_nodes(node):
            yield from self._within(child, inner)

    def _taken(self, arguments: list[ast.expr], scopes: list[ast.AST]) -> list[str]:
        """Texts among the first arguments: constants, and what names and tables hold."""
        first = arguments[:1] if arguments and isinstance(arguments[0], ast.Starred) else arguments[:2]
        return [text for one in first for text in self._texts(one, scopes)]

    def _texts(self, node: ast.expr, scopes: list[ast.AST]) -> list[str]:
        match node:
            case ast.Constant(value=str() as text):
                return [text]
            case ast.IfExp():
                return [*self._texts(node.body, scopes), *self._texts(node.orelse, scopes)]
            case ast.Starred() | ast.Subscript():
                return self._texts(node.value, scopes)
            case ast.Dict():
                return [text for one in node.values for text in self._texts(one, scopes)]
            case ast.Tuple():
                return [text for one in node.elts for text in self._texts(one, scopes)]
            case ast.Name():
                return self._given(node.id, scopes)
            case _:
                return []

    def _given(self, name: str, scopes: list[ast.AST]) -> list[str]:
        """What a name is given in the innermost scope that gives it anything."""
        for scope in reversed(scopes):
            values = [text for one in ast.walk(scope) for text in self._assigned(one, name, scopes)]
            if values:
                return list(dict.fromkeys(values))
        return []

    def _assigned(self, node: ast.AST, name: str, scopes: list[ast.AST]) -> list[str]:
        if not isinstance(node, ast.Assign):
            return []
        target = node.targets[0]
        if isinstance(target, ast.Name) and target.id == name:
            return self._texts(node.value, scopes) if not isinstance(node.value, ast.Name) else []
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
            pairs = zip(target.elts, node.value.elts, strict=False)
            return [text for one, value in pairs if isinstance(one, ast.Name) and one.id == name
                    for text in self._texts(value, scopes)]  # fmt: skip
        return []


def _name(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


# ---- templates ------------------------------------------------------------------------------------------------------
def _of_templates() -> Iterator[Message]:
    options = {"trimmed": "true", "trim_blocks": "true", "lstrip_blocks": "true", "newstyle_gettext": "true"}
    for name in TEMPLATES:
        content = BytesIO((ROOT / "templates" / name).read_bytes())
        for _, _, message, _ in babel_extract(content, ("_", "gettext", "ngettext", "plain", "say"), [], options):
            texts = tuple(one for one in (message if isinstance(message, tuple) else (message,)) if one)
            if texts:
                yield (texts[:2] if len(texts) > 1 else texts[0]), ""
    for name in SCRIPTS:
        yield from ((message, "") for message in said_by((ROOT / "templates" / name).read_text(encoding="utf-8")))


# ---- words ----------------------------------------------------------------------------------------------------------
def _of_words() -> Iterator[Message]:
    yield from ((word, "") for word in _words())
    from metrology.language.notices import ORDER
    from metrology.methods import METHODS

    yield from ((word, "notice") for word in ORDER)
    yield from ((word, "method") for word in (*METHODS, "creep", "derived"))
    yield from (("Figure", "audit"), ("Test", "residuals"), ("Certificate", "instrument"))


@cache
def _words() -> tuple[str, ...]:
    """Words that findings hold as they are: names of quantities, checks, effects, verdicts, methods."""
    from metrology.coordinate import QUANTITIES, SENSED
    from metrology.diagnostics import candidate
    from metrology.gum.distributions import DISTRIBUTIONS, MeanSquare
    from metrology.language.wording import PLAIN
    from metrology.methods import METHODS
    from metrology.readings.formats import FORMATS
    from metrology.report import attachments, consensus, lines, quality, sections
    from metrology.sample import SECTIONS
    from metrology.slip import DYNAMIC, STATIC
    from metrology.slip import OTHERS as OTHER_SLIPS

    tables = (candidate.RESPONSE, candidate.ELONGATION, candidate.DECAY, candidate.TENSION, candidate.turned_table())
    return (
        *filter(str.strip, JOINTS.values()), ": ",
        *quality._CARE, quality.NOT_JUDGED, "simple acceptance", "guard band", *_choices(),
        *quality.STATES, *_checklists(), *_equations(), *PHASES,
        "loading", "unloading", "gravity", "air density", "weight density", "length", "linear density", "paper",
        "scale", "scatter of", "slope correction", "strain slope", "setup slope",
        "temperature", "humidity", "pressure",
        *SECTIONS, *(key.replace("_", " ") for one in SECTIONS.values() for key in one.dimensions), *_held(),
        *(f"{key.capitalize()} of the section" for one in SECTIONS.values() for key in one.dimensions),
        "author", "reviewer", "approver",
        *lines.NAMES.values(), *consensus.WORDS.values(), *(title for _, title, _ in sections.SECTIONS),
        *(one.word for known in QUANTITIES.values() for one in known.values()), *(one.word for one in SENSED.values()),
        *(text for method in METHODS.values() for text in (method.title, method.standard)),
        *(text for table in tables for one in table.values() for text in _of_cause(one)), *_named(),
        *(words for _, words in (*DYNAMIC, *STATIC)), *OTHER_SLIPS.values(),
        *DISTRIBUTIONS, MeanSquare.name, *PLAIN.values(),
        *(description for _, description in attachments.MADE.values()),
        *(one.title for one in FORMATS), "extension", "load", "direction", "order", "curve", "wander",
        "time in each run", "time in proportion to the thrust",
        "load in the set-up", "load in the extensometer", "direction in the set-up", "direction in the extensometer",
        "fine extension", "fine force", "fine torque",
        "gain", "elastic", "power law", "Creep", "Reconstructed readings", "RECONSTRUCTED READINGS",
    )  # fmt: skip


def _of_cause(one: Candidate) -> Iterator[str]:
    """What a report says of an effect: title, consequence, advice, measurement, words of its equation."""
    from metrology.report.equations import in_words, parted

    formula, words = parted(one.equation)
    yield from (one.title, one.consequence, one.advice, one.separate, one.sign, one.cause.alone, words)
    yield from (formula,) if in_words(formula) else ()


def _equations() -> Iterator[str]:
    """Words in the equations of the methods."""
    from metrology.report.equations import in_words, parted

    for room in ("decay", "elongation", "methods", "relaxation", "response", "tension"):
        for path in sorted((ROOT / "metrology" / room).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Constant) and isinstance(node.value, str) and EQUATION.match(node.value):
                    formula, words = parted(node.value)
                    yield from (words, *((formula,) if in_words(formula) else ()))


def _choices() -> Iterator[str]:
    """Words of which findings hold one: verdicts, judgements, states, roles."""
    from metrology import consensus, diagnosis, identification
    from metrology.response.finding import Sought
    from metrology.verify.finding import VerificationFinding

    records = (
        (consensus.Disagreement, "verdict"), (diagnosis.Diagnosis, "verdict"), (diagnosis.Cause, "verdict"),
        (diagnosis.Explanation, "judgement"), (identification.InstrumentState, "state"),
        (identification.Anomaly, "state"), (identification.Document, "role"), (identification.Provided, "role"),
        (Sought, "interval"), (VerificationFinding, "verdict"),
    )  # fmt: skip
    for record, name in records:
        yield from get_args(get_type_hints(record)[name])


def _checklists() -> Iterator[str]:
    """Titles of the checklists, what their items ask, and why one does not apply."""
    from metrology.checklist import CHECKLISTS, TITLES

    yield from TITLES.values()
    yield from (item.asks for items in CHECKLISTS.values() for item in items)
    for path in sorted((ROOT / "metrology" / "checklist").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Assign | ast.Return) and node.value is not None:
                yield from (text for text in _Calls(ast.Module([], []))._texts(node.value, []) if " " in text)


def _held() -> Iterator[str]:
    """Numbers of the rig that may have been stated without an uncertainty."""
    from metrology.methods.response.known import KNOWN
    from metrology.rig.parameters import PARAMETERS, turned

    for name in (*(name for name, _ in KNOWN.values()), "length", "weight", "setup.compliance"):
        if name in PARAMETERS:
            yield from (PARAMETERS[name].meaning, turned(PARAMETERS[name]).meaning)


def _named() -> Iterator[str]:
    """Names of the checks of raw records and measurement models, titles of what explains a value off its reference."""
    for path in sorted((ROOT / "metrology").rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        given = [one for one in tree.body if isinstance(one, ast.Assign) and isinstance(one.value, ast.Constant)]
        known = {one.targets[0].id: one.value.value for one in given if isinstance(one.targets[0], ast.Name)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and _name(node.func) in NAMED and len(node.args) > NAMED[_name(node.func)]:
                first = node.args[NAMED[_name(node.func)]]
                name = first.value if isinstance(first, ast.Constant) else known.get(getattr(first, "id", ""))
                if isinstance(name, str):
                    yield name


# ---- catalogues -----------------------------------------------------------------------------------------------------
def updated(code: str) -> Catalog:
    """The catalogue of a language with every message, and none that is no longer used."""
    path = LOCALE / code / "LC_MESSAGES" / f"{DOMAIN}.po"
    known = read_po(BytesIO(path.read_bytes()), locale=code) if path.exists() else Catalog(locale=code)
    made = Catalog(
        locale=code,
        project="metrology",
        header_comment=f"# {COMMENT}",
        fuzzy=False,
        creation_date=DAY,
        revision_date=DAY,
    )
    for message, context in found():
        key = message[0] if isinstance(message, tuple) else message
        before = known.get(key, context or None)
        made.add(message, before.string if before is not None else "", context=context or None)
    return made


def lacking(catalogue: Catalog) -> list[str]:
    """Messages without a translation."""
    return [str(one.id) for one in catalogue if one.id and not all(_strings(one.string))]


def _strings(string: str | tuple[str, ...] | list[str]) -> tuple[str, ...]:
    return (string,) if isinstance(string, str) else tuple(string)


def main() -> int:
    """Write the catalogues; with ``--check`` only say what they lack."""
    status = 0
    for code in LANGUAGES:
        catalogue = updated(code)
        for message in lacking(catalogue):
            print(f"{code}: no translation of {message!r}")
            status = 1
        if "--check" not in sys.argv:
            path = LOCALE / code / "LC_MESSAGES" / f"{DOMAIN}.po"
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("wb") as file:
                write_po(file, catalogue, width=120, sort_output=True, omit_header=False)
    return status


if __name__ == "__main__":
    sys.exit(main())
