"""The syntax of expressions: text to steps for a stack machine, and the error with the column where reading stopped.

::

    sum      := product {("+" | "-") product}
    product  := factor {("*" | "/") factor}
    factor   := ("+" | "-") factor | atom ["**" factor]           -2**2 is −4, 2**3**2 is 2**9
    atom     := number | name | function "(" sum {"," sum} ")" | "(" sum ")"
    name     := identifiers joined by dots: letters of any language, digits, underscores
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal

from metrology.expression.elementary import FUNCTIONS
from metrology.units.dimensions import TextError, quoted

MAX_LENGTH = 1000
MAX_DEPTH = 40
CONSTANTS = {"pi": math.pi, "e": math.e}
#: Words that are no names of quantities.
RESERVED = frozenset(CONSTANTS) | frozenset(FUNCTIONS)
_ARITY: dict[str, int | None] = {"atan2": 2, "min": None, "max": None}

LETTERS = (
    "A-Za-z\u00aa\u00ba\u00c0-\u00d6\u00d8-\u00f6\u00f8-\u02af\u0370-\u0373\u0376\u0377\u037b-\u037d\u0386\u0388-\u0481"
    "\u048a-\u0556\u0561-\u0587\u05d0-\u05ea\u0620-\u064a\u0671-\u06d3\u0904-\u0939\u0e01-\u0e30\u10d0-\u10ff\u1e00-\u1fbc"
    "\u3041-\u3096\u30a1-\u30fa\u3400-\u4dbf\u4e00-\u9fff\uac00-\ud7a3"
)
"""Letters of names, as the inside of a set of characters that Python, JSON Schema and XML read alike."""
_LETTER = rf"[{LETTERS}_]"
_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    rf"|(?P<name>{_LETTER}(?:{_LETTER}|[0-9])*(?:\.{_LETTER}(?:{_LETTER}|[0-9])*)*)"
    r"|(?P<sign>\*\*|[-+*/(),])|(?P<end>$)|(?P<other>.))",
    re.DOTALL,
)
_ALIASES = str.maketrans({"µ": "μ", "−": "-"})
_MENDS = {
    "^": "write a power as 'x**2'",
    "×": "write a product as 'a * b'",
    "·": "write a product as 'a * b'",
    "²": "write a power as 'x**2'",
    "³": "write a power as 'x**3'",
    "√": "write a root as 'sqrt(x)'",
    "=": "write only what stands right of the equals sign",
}


class ExpressionError(TextError):
    """An expression that cannot be read or evaluated; `column` counts from 1."""

    def __init__(self, got: str, expected: str, fix: str = "", *, column: int = 0) -> None:
        super().__init__(f"{got} at column {column}" if column else got, expected, fix)
        self.column = column


@dataclass(frozen=True)
class Step:
    """One step of the stack machine: push a number or the value of a name, or replace `arity` values by a result."""

    kind: Literal["number", "name", "operation", "function"]
    word: str
    column: int
    arity: int = 0
    number: float = 0.0


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    column: int


class _Reader:
    """Recursive descent over the tokens; the depth is bounded, so the stack of Python is as well."""

    def __init__(self, text: str) -> None:
        self.text, self.position, self.depth = text.translate(_ALIASES), 0, 0
        self.steps: list[Step] = []
        self.before = self.token = self._next()

    def _next(self) -> _Token:
        match = _TOKEN.match(self.text, self.position)
        assert match is not None
        assert match.lastgroup is not None
        self.position = match.end()
        token = _Token(match.lastgroup, match[match.lastgroup], match.start(match.lastgroup) + 1)
        if token.kind == "other":
            raise self.refusal(token, "arithmetic such as 'k * L / (w * t)'", _MENDS.get(token.text, ""))
        return token

    def refusal(self, token: _Token, expected: str, fix: str = "") -> ExpressionError:
        got = "the end" if token.kind == "end" else quoted(token.text)
        return ExpressionError(f"{got} in {quoted(self.text)}", expected, fix, column=token.column)

    def advance(self) -> _Token:
        self.before, self.token = self.token, self._next()
        return self.before

    def at(self, *signs: str) -> bool:
        return self.token.kind == "sign" and self.token.text in signs

    def emit(self, word: str, column: int, arity: int) -> None:
        kind: Literal["operation", "function"] = "function" if word in FUNCTIONS else "operation"
        self.steps.append(Step(kind, word, column, arity))

    def expression(self) -> None:
        self.sum()
        if self.token.kind == "end":
            return
        fix = "a '*' is missing"
        if self.before.kind == "number" and self.token.kind == "name":
            fix += ", or a name has a dash: give the quantity a name without one under 'where:'"
        if self.at(","):
            fix = "the decimal mark is a point"
        raise self.refusal(self.token, "an operator or the end", fix)

    def sum(self) -> None:
        self.product()
        while self.at("+", "-"):
            sign = self.advance()
            self.product()
            self.emit(sign.text, sign.column, 2)

    def product(self) -> None:
        self.factor()
        while self.at("*", "/"):
            sign = self.advance()
            self.factor()
            self.emit(sign.text, sign.column, 2)

    def factor(self) -> None:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.refusal(self.token, f"at most {MAX_DEPTH} levels of parentheses, signs and powers")
        if self.at("+", "-"):
            sign = self.advance()
            self.factor()
            if sign.text == "-":
                self.emit("negate", sign.column, 1)
        else:
            self.atom()
            if self.at("**"):
                sign = self.advance()
                self.factor()
                self.emit("**", sign.column, 2)
        self.depth -= 1

    def atom(self) -> None:
        token = self.token
        if token.kind == "number":
            self.number(self.advance())
        elif token.kind == "name":
            self.advance()
            self.call(token) if self.at("(") else self.name(token)
        elif self.at("("):
            self.advance()
            self.sum()
            self.close(token)
        else:
            raise self.refusal(token, "a number, a name or '('")

    def close(self, opening: _Token) -> None:
        if not self.at(")"):
            raise self.refusal(self.token, f"a ')' for the '(' at column {opening.column}")
        self.advance()

    def number(self, token: _Token) -> None:
        value = float(token.text)
        if not math.isfinite(value):
            raise self.refusal(token, "a number below 1e308")
        self.steps.append(Step("number", token.text, token.column, number=value))

    def name(self, token: _Token) -> None:
        if token.text in FUNCTIONS:
            raise self.refusal(token, f"its argument, such as '{token.text}(x)'")
        if token.text in CONSTANTS:
            self.steps.append(Step("number", token.text, token.column, number=CONSTANTS[token.text]))
        else:
            self.steps.append(Step("name", token.text, token.column))

    def call(self, token: _Token) -> None:
        if token.text not in FUNCTIONS:
            near = get_close_matches(token.text, FUNCTIONS, 1)
            fix = f"did you mean '{near[0]}'?" if near else "a '*' may be missing"
            raise self.refusal(token, f"a function, one of {', '.join(FUNCTIONS)}", fix)
        opening, count = self.advance(), 1
        self.sum()
        while self.at(","):
            self.advance()
            self.sum()
            count += 1
        self.close(opening)
        wanted = _ARITY.get(token.text, 1)
        if count != wanted and (wanted or count < 2):
            raise self.refusal(token, f"{wanted or 'two or more'} argument(s), not {count}")
        self.emit(token.text, token.column, count)


def read(text: str) -> tuple[Step, ...]:
    """Steps of an expression in the order in which a stack machine takes them.

    Raises
    ------
    ExpressionError
        With the column of what cannot be read.
    """
    if not isinstance(text, str):
        raise ExpressionError(f"{quoted(text)}, not a text", "an expression such as 'k * L / (w * t)'")
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"an expression of {len(text)} characters", f"at most {MAX_LENGTH} characters")
    reader = _Reader(text)
    reader.expression()
    return tuple(reader.steps)
