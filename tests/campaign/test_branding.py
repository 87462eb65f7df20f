"""The look of a report: shared by campaigns, carried by the report, and refused where it is hostile."""

from __future__ import annotations

from base64 import b64decode
from io import BytesIO
from pathlib import Path

import pytest
from PIL import Image

from metrology import chain
from metrology.batch import bundle
from metrology.campaign.load import load
from metrology.campaign.sources import read_sources
from metrology.declaration.branding import contrast
from metrology.errors import MetrologyError

CAMPAIGN = """\
format: metrology-campaign/1
id: oil
title: Oil
quantities:
  oil: {value: 13.6 mm^2/s, uncertainty: [{standard: 1.8 mm^2/s}]}
derived:
  - {quantity: nu, expression: oil, unit: mm^2/s}
branding: {BRANDING}
"""
LOGO = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 1">{}</svg>'
RECTANGLE = '<rect width="2" height="1" fill="#123456"/>'


def png(width: int = 4, height: int = 4) -> bytes:
    stream = BytesIO()
    Image.new("L", (width, height)).save(stream, "PNG")
    return stream.getvalue()


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    """Folder of a campaign, with a shared file and its pictures in the folder above."""
    (tmp_path / "laboratory.yaml").write_text(
        "logo: logo.svg\ncolour: '#7a1f3d'\naccreditation: {body: Body, number: L-1, mark: mark.png}\nfooter: Shared\n"
    )
    (tmp_path / "logo.svg").write_text(LOGO.format(RECTANGLE))
    (tmp_path / "mark.png").write_bytes(png())
    (tmp_path / "oil").mkdir()
    return tmp_path / "oil"


def stated(lab: Path, branding: str) -> Path:
    (lab / "campaign.yaml").write_text(CAMPAIGN.replace("{BRANDING}", branding))
    return lab / "campaign.yaml"


def told(lab: Path, branding: str) -> str:
    with pytest.raises(MetrologyError) as refused:
        load(stated(lab, branding))
    return str(refused.value)


def test_law_a_shared_file_gives_what_the_campaign_does_not_state(lab: Path) -> None:
    campaign = load(stated(lab, "{file: laboratory.yaml, footer: Own}"))
    brand = chain.evaluate(campaign).campaign.brand
    assert brand is not None
    assert (brand.colour, brand.footer, brand.body, brand.number) == ("#7a1f3d", "Own", "Body", "L-1")
    assert brand.logo is not None
    assert brand.mark is not None
    assert b64decode(brand.logo.base64) == (lab.parent / "logo.svg").read_bytes()
    assert brand.mark.address.startswith("data:image/png;base64,")


def test_law_every_file_of_the_look_is_an_input_and_travels_with_the_campaign(lab: Path) -> None:
    path = stated(lab, "{file: laboratory.yaml}")
    names = {"campaign.yaml", "laboratory.yaml", "logo.svg", "mark.png"}
    assert set(read_sources(load(path))) == names
    assert {Path(name).name for name in bundle.pack(path, lab / "reports").files} == names


def test_law_a_file_in_the_campaigns_folder_goes_before_that_above(lab: Path) -> None:
    (lab / "logo.svg").write_text(LOGO.format(RECTANGLE + RECTANGLE))
    assert load(stated(lab, "{logo: logo.svg}")).look["logo.svg"] == (lab / "logo.svg").read_bytes()


@pytest.mark.parametrize(
    ("shapes", "got"),
    [
        ("<script>alert(1)</script>", "<script>"),
        ('<g onload="x()"/>', "'onload', which runs code"),
        ('<image href="x.png"/>', "<image>"),
        ('<use href="other.svg#a"/>', "href='other.svg#a', which refers to another file"),
        ('<rect style="fill: url(http://x/y)"/>', "which refers to another file"),
        ("<rect style=\"fill: URL('//x')\"/>", "which refers to another file"),
        ('<rect fill="u\\72l(x)"/>', "which refers to another file"),
        ("<style>@import 'x'</style>", "<style>"),
        ("<foreignObject/>", "<foreignObject>"),
        ("<text>Lab</text>", "<text>"),
        ('<h:iframe xmlns:h="http://www.w3.org/1999/xhtml"/>', "<iframe>, which is no part of SVG"),
        ("<g/>" * 5001, "<svg> with 5002 elements"),
        (f"<desc>{'x' * (257 << 10)}</desc>", "more than 256 KiB"),
        ("<g>", "no XML"),
    ],
)
def test_refusal_of_an_svg_that_could_run_fetch_or_is_too_large(lab: Path, shapes: str, got: str) -> None:
    (lab.parent / "logo.svg").write_text(LOGO.format(shapes))
    message = told(lab, "{logo: logo.svg}")
    assert "logo.svg: got" in message
    assert got in message


def test_refusal_of_entities_of_an_svg_without_size_and_of_what_is_no_png(lab: Path) -> None:
    (lab / "bomb.svg").write_text("<!DOCTYPE svg [<!ENTITY a 'a'>]>" + LOGO.format(RECTANGLE))
    assert "got a document type" in told(lab, "{logo: bomb.svg}")
    (lab / "bare.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"/>')
    assert "got no size" in told(lab, "{logo: bare.svg}")
    (lab / "text.png").write_text("no picture")
    assert "got no PNG that can be read" in told(lab, "{logo: text.png}")
    (lab / "huge.png").write_bytes(png(2001, 2000))
    assert "got 2001 × 2000 pixels" in told(lab, "{logo: huge.png}")


@pytest.mark.parametrize(
    ("branding", "got"),
    [
        ("{logo: none.svg}", "branding.logo: got 'none.svg'; expected a file, .svg or .png"),
        ("{logo: ../../logo.svg}", "'..' leaves the campaign's folder"),
        ("{logo: logo.gif}", "the name ends in .svg or .png"),
        ("{file: none.yaml}", "branding.file: got 'none.yaml'"),
        ("{colour: '#ffee00'}", "'#ffee00', whose contrast with white is 1.2 : 1"),
        ("{colour: red}", "branding.colour: got 'red'; expected a colour as '#0b4f8a'"),
        (f"{{footer: {'x' * 161}}}", "161 characters"),
        ("{color: '#000000'}", "did you mean 'colour'?"),
    ],
)
def test_refusal_names_what_the_campaign_states(lab: Path, branding: str, got: str) -> None:
    assert got in told(lab, branding)


def test_refusal_of_a_shared_file_names_its_line(lab: Path) -> None:
    (lab.parent / "laboratory.yaml").write_text("footer: A\ncolour: '#eeeeee'\n")
    assert "laboratory.yaml:2:9 colour: got '#eeeeee'" in told(lab, "{file: laboratory.yaml}")
    (lab.parent / "laboratory.yaml").write_text(f"footer: A\n#{'x' * (256 << 10)}")
    assert "got more than 256 KiB" in told(lab, "{file: laboratory.yaml}")
    (lab.parent / "laboratory.yaml").write_text("file: other.yaml\n")
    assert "got another shared file" in told(lab, "{file: laboratory.yaml}")


def test_twice_contrast_is_that_of_wcag() -> None:
    assert contrast("#000000") == pytest.approx(21.0)
    assert contrast("#ffffff") == pytest.approx(1.0)
    assert contrast("#767676") == pytest.approx(4.54, abs=0.01)
