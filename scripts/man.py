"""Writes docs/man/metrology.1 from the parser of the command line, by argparse-manpage."""

import os
import subprocess
import sys
from pathlib import Path

TARGET = Path(__file__).parents[1] / "docs" / "man" / "metrology.1"


def main() -> None:
    """Write the page: the same text on every day and every terminal."""
    from metrology import __version__

    options = {
        "module": "metrology.cli",
        "function": "parser",
        "prog": "metrology",
        "project-name": "metrology",
        "version": __version__,
        "description": "from a campaign file to a test report",
        "manual-title": "metrology",
        "manual-section": "1",
        "format": "single-commands-section",
    }
    command = [str(Path(sys.executable).parent / "argparse-manpage")]
    command += [text for name, value in options.items() for text in (f"--{name}", value)]
    fixed = {**os.environ, "COLUMNS": "70", "SOURCE_DATE_EPOCH": "0"}
    page = subprocess.run(command, check=True, capture_output=True, text=True, env=fixed).stdout  # noqa: S603
    # A page has the version it is of; the day on which it was written says nothing.
    head, _, rest = page.partition("\n")
    lines = [head.replace('"1970\\-01\\-01"', '""'), *(line.rstrip() for line in rest.splitlines())]
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
