"""The notebooks of the documentation run as plain Python, and say what is stored in them.

`scripts/notebooks.py` executes them in Jupyter, and stores their outputs.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).parents[1] / "docs" / "notebooks"
LARGEST = 150_000
"""Bytes of a notebook: its pictures are small ones."""


def cells(name: str) -> list[dict[str, Any]]:
    book = json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))
    return [cell for cell in book["cells"] if cell["cell_type"] == "code"]


def said(source: str, names: dict[str, Any]) -> str:
    """What a cell prints, and its last expression as Jupyter shows it in text."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        shown = None if last is None else eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    return printed.getvalue() + ("" if shown is None else repr(shown))


def stored(cell: dict[str, Any]) -> str:
    texts = [output.get("text") or output["data"]["text/plain"] for output in cell["outputs"]]
    return "".join("".join(text) for text in texts)


def test_law_there_are_notebooks_and_they_are_small():
    paths = sorted(FOLDER.glob("*.ipynb"))
    assert [path.stem for path in paths] == ["diagnosis", "elongation", "own_model"]
    assert all(path.stat().st_size < LARGEST for path in paths)


@pytest.mark.long
@pytest.mark.parametrize("name", ["diagnosis", "elongation", "own_model"])
def test_twice_a_notebook_says_in_plain_python_what_is_stored(name):
    """White space apart: Jupyter breaks long lines."""
    names: dict[str, Any] = {}
    for cell in cells(name):
        assert said("".join(cell["source"]), names).split() == stored(cell).split()
