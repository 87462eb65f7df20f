"""Findings and plots to one HTML page that works offline under a strict Content-Security-Policy."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError
from metrology.language import catalogue, columns, display, done, wording
from metrology.method.discovery import templates as ours
from metrology.report import decimals, document, equations, fonts
from metrology.report.fonts import visible
from metrology.report.page_sheets import across, branded, running
from metrology.report.sides import Sides
from metrology.report.typesetting import sentence, symbol, worded
from metrology.units import unit_text

if TYPE_CHECKING:
    from jinja2 import Environment

    from metrology.findings import Findings
    from metrology.language.catalogue import Language
    from metrology.report.attachments import Attachment
    from metrology.report.figures.style import Plot

STYLES = {"report.css": "all", "print.css": "print", "screen.css": "screen"}
"""Style sheet → the medium that it is for."""

ZOOM_STYLE, SCRIPTS = "vendor/uPlot.min.css", ("vendor/uPlot.iife.min.js", "zoom.js", "page.js")
"""What the HTML needs: the last script always, to sort tables, fold chapters and let the contents follow the reader;
the others where plots can be zoomed."""
_SAID_BY = re.compile(r'\bsaid\("([^"]+)"')


@dataclass(frozen=True)
class Page:
    """The report as HTML whose pictures are addresses, ``plot:3``, and the pictures that they stand for.

    `style` is for plots that can be zoomed; empty where there is none. `scripts` go into the file for the screen alone.
    """

    text: str
    pictures: Mapping[str, Plot]
    style: str = ""
    scripts: tuple[str, ...] = ()


def render(
    findings: Findings,
    plots: Mapping[str, Plot],
    files: Sequence[Attachment] = (),
    *,
    templates: Path | None = None,
    allow_code: bool = False,
) -> Page:
    """The report as one HTML page for the PDF, its pictures apart; `files` are those that the PDF carries.

    Templates of the laboratory's own run in Jinja's sandbox unless `allow_code`: one from a stranger reaches nothing.

    Raises
    ------
    MetrologyError
        Where a template is missing, cannot be read, or asks for what is not there.
    """
    from jinja2 import TemplateError, TemplateNotFound, TemplateSyntaxError

    pictures: dict[str, Plot] = {}
    sides = Sides(catalogue.languages(findings))
    annex = Sides((sides.first,))
    names, numbered = done.called(findings, sides.first), Numbered(sides.first)
    own = wording.own_names(findings)
    environment, annexed = (_environment(templates, pictures, numbered, allow_code=allow_code) for _ in range(2))
    for one, said in ((environment, sides), (annexed, annex)):
        one.filters["opening"] = lambda text: wording.opening(text, own)
        one.filters["by_name"] = lambda text: wording.by_name(text, names)
        one.filters["plain_name"] = lambda text: wording.plain_name(text, sides.first.word)
        said.install(one, findings, sentence)
    decimals.install(annexed, sides.first)
    try:
        sheets = [(_source(environment, name), medium) for name, medium in STYLES.items()]
        sheets += [*running(sides.first), *across(findings, sides.first), *branded(findings)]
        context = document.context(findings, plots, files, sides.first)
        environment.globals["section"] = lambda name: decimals.cells(
            annexed.get_template(f"{name}.html").render(context), sides.first
        )
        scripts = tuple(_source(environment, name) for name in SCRIPTS)
        environment.globals["script_words"] = {
            **{message: sides.first.word(message) for script in scripts for message in said_by(script)},
            ".": sides.first.figures("0.1")[1],
        }
        text = environment.get_template("report.html").render(context, sheets=sheets, policy=policy(sheets))
        zooms = any(plot.series for plot in pictures.values())
        return Page(
            text, pictures, _source(environment, ZOOM_STYLE) if zooms else "", scripts if zooms else scripts[-1:]
        )
    except TemplateNotFound as error:
        raise _unusable(templates, f"no template {error.name}", "every template that another one includes") from error
    except TemplateSyntaxError as error:
        raise _unusable(templates, f"{error.name}:{error.lineno}: {error.message}", "Jinja's syntax") from error
    except (TemplateError, TypeError, AttributeError, UnicodeDecodeError) as error:
        raise _unusable(
            templates, f"{type(error).__name__}: {error}", "a template that uses what findings hold"
        ) from error
    except (ArithmeticError, LookupError, ValueError, RecursionError) as error:
        if templates is None:
            raise
        got = f"{type(error).__name__}: {error}"
        raise _unusable(templates, got, "a template whose expressions have a value") from error


def standalone(page: Page) -> str:
    """The page as one file that works alone: pictures within, and the font, cut down to the characters used."""
    text = _PICTURE.sub(lambda match: _inline(page.pictures[match[1]], match[2]), page.text)
    faces = fonts.faces(text)
    for sheet in filter(None, (page.style, faces)):
        text = text.replace("style-src ", f"style-src 'sha256-{digest(sheet)}' ", 1)
        text = text.replace("<style", f"<style>{sheet}</style>\n<style", 1)
    return _with_scripts(text, page.scripts)


def _with_scripts(text: str, scripts: tuple[str, ...]) -> str:
    """The page with scripts at its end, and a policy that lets these run and no others."""
    hashes = " ".join(f"'sha256-{digest(script)}'" for script in scripts)
    text = text.replace("; style-src ", f"; script-src {hashes}; style-src ", 1)
    elements = "".join(f"<script>{script}</script>\n" for script in scripts)
    head, tail = text.rsplit("</body>", 1)
    return f"{head}{elements}</body>{tail}"


class Numbered:
    """Numbers of figures and tables, given in the order in which the text first names them."""

    def __init__(self, language: Language) -> None:
        self._language = language
        self._figures: dict[str, int] = {}
        self._tables: dict[str, int] = {}

    def of_figure(self, key: str) -> int:
        """Number of a figure by its key."""
        return self._figures.setdefault(key, len(self._figures) + 1)

    def of_table(self, key: str) -> int:
        """Number of a table by its key."""
        return self._tables.setdefault(key, len(self._tables) + 1)

    def figure(self, key: str) -> Any:
        """``Figure 3``, on one line."""
        return f"{self._language.say('Figure')}\N{NO-BREAK SPACE}{self.of_figure(key)}"

    def table(self, key: str) -> Any:
        """``Table 3``, on one line."""
        return f"{self._language.say('Table')}\N{NO-BREAK SPACE}{self.of_table(key)}"


def said_by(script: str) -> list[str]:
    """Messages that a script says in the language of its page."""
    return _SAID_BY.findall(script)


_PICTURE = re.compile(r'<img src="(plot:\d+)" alt="([^"]*)">')


def _inline(plot: Plot, alt: str) -> str:
    size = f'width="{plot.width:.2f}pt" height="{plot.height:.2f}pt"'
    picture = plot.svg.replace("<svg ", f'<svg role="img" aria-label="{alt}" {size} ', 1)
    if not plot.series:
        return picture
    series = plot.series.replace("<", "\\u003c")
    return f'{picture}<script type="application/json" data-series>{series}</script>'


def _source(environment: Environment, name: str) -> str:
    return str(environment.loader.get_source(environment, name)[0])  # type: ignore[union-attr]


def _environment(
    templates: Path | None, pictures: dict[str, Plot], numbered: Numbered, *, allow_code: bool
) -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from jinja2.sandbox import SandboxedEnvironment

    if templates is not None and not templates.is_dir():
        raise _unusable(templates, "no such folder", "a folder with templates, such as a copy of ours")
    if templates is not None and not allow_code:
        _refuse_links(templates)
    kind = Environment if templates is None or allow_code else SandboxedEnvironment
    environment = kind(
        loader=FileSystemLoader([*([templates] if templates else []), ours()]),
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

    environment.globals |= {"fig": numbered.figure, "tab": numbered.table}
    environment.globals |= {"fig_number": numbered.of_figure, "tab_number": numbered.of_table}
    environment.tests["shown_in_figures"] = document.shown_in_figures
    environment.filters |= {
        "address": address,
        "aligned": columns.aligned,
        "chance": display.chance,
        "equation": equations.draw,
        "parted": equations.parted,
        "worded": worded,
        "prose": sentence,
        "signed": display.signed,
        "difference": wording.difference,
        "grouped": display.grouped,
        "normalised": display.normalised,
        "number": display.number,
        "p_value": display.p_value,
        "percent": display.percent,
        "symbol": symbol,
        "unit": unit_text,
    }
    return environment


def _refuse_links(templates: Path) -> None:
    """Refuse a folder in which a name leads elsewhere: what is included by it, such as a key, would be printed."""
    home = templates.resolve()
    for path in templates.rglob("*"):
        if not path.resolve().is_relative_to(home):
            raise _unusable(templates, f"{path.name}, a link that leads elsewhere", "plain files, or --allow-code")


def policy(sheets: list[tuple[str, str]]) -> str:
    """Return the Content-Security-Policy of a page with these style sheets and nothing from elsewhere."""
    hashes = " ".join(f"'sha256-{digest(sheet)}'" for sheet, _ in sheets)
    return f"default-src 'none'; img-src data:; font-src data:; style-src {hashes}; base-uri 'none'; form-action 'none'"


def digest(text: str) -> str:
    """Hash of a style sheet or a script, as a policy names it."""
    return b64encode(sha256(text.encode()).digest()).decode("ascii")


def _unusable(templates: Path | None, got: str, expected: str) -> MetrologyError:
    where = str(templates or ours())
    return MetrologyError(
        Fault(where, got, expected, "correct the template, or remove it there: ours then takes its place")
    )
