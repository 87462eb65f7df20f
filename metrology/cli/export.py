"""`metrology export`: findings in the forms of other programs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from metrology.cli.campaigns import DONE, campaign_file
from metrology.errors import MetrologyError
from metrology.export.forms import FORMS, write

if TYPE_CHECKING:
    from metrology.findings import Findings


def add(commands: Any) -> None:
    """Declare the command."""
    parser = commands.add_parser("export", help="write results in the form of other programs")
    forms = parser.add_subparsers(required=True, metavar="FORM")
    dcc = forms.add_parser("dcc", help="a digital calibration certificate, PTB's DCC 3 with D-SI")
    dcc.add_argument("file", type=Path, metavar="FILE", help="campaign.yaml, its folder, or a results.json")
    dcc.add_argument("--schema", type=Path, metavar="FOLDER", help="validate against the schemas (.xsd) below a folder")
    dcc.add_argument("--output", type=Path, metavar="FILE", help="where to write it (default: stdout)")
    dcc.set_defaults(command=export_dcc)
    for name, made in FORMS.items():
        form = forms.add_parser(name, help=made.title)
        form.add_argument("file", type=Path, metavar="FILE", help="campaign.yaml, its folder, or a results.json")
        used = "a result by its full name, such as pull.k, where several give one quantity (may be repeated)"
        form.add_argument("--use", action="append", default=[], metavar="RESULT", help=used)
        where = "the file (default: stdout)" if made.alone else "the folder"
        form.add_argument("--output", type=Path, metavar="PATH", required=not made.alone, help=where)
        form.set_defaults(command=export_form, form=name)


def export_form(options: argparse.Namespace) -> int:
    """Write results in a form that simulations and other estimators read."""
    findings = findings_of(options.file)
    if options.output is None:
        sys.stdout.buffer.write(FORMS[options.form](findings, options.use))  # type: ignore[arg-type]
    else:
        write(options.form, findings, options.output, use=options.use)
    return DONE


def export_dcc(options: argparse.Namespace) -> int:
    """Write a digital calibration certificate; where it departs from the schemas, write nothing and say where."""
    from metrology.export import dcc, validation
    from metrology.report import recorded, staging

    findings = findings_of(options.file)
    if options.schema is None:
        document = dcc.certificate(findings)
    else:
        schemas = validation.find(options.schema)
        document = dcc.certificate(findings, version=schemas.version or dcc.VERSION)
        if wrong := validation.faults(document, schemas, "dcc"):
            raise MetrologyError(*wrong)
    if options.output is None:
        sys.stdout.buffer.write(document)
    else:
        staging.replace_file(options.output, document)
    if options.file.suffix == ".json":
        recorded.add(options.file.parent, "export", {f"{findings.campaign.id}.xml": document})
    return DONE


def findings_of(path: Path) -> Findings:
    """Return the findings of a `results.json`, or those of a campaign, which is evaluated.

    Raises
    ------
    MetrologyError
        For a file that cannot be read as either, and for results that were changed since they were written.
    """
    if path.suffix != ".json":
        from metrology import chain
        from metrology.campaign.load import load

        return chain.evaluate(load(campaign_file(path)))
    from metrology.export import kept

    return kept.findings(path)
