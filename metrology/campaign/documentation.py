"""The documentation of campaign files, generated from the schema so that it cannot drift: `docs/campaign.md`."""

from __future__ import annotations

from metrology.campaign import diagnosis, judgement
from metrology.campaign.entry_tables import tables
from metrology.campaign.schema import Campaign
from metrology.declaration import branding, component, conduct, declared, fits, identity, quantity, readings, signatures
from metrology.declaration.component import BOUNDED, WIDTHS
from metrology.declaration.ensembles import Ensemble
from metrology.declaration.entry import Entry
from metrology.declaration.monte_carlo import MonteCarlo
from metrology.declaration.samples import Ellipse, GivenArea, Round, Sample, Tape
from metrology.methods import METHODS
from metrology.readings.binding import MAX_ROWS, MAX_TEXT_ROWS
from metrology.readings.packed import MAX_BYTES

#: Headings of the reference with the entries that stand below each.
_SECTIONS: tuple[tuple[str, tuple[type[Entry], ...]], ...] = (
    ("The file", (Campaign, MonteCarlo)),
    (
        "`report`, `laboratory`, `customer`",
        (identity.Report, signatures.Signatures, signatures.Signatory, declared.Replaces, identity.Party),
    ),
    (
        "`provided`, `opinions`, `anomalies`, `documents`",
        (declared.Provided, declared.Opinion, declared.Anomaly, declared.StatedDocument),
    ),
    ("`branding`", (branding.Branding, branding.Accreditation)),
    ("`instruments`", (identity.Instrument, identity.Certificate, identity.Correction)),
    ("`samples`", (Sample, Round, Ellipse, Tape, GivenArea)),
    ("`tests`", (conduct.Environment, conduct.Exclusion)),
    *((f"`tests`: method `{name}`", (method.test, *method.entries)) for name, method in METHODS.items()),
    ("`readings`", (readings.Readings, readings.ColumnOf, readings.Sampling)),
    ("`masses`", ()),
    ("`ensembles`", (Ensemble,)),
    ("`causes`", (component.StatedCause,)),
    ("`correlations`", (fits.Correlation,)),
    ("`fits`", (fits.Fit, fits.Axis, fits.Scatter, fits.PointCorrelation, fits.Model, fits.Prediction)),
    ("`derived`", (judgement.Derived,)),
    ("`comparisons`", (judgement.Comparison, judgement.Side)),
    (
        "`requirements`",
        (
            judgement.Requirement,
            judgement.Limits,
            judgement.Decision,
            judgement.NormalPrior,
            judgement.GammaPrior,
            judgement.LognormalPrior,
            judgement.RectangularPrior,
        ),
    ),
    ("`audit`", (judgement.Audit,)),
    ("`diagnosis`", (diagnosis.Diagnose,)),
)
#: What stands below a heading before its tables.
_REMARKS = {
    "The file": "Only `format`, `id` and `title` are required. A report stays a draft until all that its checklists "
    "ask is there; `metrology check --for 17025 FILE` lists what is lacking. That there is nothing to tell is said by "
    "`none`.",
    "`tests`": "Every test has a name, which stands before its results: `al-1100-elongation.k`. Each method has keys "
    "of its own; `environment` and `exclusions` are common to all.",
    **{f"`tests`: method `{name}`": method.remark for name, method in METHODS.items() if method.remark},
    "`branding`": "Pictures and shared file are inputs: the report carries them, and `metrology verify` reads them "
    "again. An SVG that could run code or refer to another file is refused, as is a colour whose contrast with white "
    "is below 4.5 : 1.",
    "`readings`": "The name of a file, or a mapping that says how it is read: `docs/readings.md`. What is stated and "
    "what the file says of itself are compared; a contradiction is a fault.",
    "`masses`": """Weights that are stacked are stated once, by name; the mass of a dead load, or of a released body, is
then a sum of names:

```yaml
masses:
  hook: {value: 0.12000 kg, uncertainty: [{standard: 0.05 g, source: balance}]}
  m1: {value: 1.00000 kg, uncertainty: [{expanded: 16 mg, k: 2, source: certificate W-1}]}
  m2: {value: 2.00000 kg, uncertainty: [{expanded: 30 mg, k: 2, source: certificate W-2}]}
tests:
  pull:
    loads: {A: {mass: hook}, B: {mass: hook + m1}, C: {mass: hook + m1 + m2}}
  swing: {mass: hook + m1}
```

Each component of a named mass is one unknown value in every sum that has the mass: u(hook + m1) is
√(u²(hook) + u²(m1)), and the loads B and C share u²(hook) + u²(m1) as their covariance, as does a test that is released
with these weights. Masses of one certificate may name the same `cause`: their components then act in the same
direction, and their sizes add up in a sum.""",
    "`ensembles`": "A column is named by its heading, unit included: `V / mV`. Quantities of one ensemble are "
    "correlated as their readings are; they may stand in expressions under their names.",
    "`causes`": "A component of an uncertainty names one under `cause`, and takes from it every key that it does not "
    "state itself; a component with a size of its own keeps it. All components of a cause are one unknown value, each "
    "in its own size, and have one distribution: their quantities are correlated, in the budget and in every draw. "
    "`direction: opposite` is for a quantity that the cause makes smaller where it makes others greater.",
    "`fits`": "Where neither `u_x` nor `u_y` is given, the fit is ordinary least squares and the scatter comes from "
    "the residuals. The results are `<fit>.intercept` and `<fit>.slope`, or the parameters of the expression.",
    "`derived`": "A name in an expression means what `where` says, then a quantity in the scope of `sample`, then one "
    "of the whole campaign. A dash is a minus: names with dashes go under `where`.",
}


