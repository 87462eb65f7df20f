"""The languages of a report as its templates use them: one, or two, of which the second stands beneath in grey."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from metrology.language import done, notices
from metrology.language.catalogue import Language
from metrology.report import quality
from metrology.report.fonts import visible
from metrology.report.limits import limits
from metrology.report.lines import whose

if TYPE_CHECKING:
    from jinja2 import Environment

    from metrology.findings import Findings
    from metrology.message import Value
    from metrology.report.consensus import Group
    from metrology.report.lines import Line


@dataclass(frozen=True)
class Sides:
    """One language or two; texts come out as markup with both, or alone where both are the same."""

    languages: tuple[Language, ...]

    @property
    def first(self) -> Language:
        """The language of the document."""
        return self.languages[0]

    def gettext(self, message: str) -> str:
        """A message of a template, which may hold markup of its own."""
        return self._paired([language.word(message) for language in self.languages])

    def ngettext(self, one: str, many: str, count: int) -> str:
        """A message of a template that depends on a count."""
        return self._paired([language.plural(one, many, count) for language in self.languages])

    def _paired(self, texts: Sequence[str]) -> str:
        if len(set(texts)) == 1:
            return texts[0]
        return f'{texts[0]}<span class="second" lang="{self.languages[1].code}">{texts[1]}</span>'

    def each(self, text: Callable[[Language], Any]) -> Any:
        """What a function says in each language, as markup."""
        texts = [text(language) for language in self.languages]
        if len(set(texts)) == 1:
            return texts[0]
        pair = Markup('{}<span class="second" lang="{}">{}</span>')
        return pair.format(visible(texts[0]), self.languages[1].code, visible(texts[1]))

    def word(self, text: str, context: str = "") -> Any:
        """A word of the findings, such as a verdict or the name of a quantity."""
        return self.each(lambda language: language.word(text, context))

    def say(self, message: str, /, **values: Value) -> Any:
        """A message with its values."""
        return self.each(lambda language: language.say(message, **values))

    def plain(self, message: str, /, **values: Value) -> str:
        """A message in the first language alone, for what is no part of the page: a title, a picture's description."""
        return self.first.say(message, **values)

    def install(self, environment: Environment, findings: Findings, sentence: Callable[[str], Any]) -> None:
        """Give the templates of a certificate what they say; `sentence` sets numbers and symbols in a text."""
        environment.add_extension("jinja2.ext.i18n")
        environment.policies["ext.i18n.trimmed"] = True
        environment.install_gettext_callables(  # type: ignore[attr-defined]
            self.gettext, self.ngettext, newstyle=True
        )
        for name in ("gettext", "ngettext"):
            environment.globals[name] = _with_visible(environment.globals[name])
        environment.filters |= {
            "word": self.word,
            "decimal": self.first.figures,
            "said": lambda text: self.each(lambda language: language.spoken(text)),
            "spoken": lambda text: self.each(lambda language: sentence(language.spoken(text))),
        }
        environment.globals |= {
            "plain": self.plain,
            "language": self.first.code,
            "conducted": self._rows(lambda language: done.sentences(findings, language)),
            "notices": self._rows(lambda language: notices.brief(findings, language)),
            "items_tested": self.each(lambda language: notices.items_tested(findings, language)),
            "state": self.each(lambda language: quality.stated(findings, language)),
            "described": lambda line: self.each(lambda language: described(line, language)),
            "agreed_by": lambda group: self.each(lambda language: agreed_by(group, language)),
            "rule": lambda entry: self.each(lambda language: quality.rule_name(entry, language)),
            "whose": lambda entry, lines: self.each(lambda language: whose(entry, lines, language)),
            "within": lambda entry: self.each(lambda language: limits(entry, language)),
            "tested": self._tested,
            "kind_of": lambda kind, code: self._in(code).word(kind, "notice"),
            "why": lambda reasons: self._why(reasons, findings, sentence),
        }

    def _rows(self, made: Callable[[Language], Sequence[Any]]) -> list[list[tuple[str, Any]]]:
        """Each entry of a list in each language, with the code of that language; once where both are the same."""
        versions = [[(language.code, one) for one in made(language)] for language in self.languages]
        return [list({text: (code, text) for code, text in row}.values()) for row in zip(*versions, strict=True)]

    def _in(self, code: str) -> Language:
        return next(language for language in self.languages if language.code == code)

    def _tested(self, dates: Sequence[str]) -> Any:
        """The day on which was tested, or the first and the last one."""
        return self.say("{first} to {last}", first=dates[0], last=dates[-1]) if len(dates) > 1 else "".join(dates)

    def _why(self, reasons: Sequence[str], findings: Findings, sentence: Callable[[str], Any]) -> Any:
        """Why a requirement is not judged."""
        from metrology.language.wording import by_name

        def text(language: Language) -> Any:
            return sentence(by_name(" ".join(map(language.quoted, reasons)), done.called(findings, language)))

        return self.each(text)


def _with_visible(translate: Any) -> Any:
    """The values of a message with codes for what the font lacks, as everything else that a template prints."""
    from jinja2 import pass_context

    @pass_context
    def translated(context: Any, *messages: Any, **values: Any) -> Any:
        return translate(context, *messages, **{name: visible(value) for name, value in values.items()})

    return translated


def described(line: Line, language: Language) -> str:
    """What a result is, and by which method: ``stiffness, elongation``."""
    words = (language.word(line.name), done.by_method(line.result, language), line.own)
    return ", ".join(word for word in words if word)


def agreed_by(group: Group, language: Language) -> str:
    """``stiffness, consensus of 2 results``."""
    count = language.count("consensus of {count} result", "consensus of {count} results", len(group.counted))
    return ", ".join(word for word in (language.word(group.word), count) if word)
