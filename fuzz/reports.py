"""Small reports to start the fuzzing of the PDF reader from: unsigned, signed by one, signed by both, cut short."""

from __future__ import annotations

import zlib
from pathlib import Path
from tempfile import TemporaryDirectory

from metrology import chain, signoff
from metrology.campaign.load import load
from metrology.findings import to_json

ROLES = ("author", "reviewer")
CAMPAIGN = """\
format: metrology-campaign/1
id: oil
title: Oil
report:
  checklists: []
  signatures: {author: {name: A, function: a}, reviewer: {name: B, function: b}}
monte_carlo: {digits: 1, max_trials: 10000}
quantities:
  nu: {value: 13.6 mm^2/s, uncertainty: [{standard: 1.8 mm^2/s}]}
derived:
  - {quantity: viscosity, expression: nu, unit: mm^2/s}
"""


def unsigned() -> bytes:
    """A PDF of one empty page with the attachment that sign-off needs: a report of ours is too large to be mutated."""
    with TemporaryDirectory() as name:
        campaign = Path(name) / "campaign.yaml"
        campaign.write_text(CAMPAIGN, encoding="utf-8")
        packed = zlib.compress(to_json(chain.evaluate(load(campaign))))
    tree = b"<</Names[(results.json)<</Type/Filespec/F(results.json)/UF(results.json)/EF<</F 2 0 R>>>>]>>"
    bodies = [
        b"<</Type/Catalog/Pages 3 0 R/Names<</EmbeddedFiles" + tree + b">>>>",
        b"<</Type/EmbeddedFile/Filter/FlateDecode/Length %d>>\nstream\n" % len(packed) + packed + b"\nendstream",
        b"<</Type/Pages/Kids[4 0 R]/Count 1>>",
        b"<</Type/Page/Parent 3 0 R/MediaBox[0 0 9 9]/Resources<<>>>>",
    ]
    content, places = b"%PDF-1.7\n", []
    for number, body in enumerate(bodies, start=1):
        places.append(b"%010d 00000 n \n" % len(content))
        content += b"%d 0 obj\n" % number + body + b"\nendobj\n"
    table = b"xref\n0 5\n0000000000 65535 f \n" + b"".join(places)
    return content + table + b"trailer\n<</Size 5/Root 1 0 R>>\nstartxref\n%d\n%%%%EOF\n" % len(content)


def seeds() -> list[bytes]:
    """The report in each of its states, and each cut within its last part."""
    found = [unsigned()]
    with TemporaryDirectory() as name:
        report, keys = Path(name) / "report.pdf", Path(name) / "keys"
        report.write_bytes(found[0])
        signoff.create_authority(keys)
        for role in ROLES:
            signoff.sign(report, role, signoff.from_file(keys / f"{role}.p12", None, lambda: b"test"))
            found.append(report.read_bytes())
    return found + [content[: len(content) - cut] for content in found for cut in (7, 300)]
