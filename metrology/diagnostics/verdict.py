"""From what was judged to causes, tables and sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping

from metrology.diagnosis import Diagnosis, Gain
from metrology.diagnostics.judged import Judged
from metrology.diagnostics.refuted import refuted
from metrology.diagnostics.subject import Fit, Subject
from metrology.diagnostics.supported import supported
from metrology.diagnostics.verdict_causes import causes_of, separations
from metrology.diagnostics.verdict_sentences import sentence_of
from metrology.diagnostics.verdict_tables import detectable, parts_of, remainder_of, shifts_of, tests_of
from metrology.message import said


def failed(subject: Subject, test: str) -> Diagnosis:
    """Diagnosis of a base model that cannot be fitted."""
    sentence = said("The base model could not be fitted to these data: compare them with the stated model first.")
    return Diagnosis(
        subject.sample, subject.method, test, "not finished", sentence, (), (), {}, (), (), (), {},
        failures=(sentence,),
    )  # fmt: skip


def worded(judged: Judged, subject: Subject, gain: Mapping[str, Gain], test: str) -> Diagnosis:
    """Put what was judged, and the gain of the extension on blocks left out, into a `Diagnosis`."""
    extended = judged.is_extended
    causes = tuple(causes_of(judged, subject, gain))
    unexplained = judged.verdict in ("unexplained", "explained in the main")
    missing = subject.missing(judged.last) if unexplained else None
    before, after = (one.chi_squared / max(one.count, 1) for one in (judged.base, judged.last))
    joint = supported(judged, subject)
    groups = tuple(group for group in judged.groups if judged.is_named(group[0]) or len(group) == 1)
    model = dict(subject.extended(judged.last)) if extended else {}
    return Diagnosis(
        sample=subject.sample, method=subject.method, test=test, verdict=judged.verdict,
        sentence=sentence_of(judged, subject, causes), tests=tests_of(judged), causes=causes, gain=gain,
        residuals=parts_of(judged, subject), groups=groups, discriminating_tests=tuple(separations(judged, subject)),
        extended_model=model,
        detectable=tuple(detectable(judged, subject)), shifts=shifts_of(judged, joint), missing=missing,
        remainder=remainder_of(judged, subject), chi_squared=(before, after), failures=judged.failures,
        supported=joint, ranges=_ranges(judged.last, model),
        refuted=tuple(refuted(judged, subject.priors)) if extended else (),
    )  # fmt: skip


def _ranges(fit: Fit, model: Mapping[str, float]) -> dict[str, tuple[float | None, float | None]]:
    """Ranges of parameters of the extended model, where there is a limit."""
    ranges = {entry.name: (entry.low, entry.high) for entry in fit.problem.unknowns if entry.name in model}
    finite = {name: tuple(end if math.isfinite(end) else None for end in ends) for name, ends in ranges.items()}
    return {name: (low, high) for name, (low, high) in finite.items() if (low, high) != (None, None)}
