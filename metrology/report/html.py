"""Findings and plots to one HTML page that works offline under a strict Content-Security-Policy."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology import checklist
from metrology.errors import Fault, MetrologyError
from metrology.language import catalogue, display, done, wording
from metrology.method.discovery import templates as ours
from metrology.report import decimals, document, equations, fonts, watermark
from metrology.report.fonts import visible
from metrology.report.sides import Sides
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
        "aligned": display.aligned,
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


def symbol(quantity: str) -> Any:
    """Symbol of a quantity in italics, with its index: ω_n → <i>ω</i><sub>n</sub>."""
    from markupsafe import Markup, escape

    stem, _, index = visible(display.symbol(quantity)).partition("_")
    tail = Markup("<sub>{}</sub>").format(escape(index)) if index else Markup("")
    return Markup("<i>{}</i>{}").format(escape(stem), tail)


def worded(text: str) -> Any:
    """Words about an equation with its symbols set: e = x − x_t → <i>e</i> = <i>x</i> − <i>x</i><sub>t</sub>."""
    from markupsafe import Markup, escape

    text, pieces, last = visible(text), [], 0
    for found in equations.SYMBOL.finditer(text):
        pieces += [escape(text[last : found.start()]), _italic(found)]
        last = found.end()
    return Markup("").join([*pieces, escape(text[last:])])


def _italic(found: re.Match[str]) -> Any:
    """Markup of a symbol; two letters without an index may be a word, unless the first is a delta."""
    from markupsafe import Markup, escape

    stem, index = found["stem"], found["index"]
    if not stem or (stem.isalpha() and len(stem) > 1 and stem[0] not in "δΔ" and not index):
        return escape(found[0])
    tail = Markup("<sub>{}</sub>").format(index) if index else Markup("")
    return Markup("<i>{}</i>{}").format(stem, tail)


_NUMBER = r"\d+(?:[.,]\d+)*(?:×10[⁻⁰¹²³⁴-⁹]+)?"
_SHORT = r"[^\W\d_](?:[^\W\d_]|⁻){0,2}"
_UNIT = rf"(?:[%‰]|°C|[^\W\d_][\w·⁻]*/[^\W\d_][\w·]*|{_SHORT}(?:·{_SHORT})*(?!\w|[·.]\w))"
_SET = re.compile(
    r"(?<![\w.-])(?P<stem>u|E|F|R|ε|eps|ω|k|x|φ)_(?P<index>val|n|c|d|dyn|t|0|inf|∞|max|m|b)(?![\w.-]*\w)"
    rf"|(?P<whole>(?<![\d.,]){_NUMBER}(?: ± {_NUMBER})? {_UNIT})"
)
"""Symbols with an index that the sentences of methods and verdicts use, a name such as ``x_t.csv`` being none; a value,
with its u, and its unit: a line would break before it and after its stroke. So are a number and a short word."""


def sentence(text: str) -> Any:
    """A sentence with numbers as they are printed, and its symbols with an index set: u_val → <i>u</i><sub>val</sub>.

    A value stays on one line with its unit. For what is no part of an equation; `worded` sets more, and takes a word of
    two letters for a symbol.
    """
    from markupsafe import Markup, escape

    text, pieces, last = visible(wording.prose(text)), [], 0
    for found in _SET.finditer(text):
        piece = Markup('<span class="one">{}</span>').format(found["whole"]) if found["whole"] else symbol(found[0])
        pieces += [escape(text[last : found.start()]), piece]
        last = found.end()
    return Markup("").join([*pieces, escape(text[last:])])


def running(language: Language) -> list[tuple[str, str]]:
    """Sheet with the words at the head and the foot of each page, where they are not English."""
    if language.code == "en":
        return []
    words = {
        "top-right": _content(language, "Test report {number}"),
        "bottom-left": _content(language, "The results relate only to the items tested."),
        "bottom-right": _content(language, "Page {page} of {pages}"),
    }
    boxes = " ".join(f"@{place} {{ content: {text} }}" for place, text in words.items())
    draft = _content(language, "DRAFT of test report {number}")
    return [(f"@page {{ {boxes} }}\n@page draft {{ @top-right {{ content: {draft} }} }}", "print")]


def across(findings: Findings, language: Language) -> list[tuple[str, str]]:
    """Sheet with the word across the pages of a draft."""
    if not checklist.lacking(findings):
        return []
    picture = watermark.address(language.say("DRAFT"))
    return [(f"@page draft {{ background: url({picture}) center / 100% 100% no-repeat }}", "print")]


_COUNTED = {"number": "string(number)", "page": "counter(page)", "pages": "counter(pages)"}


def _content(language: Language, message: str) -> str:
    """A message as the content of a box at the edge of a page."""
    marked = language.say(message, **{name: f"\0{name}\0" for name in _COUNTED})
    pieces = [_COUNTED[piece] if at % 2 else _quoted(piece) for at, piece in enumerate(marked.split("\0"))]
    return " ".join(pieces)


def _quoted(text: str) -> str:
    """A text as a string of a style sheet."""
    return '"' + "".join(f"\\{ord(letter):06x}" for letter in text) + '"'


def branded(findings: Findings) -> list[tuple[str, str]]:
    """Sheets with the laboratory's colour, on light pages and on paper, and with its words at the foot of a page."""
    brand, sheets = findings.campaign.brand, []
    if brand is not None and brand.colour:
        heads = f"h1, h2, h3, h4, h5, .laboratory strong {{ color: {brand.colour}; }}"
        text = f"{heads}\nh2, .conclusion {{ border-color: {brand.colour}; }}"
        sheets = [(text, "print"), (text, "screen and (prefers-color-scheme: light)")]
    if brand is not None and brand.footer:
        words = _quoted(visible(brand.footer))
        boxes = f"@bottom-center {{ content: {words}; width: 38%; {_FOOT} }} @bottom-left {{ width: 42%; }}"
        sheets.append((f"@page {{ {boxes} @bottom-right {{ width: 20%; }} }}", "print"))
    return sheets


_FOOT = "font: 6.8pt Report, 'DejaVu Sans'; color: #59616b; text-align: center"


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
