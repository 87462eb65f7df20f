"""`python -m benchmarks.causes make FOLDER`, then `… score METHOD FOLDER`: see docs/benchmark.md."""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import asdict
from pathlib import Path

from .alike import FILE
from .cases import FROZEN, FROZEN_SEED, KINDS, MAKERS, digest, plans, write
from .judging import ENTRIES, cases, run
from .likeness import table
from .public import RECORDS, convert
from .score import card, printed


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
    public = commands.add_parser("import", help="make a case of a public record that you have")
    public.add_argument("record", choices=list(RECORDS))
    public.add_argument("files", nargs="+", type=Path, help="its CSV file, or those of all specimens")
    public.add_argument("--to", type=Path, required=True, help="folder for the case")
    public.set_defaults(command=_import)
    alike = commands.add_parser("alike", help="compute alike.json anew: which causes look alike")
    alike.set_defaults(command=_alike)
    score = commands.add_parser("score", help="judge a method over the cases in a folder")
    score.add_argument("entry", help=f"{', '.join(ENTRIES)}, or a command; {{folder}} in it is that of a case")
    score.add_argument("folder", type=Path)
    score.add_argument("--json", type=Path, help="write cards, judgements and answers into this file")
    score.add_argument("--limit", type=int, default=100, help="CPU time / s of a case (100)")
    score.add_argument("--jobs", type=int, default=1, help="cases at the same time (1)")
    score.add_argument("--match", default="", help="only cases whose name holds this")
    score.set_defaults(command=_score)
    return parser


def _import(args: argparse.Namespace) -> int:
    print(convert(args.record, args.files, args.to))
    return 0


def _alike(_args: argparse.Namespace) -> int:
    FILE.write_text(json.dumps(table(), indent=1, sort_keys=True) + "\n", encoding="utf-8")
    return 0


def _score(args: argparse.Namespace) -> int:
    folders = [folder for folder in cases(args.folder) if args.match in folder.name]
    if not folders:
        print(f"{args.folder}: no case in it; `make` writes them", file=sys.stderr)
        return 2
    found = run(args.entry, folders, args.limit, args.jobs)
    judged = [one for one, _ in found]
    cards = {method: card(some) for method in MAKERS if (some := [one for one in judged if one.method == method])}
    cards["all"] = card(judged)
    print(printed(args.entry[:28], cards))
    if args.json:
        cases_ = [{**asdict(one), "answer": asdict(answer)} for one, answer in found]
        args.json.write_text(
            json.dumps({"entry": args.entry, "cards": cards, "cases": cases_}, indent=1), encoding="utf-8"
        )
    return 0


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
