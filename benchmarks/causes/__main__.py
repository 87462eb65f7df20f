"""`python -m benchmarks.causes make FOLDER`, `python -m benchmarks.causes score METHOD FOLDER`: see docs/benchmark.md."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from .cases import FROZEN, FROZEN_SEED, KINDS, MAKERS, digest, plans, write


def main(arguments: list[str] | None = None) -> int:
    """Run a command."""
    args = _parser().parse_args(arguments)
    return int(args.command(args))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.causes", description=__doc__)
    commands = parser.add_subparsers(required=True)
    make = commands.add_parser("make", help="write the cases into a folder")
    make.add_argument("folder", type=Path)
    make.add_argument("--seed", type=int, default=FROZEN_SEED, help="0: the frozen table; others: fresh cases")
    make.add_argument("--each", type=int, help="number of cases of each kind and method, in place of the table of 61")
    make.add_argument("--method", action="append", choices=list(MAKERS), help="this kind of test only; may be repeated")
    make.add_argument("--kind", action="append", choices=KINDS, help="this kind of case only; may be repeated")
    make.set_defaults(command=_make)
    return parser


def _make(args: argparse.Namespace) -> int:
    counts = {
        method: {kind: args.each or number for kind, number in kinds.items() if not args.kind or kind in args.kind}
        for method, kinds in FROZEN.items()
        if not args.method or method in args.method
    }
    for plan in plans(args.seed, counts):
        begin = time.process_time()
        write(plan, args.folder)
        seconds = time.process_time() - begin
        print(f"{digest(args.folder / plan.name)[:16]}  {plan.name}  {seconds:.1f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
