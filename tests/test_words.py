"""Plain words: what the glossary replaces stands in no sentence that a person can meet."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BANNED = (
    *(
        "told",
        "mend",
        "mends",
        "mended",
        "rival",
        "rivals",
        "gnaw",
        "gnaws",
        "lent",
        "bread",
        "hats",
        "bent",
        "settled",
    ),
    *("asks for a place", "ask for a place", "asks for no place", "takes up", "take up", "of its u", "sought anew"),
    *("open loop", "told apart", "tell apart", "tells apart", "way of the paper", "paper's way", "apart / u"),
    *("shows from", "beside", "worded", "rehearse", "surcharge", "hindrance", "couples", "twins", "the law's"),
    *("law of propagation", "looked for and"),
)
"""Words and phrases that `docs/glossary.md` has a term for, or that are no English of the field."""
_FOUND = re.compile(rf"(?<![\w.-])(?:{'|'.join(map(re.escape, BANNED))})(?![\w-])", re.IGNORECASE)
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "templates").glob("*.html")])
MODULES = sorted((ROOT / "metrology").rglob("*.py"))


def sentences(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Texts of a module that are sentences: with a space, and no docstring."""
    nodes = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    bodies = [node.body for node in ast.walk(tree) if isinstance(node, nodes)]
    documented = {id(one.value) for body in bodies for one in body if isinstance(one, ast.Expr)}
    for node in ast.walk(tree):
        text = node.value if isinstance(node, ast.Constant) and id(node) not in documented else None
        if isinstance(text, str) and " " in text:
            yield node.lineno, text


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_law_no_page_has_a_word_that_the_glossary_replaces(path: Path) -> None:
    lines = re.sub(r"\{[{%].*?[%}]\}|<[^>]*>|`[^`]*`", " ", path.read_text("utf-8")).splitlines()
    found = [
        f"{path.name}:{number}: {word[0]}" for number, line in enumerate(lines, 1) for word in _FOUND.finditer(line)
    ]
    assert not found


@pytest.mark.long
def test_law_no_sentence_of_the_program_has_a_word_that_the_glossary_replaces() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {word[0]}"
        for path in MODULES
        for line, text in sentences(ast.parse(path.read_text("utf-8")))
        for word in _FOUND.finditer(text)
    ]
    assert not found


def test_planted_a_banned_word_is_found_and_part_of_a_word_is_not() -> None:
    planted = ast.parse('"""Told."""\nx = "He was told so."\ny = "Untold riches, unbent."\nz = "told"\n')
    assert [line for line, text in sentences(planted) if _FOUND.search(text)] == [2]
