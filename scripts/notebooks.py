"""Execute the notebooks of the documentation and compare what they say with what is stored in them.

python scripts/notebooks.py [FILE…]           execute; what a cell prints or returns has to be what is stored
python scripts/notebooks.py --write [FILE…]   execute and store the outputs

Pictures are stored and not compared: what a plot shows in words, with its numbers, is. Needs the extra `docs`.
Exit status: 0 all agree; 1 a cell failed, or says something else.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "notebooks"
SECONDS = 300


def executed(path: Path) -> Any:
    """The notebook with the outputs of this run."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook, timeout=SECONDS, kernel_name="python3", resources={"metadata": {"path": path.parent}}
    )
    client.execute()
    return notebook


def said(notebook: Any) -> list[str]:
    """What each cell of code prints and returns, as text."""
    return ["".join(_texts(cell)) for cell in notebook.cells if cell.cell_type == "code"]


def _texts(cell: Any) -> Iterator[str]:
    for output in cell.outputs:
        yield output.get("text", "") or output.get("data", {}).get("text/plain", "")


def stored(notebook: Any) -> Any:
    """The notebook as it is kept: without what differs from run to run."""
    notebook.metadata = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    for cell in notebook.cells:
        cell.metadata = {}
        if cell.cell_type == "code":
            cell.execution_count = None
            for output in cell.outputs:
                output.pop("execution_count", None)
                if output.output_type == "execute_result":
                    output.execution_count = None
    return notebook


def differences(path: Path, *, write: bool) -> list[str]:
    """What a notebook says otherwise than it did when its outputs were stored."""
    import nbformat
    from nbclient.exceptions import CellExecutionError

    before = said(nbformat.read(path, as_version=4))
    try:
        notebook = executed(path)
    except CellExecutionError as error:
        return [f"{path.name}: a cell failed\n{error}"]
    if write:
        nbformat.write(stored(notebook), path)
        return []
    pairs = enumerate(zip(before, said(notebook), strict=True), 1)
    return [f"{path.name}, cell of code {at}\n  stored: {a!r}\n  now:    {b!r}" for at, (a, b) in pairs if a != b]


def main(arguments: Sequence[str] | None = None) -> int:
    """Execute the notebooks that are named, or all of them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE")
    parser.add_argument("--write", action="store_true", help="store the outputs of this run")
    options = parser.parse_args(arguments)
    # The kernel finds the package of this folder, and small matrices no threads of BLAS.
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    paths = options.files or sorted(FOLDER.glob("*.ipynb"))
    found = [one for path in paths for one in differences(path, write=options.write)]
    print("\n".join(found), file=sys.stderr, end="\n" if found else "")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
