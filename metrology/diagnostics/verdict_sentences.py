"""Sentences of a diagnosis: what is missing, and what remains."""

from __future__ import annotations

from metrology.diagnosis import Cause
from metrology.diagnostics.fits import COARSE
from metrology.diagnostics.judged import FAR, LIKELY, Judged
from metrology.diagnostics.subject import Subject
from metrology.message import Sentence, counted, said

ANYTHING = "These data do not decide whether anything is missing; possible: {possible}; a law that is not listed."
WHAT = "Something is missing, but these data do not decide what; possible: {possible}; a law that is not listed."
MORE = {
    ANYTHING: "These data do not decide whether more is missing; possible: {possible}; a law that is not listed.",
    WHAT: "More is missing, but these data do not decide what; possible: {possible}; a law that is not listed.",
}
"""What is said in place of a sentence after another that names what is missing."""
EITHER = "one of {titles:comma}, which these data cannot distinguish"


def sentence_of(judged: Judged, subject: Subject, causes: tuple[Cause, ...]) -> str:
    """What is said of a diagnosis as a whole."""
    match judged.verdict:
        case "nothing missing" if judged.heavy > LIKELY:
            return said(
                "No listed effect is supported, but the noise is not normal: more readings lie far off than chance "
                "explains. Each may be misread, or the readings scatter so."
            )
        case "nothing missing":
            return said("Nothing is missing: no listed effect is supported, and what remains is noise.")
        case "not finished":
            return said(
                "Not finished: no model that was tried follows the motion, so that nothing is said of causes. Look "
                "at the readings, the start and the stated model first."
            )
        case _:
            pass
    named = _names(causes, judged)
    remainder = _rest(judged, subject)
    if judged.verdict == "unexplained":
        fits = tuple(_with_name(subject.candidates[name].title, name) for name in judged.replaced)
        if fits and judged.law is not None and judged.law.log_bayes < FAR and judged.misfit <= COARSE:
            one = "Something is missing: {effects:comma} would explain it, but so does a law that is not listed."
            many = (
                "Something is missing: {effects:comma} together would explain it, but so does a law that is not listed."
            )
            return followed(counted(one, many, len(fits), effects=fits), remainder)
        return followed(said("Something is missing that no listed effect explains."), remainder)
    missing = followed(said("Missing in the model: {what}.", what=named), remainder, _tails(judged)) if named else ""
    undecided = [group[0] for group in judged.groups if len(group) == 1]
    if not undecided:
        return missing
    possible = tuple(_with_name(subject.candidates[name].title, name) for name in undecided)
    words = said(WHAT if judged.is_certain else ANYTHING, possible=possible)
    return followed(missing, words) if missing else words


def followed(*sentences: str) -> str:
    """Sentences one after another: after what is missing, a doubt is whether more is."""
    first, *others = (one for one in sentences if one)
    others = [_more(one) for one in others]
    return said("{first} {others:space}", first=first, others=tuple(others)) if others else first


def _more(sentence: str) -> str:
    if isinstance(sentence, Sentence) and sentence.message in MORE:
        return said(MORE[sentence.message], **sentence.values)
    return sentence


def _with_name(title: str, name: str) -> str:
    """A title within a sentence, with its name in campaign files."""
    return said("{title:lowered} ({name})", title=title, name=name)


def _names(causes: tuple[Cause, ...], judged: Judged) -> tuple[str, ...]:
    titles = {one.effect: _with_name(one.title, one.effect) for one in causes}
    supported: list[str] = [titles[one.effect] for one in causes if one.verdict == "supported"]
    alike = {one.effect for one in causes if one.verdict == "indistinguishable"}
    supported += [said(EITHER, titles=tuple(titles[name] for name in group))
                  for group in judged.groups if len(group) > 1 and alike.issuperset(group)]  # fmt: skip
    return tuple(supported)


def _tails(judged: Judged) -> str:
    """That more readings are far off than the model with its effects leaves to chance; empty where that is not so."""
    text = (
        "In addition, the noise is not normal: more readings lie far off than chance explains. Each may be misread, or "
        "the readings scatter so."
    )
    return said(text) if judged.heavy > LIKELY else ""


def _rest(judged: Judged, subject: Subject) -> str:
    """What the listed effects do not explain, in a sentence or two; empty where they explain all."""
    law = judged.law if judged.law is not None and judged.unlisted > LIKELY else None
    if law is None:
        return _explained(judged, subject)
    unit = subject.unit_of(law.family)
    text = "What remains is described best by an unlisted law, {law} (RMS {size:.2g}{unit})."
    described = said(text, law=law_words(law.family), size=float(law.bent), unit="" if unit == "1" else f" {unit}")
    return followed(_explained(judged, subject), described)


def law_words(family: str) -> str:
    """What a family of laws is, ``force of powers of velocity``, in words of the catalogue."""
    base, differing, _ = family.partition(" that differs between repeats")
    if differing:
        return said("{law} that differs between repeats", law=law_words(base))
    what, of, rest = base.partition(" of ")
    if of:
        text = "powers of {of}" if what == "powers" else "{what} of {of}"
        return said(text, what=what, of=law_words(rest))
    first, both, second = base.partition(" and ")
    return said("{first} and {second}", first=first, second=second) if both else base


def _explained(judged: Judged, subject: Subject) -> str:
    """How much of the misfit is explained, by what besides the effects that are named."""
    shares = {"share": float(100 * judged.share), "left": float(100 * (1.0 - judged.share))}
    others = tuple(
        _with_name(subject.candidates[name].title, name) for name in judged.replaced if judged.verdict != "unexplained"
    )
    mainly = judged.verdict == "explained in the main"
    if others and mainly:
        text = (
            "Together with {others:comma}, in whose place an unlisted law does as well, this explains {share:.3g} % of "
            "the misfit; {left:.2g} % remains."
        )
        return said(text, others=others, **shares)
    if others:
        text = (
            "Together with {others:comma}, in whose place an unlisted law does as well, this explains all of the "
            "misfit."
        )
        return said(text, others=others)
    return said("This explains {share:.3g} % of the misfit; {left:.2g} % remains.", **shares) if mainly else ""
