"""Mutation testing of the rooms that give the numbers, by mutmut, on a seeded sample of all mutants.

Each file gets its share of the sample. Prints a table by file with the rate of mutants killed and its exact 95 %
interval, then the change of each survivor; which mutants and tests there are says `[tool.mutmut]` in pyproject.toml.

python scripts/mutants.py [COUNT] [--seed SEED] [--children N]
"""

from __future__ import annotations

import argparse
import ast
import difflib
import os
import random
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

MUTMUT = str(Path(sys.executable).with_name("mutmut"))
KILLED = ("killed", "timeout", "segfault")
"""What ends a mutant: a test that fails, one that does not end, a process that dies."""
ROOT = Path(__file__).parents[1]


def mutmut(*arguments: str) -> str:
    """Output of one command of mutmut."""
    done = subprocess.run([MUTMUT, *arguments], capture_output=True, text=True, check=False, cwd=ROOT)  # noqa: S603
    if done.returncode:
        raise SystemExit(f"mutmut {arguments[0]}: status {done.returncode}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return done.stdout


def states() -> dict[str, str]:
    """Every mutant, and what became of it."""
    return dict(re.findall(r"^ *(\S+__mutmut_\d+): (.+)$", mutmut("results", "--all", "true"), re.MULTILINE))


def by_file(names: Sequence[str]) -> dict[str, list[str]]:
    """Mutants of each file, which the dotted name of a mutant begins with."""
    found = defaultdict(list)
    for name in names:
        found[re.split(r"\.x_|\.xǁ", name)[0].replace(".", "/") + ".py"].append(name)
    return dict(sorted(found.items()))


def sample(files: Mapping[str, Sequence[str]], count: int, seed: int) -> list[str]:
    """As many mutants of each file as its share of all, by the largest remainder."""
    rng = random.Random(seed)  # noqa: S311 – nothing is secret
    total = sum(map(len, files.values()))
    shares = {file: count * len(names) / total for file, names in files.items()}
    numbers = {file: int(share) for file, share in shares.items()}
    for file in sorted(shares, key=lambda file: int(shares[file]) - shares[file])[: count - sum(numbers.values())]:
        numbers[file] += 1
    return [name for file, names in files.items() for name in rng.sample(sorted(names), numbers[file])]


def interval(killed: int, tried: int) -> str:
    """Rate with its exact (Clopper–Pearson) interval."""
    from scipy.stats import binomtest

    found = binomtest(killed, tried).proportion_ci(0.95)
    return f"{killed} of {tried}, {killed / tried:.1%} ({found.low:.1%} to {found.high:.1%})"


def functions(file: str) -> dict[str, str]:
    """Source of every function of a file as mutmut wrote it, the mutants and what they were made from, by name."""
    found = {}
    for node in ast.walk(ast.parse((ROOT / "mutants" / file).read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            name, node.name = node.name, "f"
            found[name] = ast.unparse(node)
    return found


def change(sources: Mapping[str, str], mutant: str) -> list[str]:
    """Lines that a mutant takes away and puts in."""
    name = mutant.rsplit(".", 1)[1]
    before, after = sources[re.sub(r"\d+$", "orig", name)], sources[name]
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), n=0, lineterm="")
    return [re.sub(r" +", " ", line) for line in lines if re.match(r"[-+](?![-+])", line)]


def words_alone(lines: Sequence[str]) -> bool:
    """Whether nothing but a text differs."""
    bare = [re.sub(r"'[^']*'|\"[^\"]*\"", "''", line[1:]) for line in lines]
    return len(bare) % 2 == 0 and bare[: len(bare) // 2] == bare[len(bare) // 2 :]


def tell(files: Mapping[str, Sequence[str]], tried: Mapping[str, str]) -> None:
    """Print the table, the rates, and the change of each survivor."""
    print("| file | mutants | tried | killed | of them not of words alone, killed |\n|---|---|---|---|---|")
    numbers, survivors = [], []
    for file, names in files.items():
        here = [name for name in names if name in tried]
        sources = functions(file) if here else {}
        changes = {name: change(sources, name) for name in here}
        numbers += (plain := [name for name in here if not words_alone(changes[name])])
        killed, kept = (sum(tried[name] in KILLED for name in some) for some in (here, plain))
        print(f"| {file} | {len(names)} | {len(here)} | {killed} | {len(plain)}, {kept} |")
        survivors += [(name, changes[name]) for name in here if tried[name] not in KILLED]
    for title, some in (("all", list(tried)), ("without those of words alone", numbers)):
        print(f"\n{title}: killed {interval(sum(tried[name] in KILLED for name in some), len(some))}")
    for name, lines in survivors:
        print("", f"{name}: {tried[name]}", *lines, sep="\n")


def main() -> None:
    """Make all mutants, try a sample."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--children", type=int, default=os.cpu_count())
    options = parser.parse_args()
    shutil.rmtree(ROOT / "mutants", ignore_errors=True)  # which tests reach a function is kept, also where one changed
    mutmut("run", "--max-children", str(options.children), "metrology.gum.inputs.*")  # makes all, tries these few
    files = by_file(list(states()))
    names = sample(files, options.count, options.seed)
    mutmut("run", "--max-children", str(options.children), *names)
    after = states()
    tell(files, {name: after[name] for name in names})


if __name__ == "__main__":
    main()
