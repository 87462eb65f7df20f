"""Tendons of MuJoCo: a file that a model includes, whose sites are its own.

Attributes and units: MuJoCo's documentation, "XML Reference", tendon/spatial (mujoco.readthedocs.io).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from metrology.export.line import Words, heading, lines, sources
from metrology.findings import Findings


def tendons(findings: Findings, use: Sequence[str] = ()) -> bytes:
    """A spatial tendon a sample, between its sites ``NAME_1`` and ``NAME_2``: k, c, and a rest length from 0 to L.

    Between 0 and L a tendon has no spring force: a line pulls and never pushes. Its damping acts there all the same.

    Parameters
    ----------
    findings : Findings
    use : sequence of str
        Full names of results, for a quantity that several tests give.

    Raises
    ------
    MetrologyError
        For every sample that lacks c or a length.
    """
    found = lines(findings, use)
    root = Element("mujocoinclude")
    for text in heading(findings, "Tendons for MuJoCo"):
        root.append(_comment(text))
    tendon = SubElement(root, "tendon")
    words = Words()
    for line in found:
        for text in sources(line):
            tendon.append(_comment(text))
        name = words(line.name)
        spring = {"stiffness": repr(line.k.value), "damping": repr(line.c.value)}
        spatial = SubElement(tendon, "spatial", {"name": name, **spring, "springlength": f"0 {line.length.n!r}"})
        for end in (1, 2):
            SubElement(spatial, "site", {"site": f"{name}_{end}"})
    indent(root, " ")
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _comment(text: str) -> Any:
    """A comment, in which XML allows no two hyphens in a row, nor one at its end."""
    return Comment(f" {text.replace('--', '- -')} ")
