"""What a campaign declares, as the report shows it: identification, samples, instruments, tests."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from datetime import date
from typing import TYPE_CHECKING, Literal

from metrology.checklist.record import Demand, Record
from metrology.findings import (
    Anomaly,
    Assumption,
    CampaignItem,
    Document,
    InputFile,
    InstrumentState,
    Opinion,
    Party,
    Provided,
    Replaced,
    SampleItem,
    Signatory,
    TestItem,
)
from metrology.gum.printed_probability import probability
from metrology.gum.rounding import significant
from metrology.identification import Brand, Image
from metrology.message import said
from metrology.methods import METHODS
from metrology.units import convert

if TYPE_CHECKING:
    from metrology.campaign.schema import Campaign
    from metrology.declaration.conduct import Exclusion, Test
    from metrology.declaration.declared import Assumption as StatedAssumption
    from metrology.declaration.identity import Instrument
    from metrology.declaration.identity import Party as StatedParty
    from metrology.declaration.quantity import Stated
    from metrology.declaration.samples import Sample
    from metrology.diagnosis import Diagnosis

LISTS = ("provided", "deviations", "opinions", "anomalies", "assumptions", "documents")
"""Lists of a campaign that can be stated to be empty."""


def stated_text(stated: Stated) -> str:
    """Return a quantity as the report prints it: value ± standard uncertainty, with unit."""
    value, unit = convert(stated.si, stated.unit), "" if stated.unit == "1" else f" {stated.unit}"
    if stated.u == 0:
        return f"{value:.{max(stated.quantity.digits, 0)}f}{unit}"
    return " ± ".join(significant(value, stated.u / stated.quantity.factor)) + unit


def input_files(campaign: Campaign) -> tuple[InputFile, ...]:
    """Every file that went in; the campaign file is attached whatever its size."""
    most = campaign.report.attach_up_to
    return tuple(
        InputFile(file.path, file.sha256, file.bytes, not index or most is None or file.bytes <= most << 20)
        for index, file in enumerate(campaign.files)
    )


def campaign_item(campaign: Campaign, diagnosis: Sequence[Diagnosis] = ()) -> CampaignItem:
    """Return the identification of the campaign and its report; a diagnosis may refute what it assumes."""
    return CampaignItem(
        id=campaign.id,
        title=campaign.title,
        report_number=campaign.report.number,
        issued=_day(campaign.report.issued),
        laboratory=_party(campaign.laboratory),
        customer=_party(campaign.customer),
        reconstructed=campaign.reconstructed,
        remarks=campaign.report.remarks,
        authorised_by=campaign.report.authorised_by,
        probability=campaign.coverage_probability,
        deviations=tuple(campaign.deviations or ()),
        checklists=campaign.report.checklists,
        replaces=_replaced(campaign),
        purpose=campaign.purpose,
        place=campaign.place,
        sampling=campaign.sampling,
        provided=tuple(Provided(entry.what, entry.by, entry.role) for entry in campaign.provided or ()),
        opinions=tuple(Opinion(entry.text, entry.by, entry.basis) for entry in campaign.opinions or ()),
        anomalies=tuple(Anomaly(a.id, a.text, a.state, a.disposition) for a in campaign.anomalies or ()),
        assumptions=tuple(Assumption(a.text, _refuted(a, diagnosis)) for a in campaign.assumptions or ()),
        documents=tuple(Document(d.number, d.title, d.edition, d.role) for d in campaign.documents or ()),
        stated=tuple(key for key in LISTS if getattr(campaign, key) is not None),
        signatures=_signatories(campaign),
        parts=campaign.report.parts,
        languages=campaign.report.language,
        decimal_sign=campaign.report.decimal_sign,
        brand=_brand(campaign),
    )


def _brand(campaign: Campaign) -> Brand | None:
    stated = campaign.branding
    if stated is None:
        return None
    accredited = stated.accreditation
    return Brand(
        logo=_image(campaign, stated.logo),
        colour=stated.colour or "",
        letterhead=stated.letterhead,
        mark=None if accredited is None else _image(campaign, accredited.mark),
        body="" if accredited is None else accredited.body,
        number="" if accredited is None else accredited.number,
        footer=stated.footer,
    )


def _image(campaign: Campaign, name: str | None) -> Image | None:
    return None if name is None else Image(name, b64encode(campaign.look[name]).decode("ascii"))


def _refuted(assumption: StatedAssumption, diagnosis: Sequence[Diagnosis]) -> str:
    """What a diagnosis found although the assumption excludes it."""
    text = "{title}, probability {chance:figures}, in {test}"
    found = tuple(
        said(text, title=cause.title, chance=probability(cause.probability), test=one.test)
        for one in diagnosis
        for cause in one.causes
        if cause.effect in set(one.named) & set(assumption.excludes)
    )
    return said("{texts}", texts=found) if found else ""


def _signatories(campaign: Campaign) -> tuple[Signatory, ...]:
    named = campaign.report.signatures.in_order() if campaign.report.signatures else ()
    return tuple(Signatory(role, person.name, person.function) for role, person in named)


def _replaced(campaign: Campaign) -> Replaced | None:
    older = campaign.report.replaces
    return Replaced(older.number, older.date.isoformat(), older.reason) if older else None


def sample_items(campaign: Campaign) -> tuple[SampleItem, ...]:
    """Return every sample as it is identified."""
    return tuple(_sample_item(name, sample) for name, sample in campaign.samples.items())


def _sample_item(name: str, sample: Sample) -> SampleItem:
    properties = {key: stated_text(stated) for key, stated in sample.properties.items()}
    length, density = properties.pop("length", ""), properties.pop("linear_density", "")
    shape = sample.section.shape if sample.section else ""
    sizes = (said("{what} {value:figures}", what=key, value=text) for key, text in properties.items())
    section = said("{parts:comma}", parts=(shape, *sizes)) if shape else ""
    references = tuple(
        f"{quantity} = {stated_text(value)}" + (f" ({value.source})" if value.source else "")
        for quantity, value in sample.references.items()
    )
    return SampleItem(
        id=name,
        name=sample.name or name,
        material=sample.material,
        batch=sample.batch,
        condition=sample.condition,
        configuration=sample.configuration,
        received=_day(sample.received),
        section=section,
        length=length,
        linear_density=density,
        references=references,
    )


def instrument_states(campaign: Campaign) -> tuple[InstrumentState, ...]:
    """Return every instrument with the state of its calibration on the dates of the tests that used it."""
    return tuple(
        _instrument_state(name, instrument, users(campaign, name)) for name, instrument in campaign.instruments.items()
    )


def users(campaign: Campaign, instrument: str) -> dict[str, date | None]:
    """Return the tests that used an instrument, with their dates."""
    return {name: test.date for name, test in campaign.tests.items() if instrument in roles(test).values()}


def roles(test: Test) -> Mapping[str, str]:
    """Return the instruments of a test by what they do."""
    return {role: name for role, name in dict(test.instruments).items() if name}


def _instrument_state(name: str, instrument: Instrument, used: Mapping[str, date | None]) -> InstrumentState:
    certificate = instrument.certificate
    state, sentence = _calibration(instrument, used)
    stated = certificate.expanded_uncertainty if certificate else None
    return InstrumentState(
        id=name,
        kind=instrument.kind,
        model=" ".join(filter(None, (instrument.manufacturer, instrument.model, instrument.class_))),
        serial=instrument.serial,
        range=_range(instrument),
        resolution=stated_text(instrument.resolution) if instrument.resolution else "",
        certificate=", ".join(filter(None, (certificate.number, certificate.laboratory))) if certificate else "",
        calibrated=_day(certificate.date) if certificate else "",
        due=_day(certificate.due) if certificate else "",
        uncertainty=f"U = {stated_text(stated)}, k = {certificate.k:g}" if certificate and stated else "",
        state=state,
        used_by=tuple(used),
        sentence=sentence,
    )


def _range(instrument: Instrument) -> str:
    if not instrument.range:
        return ""
    low, high = map(stated_text, instrument.range)
    return said("{low:figures} to {high:figures}", low=low, high=high)


def _calibration(
    instrument: Instrument, used: Mapping[str, date | None]
) -> tuple[Literal["valid", "overdue", "not calibrated", "not judged"], str]:
    certificate = instrument.certificate
    if certificate is None:
        return "not calibrated", said("no certificate is declared")
    dated = {name: day for name, day in used.items() if day is not None}
    early = [name for name, day in dated.items() if day < certificate.date]
    late = [name for name, day in dated.items() if certificate.due is not None and day > certificate.due]
    if late:
        return "overdue", said(
            "calibration was due on {day}, before {tests:comma}", day=str(certificate.due), tests=tuple(late)
        )
    if early:
        return "not calibrated", said(
            "calibrated on {day}, after {tests:comma}", day=str(certificate.date), tests=tuple(early)
        )
    if undated := [name for name in used if name not in dated]:
        text = "no date is stated for {tests:comma}, to hold against the certificate's"
        return "not judged", said(text, tests=tuple(undated))
    return "valid", ""


def test_items(campaign: Campaign) -> tuple[TestItem, ...]:
    """Return every test as it was carried out, without its findings."""
    return tuple(_test_item(campaign, name, test) for name, test in campaign.tests.items())


test_items.__test__ = False  # type: ignore[attr-defined]


def _test_item(campaign: Campaign, name: str, test: Test) -> TestItem:
    method = METHODS[test.method]
    sample = campaign.samples[test.sample].name or test.sample
    conditions = {key: stated_text(value) for key, value in dict(test.environment).items() if value is not None}
    return TestItem(
        id=name,
        method=test.method,
        title=test.title or f"{test.kind.capitalize() or method.title}: {sample}",
        standard="; ".join(filter(None, (test.procedure, method.standard))),
        sample=test.sample,
        date=_day(test.date),
        operator=test.operator,
        environment=tuple(said("{what} {value:figures}", what=key, value=text) for key, text in conditions.items()),
        instruments=tuple(roles(test).values()),
        deviations=tuple(test.deviations or ()),
        deviations_stated=test.deviations is not None,
        procedure=test.procedure,
        specification=test.specification,
        as_run=test.as_run,
        setup=test.setup,
        exclusions=tuple(_excluded(exclusion, method.whole) for exclusion in test.exclusions),
    )


def record(campaign: Campaign) -> Record:
    """Return what a checklist looks at, without evaluating anything."""
    demands = (
        Demand(entry.id, entry.source, _day(entry.decision.agreed), entry.close_out) for entry in campaign.requirements
    )
    declared = bool(campaign.tests or campaign.derived or campaign.fits)
    return Record(campaign_item(campaign), sample_items(campaign), test_items(campaign), tuple(demands), declared)


def _party(party: StatedParty | None) -> Party:
    return Party(party.name, party.address, party.contact, party.country) if party else Party("")


def _day(day: date | None) -> str:
    return day.isoformat() if day else ""


_WHOLE = {"release": "the whole release", "specimen": "the whole specimen"}
"""What is left out where no line is named."""


def _excluded(exclusion: Exclusion, whole: str) -> str:
    """What was left out, and why."""
    what = said(_WHOLE[whole]) if whole in _WHOLE else f"the whole {whole}"
    if exclusion.line is not None:
        what = said("line {line}", line=exclusion.line)
    if exclusion.file:
        what = said("{file}, {what}", file=exclusion.file, what=what)
    return said("{what}: {why}", what=what, why=exclusion.reason)