def reference() -> str:
    """Return the documentation of campaign files as Markdown: `docs/campaign.md`."""
    from metrology.campaign.starter import CAMPAIGN

    parts = [
        _HEAD,
        "```yaml\n" + CAMPAIGN.format(name="tape", path="campaigns/tape/campaign.yaml").rstrip() + "\n```",
        _QUANTITIES,
    ]
    parts += tables((quantity.Stated, component.StatedComponent))
    parts += [_DISTRIBUTIONS, _NAMES.format(results=_results())]
    for heading, entries in _SECTIONS:
        parts.append(f"## {heading}")
        if heading in _REMARKS:
            parts.append(_REMARKS[heading])
        parts += tables(entries)
    rows = "\n".join(f"| `{name}` | {method.columns} |" for name, method in METHODS.items())
    return "\n\n".join(part.strip() for part in [*parts, _READINGS.replace("ROWS", rows), _LIMITS]) + "\n"


def _results() -> str:
    rows = [
        f"`{word}`: " + ", ".join(f"`{name}` ({output.unit})" for name, output in method.outputs.items())
        for word, method in METHODS.items()
    ]
    return "; ".join(rows)


_HEAD = """
# The campaign file

<!-- Generated from the schema; change the descriptions there. -->

A campaign is one folder with one YAML file, `campaign.yaml`, and the readings as CSV files in the same folder. The file
says what was measured, with what, on what, and what is to be made of it. `metrology new NAME` writes the
campaign below, with its readings; `metrology check FILE` tells every fault of a file at once, each with line
and column; `metrology report FILE` makes the report. Editors that know JSON Schema complete and check keys
while you type: put `# yaml-language-server: $schema=<path to>/campaign.schema.json` in the first line.

The shortest useful file derives one quantity from others:

```yaml
format: metrology-campaign/1
id: modulus
title: Modulus of a tape
quantities:
  k: 24734(336) N/m
  L: {value: 2.990 m, uncertainty: [{half_width: 2 mm, distribution: rectangular, source: steel tape}]}
  w: 25.00(5) mm
  t: {value: 0.0500 mm, uncertainty: [{standard: 0.0027 mm, dof: 9, type: A, source: micrometer}]}
derived:
  - {quantity: E, expression: k * L / (w * t), unit: GPa}
```

## A worked example
"""
_QUANTITIES = """
## How quantities are written

A quantity is a number with a unit. The uncertainty is a *standard* uncertainty (1 σ) in the two short forms:

| written | means |
|---|---|
| `25.00 mm` | a value that is taken as exact |
| `25.00(5) mm` | 25.00 mm with u = 0.05 mm: the digits in parentheses stand for the last places |
| `25.00 ± 0.05 mm`, `25.00 +/- 0.05 mm`, `25.00 +- 0.05 mm` | the same |
| `{value: 25.00 mm, uncertainty: [ … ]}` | the value, and every component of its uncertainty |
| `{from: cal/results.json, result: cal.k, sha256: 3f… }` | a result of another campaign, with its budget |

The decimal mark is a point; nothing groups digits. Units are written as in `N/m`, `kg/m^3`, `N·s/m` or
`W/(m·K)`, with SI prefixes; `u` stands for µ, `ohm` for Ω, `degC` for °C, `%` and
`ppm` too. A number has no unit, `0.001`; where only a unit is asked for, it is `1`. Every quantity is checked for its
dimension: a mass where a force is due is a fault at that line.

Components are independent of one another. Each says its size in one of three ways: `standard`, `half_width`
with a `distribution`, or `expanded` with `k`. A size in `%` is relative to the value; of a quantity that is a
number itself it would be ambiguous, and is refused.

A result of another campaign comes from its `results.json`, which lies in this campaign's folder, is known by its
SHA-256 and is attached to the report. The value is the one reported there; each row of its budget is a component here,
with its degrees of freedom, rows that are correlated as one, and one more where the u that is reported there exceeds
what its rows say (a square at zero). A row whose cause has the name of one under `causes` here
is that cause, and what two results depend on both is one unknown in both, also where one of them came here by a
campaign in between. Where results of one file are correlated there beyond that (readings taken together, parameters of
one fit) what is left of each is one component, with their covariance and the fewest degrees of freedom among them.
"""
_DISTRIBUTIONS = f"""
With `half_width`, the distribution is one of {", ".join(f"`{name}`" for name in BOUNDED)};
{", ".join(f"`{name}`" for name in WIDTHS)} may be stated by `standard` too. `exponential`, `gamma`, `lognormal` and
`truncated-normal` go with `standard`. Where a shape is not symmetric, the value is its mean; the long tail of these
points upwards: an `exponential` ends at value - u, a `lognormal` at value - u/√(exp(s²) - 1). The normal that is cut
at ±c·σ has σ = `standard`, and a smaller u. `asymmetric` are limits about a value that is not their middle (JCGM 100
4.3.8); `half_width` is half of their distance. With `standard` or `expanded` and no `distribution` it is `normal`;
where `dof` is given, the GUM uncertainty framework uses u and the Monte Carlo draws are
Student's t with the scale u (JCGM 101 6.4.9). `distribution: student` with `scale` says the same in so many
words; with `standard` it means that the figure is the standard deviation of the t distribution itself.
"""
_NAMES = """
## Names

A name that the file gives has at most 64 characters.

Results and inputs are used by name in `derived`, `comparisons`, `requirements`, `correlations` and `audit`:

| name | is |
|---|---|
| `<quantity>` | an entry of `quantities`, a column of `ensembles`, or a derived quantity without sample |
| `<sample>.<property>` | `length`, `linear_density`, the properties of the section, and `A`, its area |
| `<sample>.<quantity>` | a derived quantity of the sample |
| `<instrument>.correction` | the correction, where it is a quantity |
| `<test>.<result>` | {results} |
| `<fit>.<parameter>`, `<fit>.<point>` | parameters and predictions of a fit |
"""
_READINGS = f"""
## Readings

Files inside the campaign's folder, of any format in `docs/readings.md`: CSV and other texts, Excel and OpenDocument,
TDMS, UFF58, MAT, HDF5, Parquet, MDF4, LVM, NumPy, also gzipped or in a .zip. A CSV file as it should be is UTF-8 with
one heading line, commas between cells and a point as decimal mark; a heading has its unit after a solidus:
`reading / mm`, `time / s`. Other ways are read where nothing is lost, each with a notice in the report. A file has
at most {MAX_BYTES >> 20} MiB, plain and unpacked, and {MAX_ROWS // 10**6} million lines, {MAX_TEXT_ROWS // 1000} 000
where they hold words. Lines that begin with `#` above the heading are notes. Any order of columns will do.

| for | columns |
|---|---|
ROWS
| `ensembles`, `fits` | those that the campaign file names; further ones are passed over |
"""
_LIMITS = """
## What is refused

Tabs, anchors and aliases, tags, duplicate keys, empty values, unknown keys, files above 1 MiB, text that is not
UTF-8. Scalars are read by the key that receives them and by nothing else: `serial: 0123` stays `0123`, and `no`
is a word, not a truth value. Dates are written `2026-10-05`.
"""


if __name__ == "__main__":
    print(reference(), end="")
