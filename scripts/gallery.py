"""Draw the gallery of docs/gallery.md, page 1 of every report in reports/; needs pdftoppm of poppler."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docs" / "gallery"
WIDTH = 700
"""Of a picture, in pixels: its words can be read, and it takes some 60 kB."""


def main() -> int:
    """Write one picture a campaign; status 1 where a report is not there."""
    FOLDER.mkdir(exist_ok=True)
    names = sorted(path.parent.name for path in ROOT.glob("campaigns/*/campaign.yaml"))
    missing = [name for name in names if not (ROOT / "reports" / name / "report.pdf").exists()]
    if missing:
        print(f"gallery: no report of {', '.join(missing)}. Fix: make report", file=sys.stderr)
        return 1
    for name in names:
        draw(name)
    return 0


def draw(name: str) -> None:
    """Page 1 of a report in few colours, as its print in black and one blue needs no more."""
    target = FOLDER / name
    report = ROOT / "reports" / name / "report.pdf"
    size = ("-scale-to-x", str(WIDTH), "-scale-to-y", "-1")
    subprocess.run(["pdftoppm", "-png", "-f", "1", "-singlefile", *size, str(report), str(target)], check=True)
    picture = target.with_suffix(".png")
    with Image.open(picture) as page:
        page.convert("RGB").quantize(32).save(picture, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
