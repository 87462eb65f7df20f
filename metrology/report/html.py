"""Findings and plots to one HTML page that works offline under a strict Content-Security-Policy."""

from __future__ import annotations

import re
import unicodedata
from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError
from metrology.report import display, document, equations, fonts, wording

if TYPE_CHECKING:
    from jinja2 import Environment

    from metrology.findings import Findings
    from metrology.report.figures.style import Plot

STYLES = {"report.css": "all", "print.css": "print", "screen.css": "screen"}
"""Style sheet → the medium that it is for."""


@dataclass(frozen=True)
class Page:
    """The report as HTML whose pictures are addresses, ``plot:3``, and the pictures that they stand for."""

    text: str
    pictures: Mapping[str, Plot]


def render(findings: Findings, plots: Mapping[str, Plot], *, templates: Path | None = None) -> Page:
    """The report as one HTML page for the PDF, its pictures apart.

    Raises
    ------
    MetrologyError
        Where a template is missing, cannot be read, or asks for what is not there.
    """
    from jinja2 import TemplateError, TemplateNotFound, TemplateSyntaxError

    pictures: dict[str, Plot] = {}
    environment = _environment(templates, pictures)
    try:
        sheets = [(environment.loader.get_source(environment, name)[0], medium) for name, medium in STYLES.items()]  # type: ignore[union-attr]
        context = document.context(findings, plots)
        return Page(
            environment.get_template("report.html").render(context, sheets=sheets, policy=_policy(sheets)), pictures
        )
    except TemplateNotFound as error:
        raise _unusable(templates, f"no template {error.name}", "every template that another one includes") from error
    except TemplateSyntaxError as error:
        raise _unusable(templates, f"{error.name}:{error.lineno}: {error.message}", "Jinja's syntax") from error
    except (TemplateError, TypeError, AttributeError, UnicodeDecodeError) as error:
        raise _unusable(
            templates, f"{type(error).__name__}: {error}", "a template that uses what findings hold"
        ) from error


def standalone(page: Page) -> str:
    """The page as one file that works alone: pictures within, and the font, cut down to the characters used."""
    text = _PICTURE.sub(lambda match: _inline(page.pictures[match[1]], match[2]), page.text)
    faces = fonts.faces(text)
    policy = f"'sha256-{_digest(faces)}'"
    return text.replace("style-src ", f"style-src {policy} ", 1).replace("<style", f"<style>{faces}</style>\n<style", 1)


_PICTURE = re.compile(r'<img src="(plot:\d+)" alt="([^"]*)">')


def _inline(plot: Plot, alt: str) -> str:
    size = f'width="{plot.width:.2f}pt" height="{plot.height:.2f}pt"'
    return plot.svg.replace("<svg ", f'<svg role="img" aria-label="{alt}" {size} ', 1)


def folder() -> Path:
    """Our own templates: in the package where it is installed, beside it in a checkout."""
    package = Path(__file__).parents[1]
    inside = package / "templates"
    return inside if inside.is_dir() else package.parent / "templates"


def _environment(templates: Path | None, pictures: dict[str, Plot]) -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    if templates is not None and not templates.is_dir():
        raise _unusable(templates, "no such folder", "a folder with templates, such as a copy of ours")
    environment = Environment(
        loader=FileSystemLoader([*([templates] if templates else []), folder()]),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=visible,
        trim_blocks=True,
        lstrip_blocks=True,
    )

    def address(plot: Plot) -> str:
        """Keep a picture that the page asks for, and say where."""
        url = f"plot:{len(pictures)}"
        pictures[url] = plot
        return url

    environment.filters |= {
        "address": address,
        "aligned": display.aligned,
        "equation": equations.draw,
        "parted": equations.parted,
        "prose": wording.prose,
        "grouped": display.grouped,
        "number": display.number,
        "percent": display.percent,
        "symbol": symbol,
        "unit": display.unit_text,
    }
    return environment


def visible(value: Any) -> Any:
    """Text with codes for characters that the font lacks, or that would reorder or hide what stands around them."""
    if not isinstance(value, str) or hasattr(value, "__html__") or (value.isascii() and value.isprintable()):
        return value
    return "".join(f"⟨U+{ord(c):04X}⟩" if _needs_code(c) else c for c in value)


def _needs_code(character: str) -> bool:
    if character in "\n\t\r":
        return False
    return unicodedata.category(character) in {"Cc", "Cf", "Cs", "Co", "Cn"} or ord(character) not in fonts.characters()


def symbol(quantity: str) -> Any:
    """Symbol of a quantity in italics, with its index: ω_n → <i>ω</i><sub>n</sub>."""
    from markupsafe import Markup, escape

    stem, _, index = visible(display.symbol(quantity)).partition("_")
    tail = Markup("<sub>{}</sub>").format(escape(index)) if index else Markup("")
    return Markup("<i>{}</i>{}").format(escape(stem), tail)


def _policy(sheets: list[tuple[str, str]]) -> str:
    hashes = " ".join(f"'sha256-{_digest(sheet)}'" for sheet, _ in sheets)
    return f"default-src 'none'; img-src data:; font-src data:; style-src {hashes}; base-uri 'none'; form-action 'none'"


def _digest(text: str) -> str:
    return b64encode(sha256(text.encode()).digest()).decode("ascii")


def _unusable(templates: Path | None, got: str, expected: str) -> MetrologyError:
    where = str(templates or folder())
    return MetrologyError(
        Fault(where, got, expected, "correct the template, or remove it there: ours then takes its place")
    )
