"""The one type family of the report: DejaVu, which matplotlib brings, and no other font of the machine."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
import unicodedata
from base64 import b64encode
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

FACES = {"DejaVuSans.ttf": 400, "DejaVuSans-Bold.ttf": 700}
"""File → weight."""
PREFIX = "metrology-fonts-"
"""Begins the name of the folder with the settings of one process."""


def folder() -> Path:
    """Folder of the fonts that matplotlib brings."""
    import matplotlib as mpl

    return Path(mpl.get_data_path()) / "fonts" / "ttf"


@cache
def characters() -> frozenset[int]:
    """Code points that the report can print; those that reorder text are not among them."""
    from matplotlib.ft2font import FT2Font

    font = FT2Font(str(folder() / "DejaVuSans.ttf"))
    return frozenset(font.get_charmap()) - set(range(0x202A, 0x202F)) - set(range(0x2066, 0x206A))


@cache
def isolate() -> None:
    """Let Pango see the bundled DejaVu alone, so that a report's bytes do not hang on what a machine has installed.

    The settings are files, which the process that made them removes at its end; those that it starts use them too.
    """
    inherited = Path(os.environ.get("FONTCONFIG_FILE", ""))
    if inherited.parent.name.startswith(PREFIX) and inherited.is_file():
        return
    home = Path(tempfile.mkdtemp(prefix=PREFIX))
    atexit.register(shutil.rmtree, home, ignore_errors=True)
    kept = "".join(
        f"<glob>{escape(str(folder()))}/{name}</glob>" for name in ("DejaVuSans.ttf", "DejaVuSans-*.ttf", "LastResort*")
    )
    settings = home / "fonts.conf"
    settings.write_text(
        '<?xml version="1.0"?><!DOCTYPE fontconfig SYSTEM "fonts.dtd"><fontconfig>'
        f"<dir>{escape(str(folder()))}</dir><cachedir>{escape(str(home / 'cache'))}</cachedir>"
        f"<selectfont><rejectfont><glob>*</glob></rejectfont><acceptfont>{kept}</acceptfont></selectfont></fontconfig>",
        encoding="utf-8",
    )
    os.environ["FONTCONFIG_FILE"] = str(settings)


@cache
def _subset(name: str, characters: frozenset[int]) -> str:
    from fontTools import subset  # type: ignore[import-untyped]

    options = subset.Options(hinting=False, layout_features=[], recalc_timestamp=False, notdef_outline=True)
    options.drop_tables += ["FFTM", "GDEF", "GPOS", "GSUB", "kern"]
    with subset.load_font(str(folder() / name), options) as font:
        chosen = subset.Subsetter(options)
        chosen.populate(unicodes=characters)
        chosen.subset(font)
        stream = BytesIO()
        subset.save_font(font, stream, options)
    return b64encode(stream.getvalue()).decode("ascii")


def faces(text: str) -> str:
    """CSS that carries the fonts, cut down to the characters of `text`, for an HTML file that works alone."""
    wanted = frozenset(map(ord, text)) | frozenset(range(32, 127))
    return "".join(
        f'@font-face{{font-family:"Report";font-weight:{weight};src:url(data:font/ttf;base64,{_subset(name, wanted)})}}'
        for name, weight in FACES.items()
    )


def visible(value: Any) -> Any:
    """Text with codes for characters that the font lacks, or that would reorder or hide what stands around them."""
    if not isinstance(value, str) or hasattr(value, "__html__") or (value.isascii() and value.isprintable()):
        return value
    return "".join(f"⟨U+{ord(c):04X}⟩" if _needs_code(c) else c for c in value)


def _needs_code(character: str) -> bool:
    if character in "\n\t\r":
        return False
    return unicodedata.category(character) in {"Cc", "Cf", "Cs", "Co", "Cn"} or ord(character) not in characters()
