"""Sentences as the report prints them: numbers in the display unit, powers of ten and signs as a typesetter would."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from decimal import Decimal
from typing import TYPE_CHECKING

from metrology.language.display import LEAST, TINY, chance, grouped, number
from metrology.units import raised, unit_text

if TYPE_CHECKING:
    from metrology.findings import Findings, Result
    from metrology.language.catalogue import Language

_CLAUSE = "(JCGM 101, clause 8)."
_POWER = re.compile(r"(?<![\w.])([-+−]?\d+(?:\.\d+)?)[eE]([-+]?)0*(\d+)(?!\w)")
_SIGN = re.compile(r"(?<![\w.])-(?=\d+(?:\.\d+)?(?![\w-]*[-.]\w))")
_P_VALUE = re.compile(r"\bp = (\d+(?:\.\d+)?(?:e[-+]?\d+)?)(?![\w])")
_PROBABILITY = re.compile(r"(\bprobability (?:is |of )?)(\d+(?:\.\d+)?(?:e[-+]?\d+)?)(?![\w.])")
_CONFORMING = re.compile(r"(\bconforming all the same is )(\d+(?:\.\d+)?)(?![\d×]|\.\d| ?%)")
_LONG = re.compile(r"(?<![\w.])\d+\.\d{9,}(?![\w.])")
_FAR = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?) (standard (?:deviations|uncertainties))")
_NOTHING = re.compile(r"(?<![\w.])[-+−](0(?:\.0+)?)(?![\w.,])")
MOST = 100
"""Standard deviations beyond which the number of them says no more."""
_TRIALS = re.compile(r"\b\d{4,}(?= trials\b)")


def prose(text: str) -> str:
    r"""A sentence with numbers as they are printed.

    Examples
    --------
    >>> prose("the probability is 3.2e-20, E_n = -1.50, 57% of u², -0.00 %, 0.30000000000000004 m")
    'the probability is < 10⁻⁶, E_n = −1.50, 57 % of u², 0.00 %, 0.3 m'
    >>> prose("the probability that it is not conforming all the same is 0.085.")
    'the probability that it is not conforming all the same is 8.5 %.'
    >>> prose("1832 standard deviations, 4.2e-05 N")
    'more than 100 standard deviations, 4.2×10⁻⁵ N'
    >>> prose("it is 43.6 standard deviations (p = 0, limit 3.4), over 1000000 trials")
    'it is 43.6 standard deviations (p < 10⁻⁶, limit 3.4), over 1\xa0000\xa0000 trials'
    """
    text = _P_VALUE.sub(lambda m: f"p {TINY}" if float(m[1]) < LEAST else m[0], text)
    text = _PROBABILITY.sub(lambda m: m[1] + TINY if float(m[2]) < LEAST else m[0], text)
    # As in the table of the verdicts.
    text = _CONFORMING.sub(lambda m: m[1] + _in_percent(m[2]), text) if "all the same is" in text else text
    text = _LONG.sub(lambda m: f"{float(m[0]):.6g}", text)
    text = _FAR.sub(lambda m: f"more than {MOST} {m[2]}" if float(m[1]) > MOST else m[0], text)
    text = _NOTHING.sub(r"\1", text)
    text = _TRIALS.sub(lambda m: grouped(int(m[0])), text)
    text = _POWER.sub(lambda m: f"{m[1]}×10{raised(m[2].replace('+', '') + m[3])}", text)
    return _SIGN.sub("−", re.sub(r"(\d)%", r"\1 %", text))


def _in_percent(text: str) -> str:
    """A probability of a sentence as a percentage with the digits that the sentence has, and no further one."""
    if not 1e-4 <= float(text) < 0.9995:
        return chance(float(text))
    return f"{Decimal(text).scaleb(2):f} %"


def by_name(sentence: str, names: Mapping[str, str]) -> str:
    """A sentence with tests called as its reader knows them, not as the campaign file does."""
    for test, name in names.items():
        sentence = re.sub(rf"(?<![\w.-]){re.escape(test)}(?![\w-]|\.\w)", name, sentence)
    return sentence


PLAIN = {
    "mass.factor": "mass (factor)", "free_length.shift": "free length (shift)", "thrust.gain": "thrust (gain)",
    "cell.gain": "load cell (gain)", "cell.zero": "load cell (zero)", "clock.x": "delay of the position channel",
    "clock.v": "delay of the velocity channel", "clock.T": "delay of the force channel", "start.x": "initial position",
    "start.v": "initial velocity", "friction.force": "friction force",
}  # fmt: skip
"""Parameters by their names in campaign and results files → what a reader calls them."""
_PARAMETER = re.compile(rf"(?<![\w])(?:{'|'.join(map(re.escape, PLAIN))})(?![\w])")


def plain_name(text: str, word: Callable[[str], str] = str) -> str:
    """A text with parameters called as its reader knows them; `word` says their names in another language.

    Examples
    --------
    >>> plain_name("nylon-response.clock.T"), plain_name("cell.zero")
    ('nylon-response.delay of the force channel', 'load cell (zero)')
    """
    return _PARAMETER.sub(lambda found: word(PLAIN[found[0]]), text)


def difference(text: str) -> str:
    """A difference with its share: ``-0.0 % (-0.04%)`` → ``0.0 % (−0.04 %)``; no zero has a sign."""
    return prose(re.sub(r"[-+−](0(?:\.0+)?)(?![\d.])", r"\1", text))


def opening(text: str, names: Collection[str] = ()) -> str:
    """A sentence with a capital letter at its beginning, unless that is a symbol or one of the campaign's own `names`.

    Examples
    --------
    >>> opening("an outlier"), opening("k of the tape"), opening("ind: not calibrated.", {"ind"})
    ('An outlier', 'k of the tape', 'ind: not calibrated.')
    """
    if any(text.startswith(name) and not re.match(r"[\w-]", text[len(name) :]) for name in names):
        return text
    return text[:1].upper() + text[1:] if text[1:2].isalpha() or text[:2] == "a " else text


def verdict(result: Result, language: Language | None = None) -> str:
    """What clause 8 of JCGM 101 says of the law of propagation, in the result's display unit."""
    from metrology.language.catalogue import ENGLISH
    from metrology.units import factor

    trials, language = result.monte_carlo, language or ENGLISH
    head, _, tail = trials.verdict.partition(_CLAUSE)
    judged, _, reason = head.partition(": its interval differs")
    if judged not in _JUDGED or not reason or trials.d_low is None or trials.d_high is None:
        return prose(language.spoken(trials.verdict))
    size, unit = factor(result.display_unit), unit_text(result.display_unit)
    low, high, limit = (
        f"{number(value / size, digits)} {unit}".rstrip()
        for value, digits in ((trials.d_low, 2), (trials.d_high, 2), (trials.tolerance, 1))
    )
    made = language.messages.get(trials.verdict)
    if made is not None and made.message == "{texts:space}":
        rest = made.values["texts"][1:]  # type: ignore[index]
    else:
        rest = (tail.replace(" The Monte Carlo interval holds.", "").strip(),)
    further = " ".join(prose(language.spoken(one)) for one in rest)
    return " ".join(filter(None, (language.say(_JUDGED[judged], low=low, high=high, limit=limit), further)))


