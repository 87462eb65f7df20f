"""What a campaign says of others' data and of its own assumptions, against the rest of the file."""

from __future__ import annotations

from pathlib import Path

import pytest

from metrology.campaign.load import load
from metrology.errors import MetrologyError

TEXT = """\
format: metrology-campaign/1
id: declared
title: Declared
{stated}
laboratory: {{name: Own House, address: "1 Street", contact: J. Doe, country: ZZ}}
{more}"""
REFERENCE = "samples: {line: {references: {E: {value: 69 GPa, source: handbook}}}}\n"
CALIBRATED = "instruments: {dial: {kind: dial, certificate: {number: C, laboratory: LAB, date: 2026-01-01}}}\n"


def read(folder: Path, stated: str, more: str):
    path = folder / "campaign.yaml"
    path.write_text(TEXT.format(stated=stated, more=more), encoding="utf-8")
    return load(path)


@pytest.mark.parametrize(
    ("more", "what"),
    [
        (REFERENCE, "a reference value of E for line"),
        (CALIBRATED.replace("LAB", "Calibration House"), "the calibration of dial by Calibration House"),
        ("reconstructed: after a paper\n", "reconstructed readings"),
    ],
)
def test_law_none_provided_beside_data_of_others_is_a_contradiction(more: str, what: str, tmp_path: Path):
    (notice,) = read(tmp_path, "provided: none", more).notices
    assert notice.startswith(f"provided: 'none', but the file states {what}. Name who provided")


@pytest.mark.parametrize(
    ("stated", "more"),
    [
        ("provided: none", ""),
        ("provided: none", CALIBRATED.replace("LAB", "Own House")),
        ("provided: [{what: modulus, by: handbook, role: external provider}]", REFERENCE),
        ("", REFERENCE),
    ],
)
def test_planted_nothing_what_agrees_needs_no_notice(stated: str, more: str, tmp_path: Path):
    assert read(tmp_path, stated, more).notices == ()


def test_refusal_an_assumption_that_excludes_an_unknown_effect(tmp_path: Path):
    with pytest.raises(MetrologyError) as refusal:
        read(tmp_path, "assumptions: [{text: nothing slips, excludes: [slipp]}]", "")
    (fault,) = refusal.value.faults
    assert "'slipp', an unknown effect" in str(fault)
    assert "did you mean 'slip'?" in str(fault)
