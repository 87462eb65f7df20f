"""Check PDFs against PDF/A-3a and PDF/UA-1 with veraPDF, one start of Java a profile for all files.

The jar is that of VERAPDF_JAR, or the one in the local Maven repository, or Maven fetches it.

python scripts/check_pdf.py                    say whether anything can be checked
python scripts/check_pdf.py FILE…              check these files
python scripts/check_pdf.py --signed FOLDER…   check the report in each folder, and a copy signed by a test authority

Exit status: 0 all conform; 1 one does not; 77 skipped, as Java or the jar is missing.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

GROUP, NAME, VERSION = "org.verapdf.apps", "greenfield-apps", "1.28.2"
MAIN = "org.verapdf.apps.GreenfieldCliWrapper"
PROFILES = {"3a": "PDF/A-3a", "ua1": "PDF/UA-1"}
SKIPPED = 77


def jar() -> Path | str:
    """The jar of veraPDF, or why there is none."""
    if not shutil.which("java"):
        return "no Java"
    if named := os.environ.get("VERAPDF_JAR"):
        return Path(named) if Path(named).is_file() else f"VERAPDF_JAR names no file: {named}"
    repository = Path(os.environ.get("MAVEN_REPOSITORY", Path.home() / ".m2" / "repository"))
    path = repository.joinpath(*GROUP.split("."), NAME, VERSION, f"{NAME}-{VERSION}.jar")
    if not path.is_file() and shutil.which("mvn"):
        wanted = f"-Dartifact={GROUP}:{NAME}:{VERSION}:jar"
        fetch = ["mvn", "-q", "dependency:get", wanted, "-Dtransitive=false"]
        with contextlib.suppress(subprocess.TimeoutExpired):  # Without a network it is not to be had.
            subprocess.run(fetch, check=False, timeout=120)  # noqa: S603
    return path if path.is_file() else "no jar of veraPDF (set VERAPDF_JAR, or install Maven to fetch it)"


def faults(tool: Path, profile: str, files: Sequence[Path]) -> dict[str, list[str]]:
    """What each file does not keep of a profile; raises where veraPDF did not judge every file."""
    command = ["java", "-cp", str(tool), MAIN, "-f", profile, "--format", "json", *map(str, files)]
    answer = subprocess.run(command, check=False, capture_output=True, text=True, timeout=120 + 60 * len(files))  # noqa: S603
    jobs = json.loads(answer.stdout)["report"]["jobs"]
    judged = {Path(job["itemDetails"]["name"]).resolve(): list(_rules(job)) for job in jobs}
    # veraPDF answers with absolute names, whatever it was given.
    found = {str(path): judged[path.resolve()] for path in files if path.resolve() in judged}
    missing = [str(path) for path in files if str(path) not in found]
    if missing:
        raise RuntimeError(f"veraPDF judged nothing of {', '.join(missing)}: {answer.stderr[-500:]}")
    return found


def _rules(job: dict) -> Iterator[str]:
    results = job.get("validationResult") or []
    if not results:
        yield "could not be validated"
    for result in results:
        for rule in result["details"]["ruleSummaries"]:
            if rule["ruleStatus"] == "FAILED":
                where = f"{rule['clause']} test {rule['testNumber']}, {rule['failedChecks']} times"
                yield f"{where}: {rule['description']}"


def signed_copies(folders: Sequence[Path], home: Path) -> list[Path]:
    """Every report, and its copy that a test authority signed in every role."""
    from metrology import signoff
    from metrology.signoff.opened import open_report

    signoff.create_authority(home / "authority")
    files = []
    for folder in folders:
        copy = home / folder.name / "report-signed.pdf"
        copy.parent.mkdir()
        shutil.copy(folder / "report.pdf", copy)
        for person in open_report(copy).required:
            key = home / "authority" / f"{person.role}.p12"
            signoff.sign(copy, person.role, signoff.from_file(key, None, lambda: b"test"))
        files += [folder / "report.pdf", copy]
    return files


def check(files: Sequence[Path]) -> int:
    """Check files and tell the outcome."""
    tool = jar()
    if isinstance(tool, str):
        print(f"check-pdf: skipped because of {tool}")
        return SKIPPED
    failed = False
    for profile, title in PROFILES.items() if files else ():
        for name, wrong in faults(tool, profile, files).items():
            failed |= bool(wrong)
            print(f"{title:9} {'does not conform' if wrong else 'conforms':16} {name}")
            for rule in wrong:
                print(f"  {rule}")
    return int(failed)


def main() -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description="Check PDFs against PDF/A-3a and PDF/UA-1 with veraPDF.")
    parser.add_argument("paths", type=Path, nargs="*")
    parser.add_argument("--signed", action="store_true", help="paths are folders of reports; check signed copies too")
    options = parser.parse_args()
    if not options.signed:
        return check(options.paths)
    if isinstance(jar(), str):
        return check([])
    with TemporaryDirectory() as home:
        return check(signed_copies(options.paths, Path(home)))


if __name__ == "__main__":
    sys.exit(main())