def own_names(findings: Findings) -> frozenset[str]:
    """Names that the campaign gives: none of them is changed."""
    named = (
        *(item.id for item in findings.instruments),
        *(name for one in findings.samples for name in (one.id, one.name)),
        *(one.id for one in findings.tests),
        *(name for one in findings.results for name in (one.name, one.quantity)),
        *(row.input for one in findings.results for row in one.budget),
        *(one.name for one in findings.fits),
        *(entry.requirement for entry in findings.conformity),
        *findings.unjudged,
    )
    return frozenset(filter(None, named))


_JUDGED = {
    "The GUM uncertainty framework is confirmed":
        "The GUM uncertainty framework is confirmed (JCGM 101, clause 8): its interval differs from the Monte "
        "Carlo one by {low:figures} below and {high:figures} above; the tolerance is δ = {limit:figures}.",
    "The GUM uncertainty framework is not confirmed":
        "The GUM uncertainty framework is not confirmed (JCGM 101, clause 8): its interval differs from the Monte "
        "Carlo one by {low:figures} below and {high:figures} above; the tolerance is δ = {limit:figures}.",
    "The GUM uncertainty framework is not contradicted":
        "The GUM uncertainty framework is not contradicted (JCGM 101, clause 8): its interval differs from the Monte "
        "Carlo one by {low:figures} below and {high:figures} above; the tolerance is δ = {limit:figures}.",
}  # fmt: skip
"""How clause 8 judges → the sentence in the display unit."""
