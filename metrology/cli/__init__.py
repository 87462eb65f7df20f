"""The command line: one module for each command; what several share stands in `campaigns`.

Exit status: 0 done; 1 a campaign was processed and something in it failed its requirement; 2 bad input or usage; 3, of
`verify` alone, nothing failed and something could not be checked.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from io import TextIOWrapper

from metrology import __version__
from metrology.cli import (
    authority,
    batch,
    check,
    collect,
    completion,
    diagnose,
    doctor,
    export,
    importing,
    lsp,
    memory,
    new,
    report,
    run,
    schema,
    sign,
    verify,
    watch,
)
from metrology.cli.campaigns import UNUSABLE
from metrology.errors import MetrologyError

COMMANDS = (
    check,
    run,
    report,
    batch,
    watch,
    diagnose,
    sign,
    verify,
    authority,
    export,
    collect,
    schema,
    new,
    importing,
    doctor,
    lsp,
    completion,
)
"""Modules of the commands, in the order of the help; ``add(commands)`` of each declares it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status."""
    # Small matrices: threads of BLAS cost more than they give, and their number would show in the last bits.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters shows '?' in their place
    options = parser().parse_args(arguments)
    try:
        memory.require()
        status: int = options.command(options)
    except MetrologyError as error:
        print(error, file=sys.stderr)
        return UNUSABLE
    except KeyboardInterrupt:
        print("interrupted; reports made earlier are whole", file=sys.stderr)
        return UNUSABLE
    except BrokenPipeError:
        sys.stderr.close()
        return UNUSABLE
    except OSError as error:
        reason = error.strerror or type(error).__name__
        print(f"{error.filename or 'output'}: {reason}; reports made earlier are whole", file=sys.stderr)
        return UNUSABLE
    except (MemoryError, ImportError, SystemError, RuntimeError) as error:
        if not _out_of_memory(error):
            raise
        print("memory is used up; reports made earlier are whole. Fix: raise the limit (ulimit -v)", file=sys.stderr)
        return UNUSABLE
    return status


def _out_of_memory(error: Exception) -> bool:
    """Whether there was too little memory, also for a library that was to be loaded: that says so in its own ways."""
    words = ("map segment", "allocate memory", "without exception", "without setting an exception", "start new thread")
    return isinstance(error, MemoryError) or any(word in str(error) for word in words)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    made = argparse.ArgumentParser(prog="metrology", description="From a campaign file to a test report.")
    made.add_argument("--version", action="version", version=f"metrology {__version__}")
    commands = made.add_subparsers(required=True, metavar="COMMAND", title="commands")
    for command in COMMANDS:
        command.add(commands)
    return made
