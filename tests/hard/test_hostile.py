"""Hostile input of every reader: inputs that fuzzing found, limits, properties; no traceback, no hang, no memory."""

from __future__ import annotations

import gzip
import json
import resource
import subprocess
import sys
import zlib
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from metrology import units
from metrology.declaration.columns import Column
from metrology.declaration.document import read as read_document
from metrology.errors import MetrologyError
from metrology.expression import Expression
from metrology.findings import from_json
from metrology.methods.decay import TIME
from metrology.methods.elongation import COLUMNS as ELONGATION
from metrology.readings.files import read
from metrology.readings.lines import MAX_LINE, MAX_NOTES
from metrology.signoff.opened import open_report
from metrology.units.dimensions import TextError

ROOT = Path(__file__).parents[2]
NESTED = st.recursive(st.none() | st.text(), lambda x: st.lists(x) | st.dictionaries(st.text(), x), max_leaves=8)
CHEAP = settings(max_examples=150, deadline=20_000)

FOUND_QUANTITIES = [
    "2 N^\x1e\x1e2",
    "1 m^(1/0)",
    "(1)0 +/- 0.2)e s 1/K",
    "()±",
    "(±)",
    "±",
    "1 ± ± 1",
    "1 ±\n1 ± 1 m",
    "1e999 m",
    "1e-999 m",
    "1 m^999",
    "1(0) m",
]
"""Texts that were answered by a traceback once, or look as if they could be."""

FOUND_EXPRESSIONS = [
    "((((k**100)**100)**100)**100)",
    "k**1e308",
    "L**(0/0)",
    "max(k)",
    "-" * 50 + "k",
    "9**9**9**9",
    "(",
]


@pytest.mark.parametrize("text", FOUND_QUANTITIES)
def test_refusal_found_quantities(text: str) -> None:
    with suppress(TextError):
        units.parse(text)


@pytest.mark.parametrize("text", FOUND_EXPRESSIONS)
def test_refusal_found_expressions(text: str) -> None:
    with pytest.raises(TextError):
        _evaluate(text)


def _evaluate(text: str) -> None:
    names = {"k": units.dimension("N/m"), "L": units.dimension("m")}
    equation = Expression.parse(text)
    equation.dimension(names)
    equation.evaluate({"k": 2.5, "L": 1.5})


@CHEAP
@given(st.text(alphabet="0123456789.()±+-/eE µmkN^*·%,_ ", max_size=40))
def test_refusal_any_text_of_a_quantity(text: str) -> None:
    try:
        found = units.parse(text)
    except TextError:
        return
    assert found.u is None or found.u > 0


@CHEAP
@given(st.text(alphabet="kLe0129.()+-*/, sqrtmaxlog", max_size=60))
def test_refusal_any_text_of_an_expression(text: str) -> None:
    with suppress(TextError):
        _evaluate(text)


@pytest.mark.long
@CHEAP
@given(st.binary(max_size=200) | st.text('time / s,displacement\n0123456789.#"-e', max_size=200).map(str.encode))
def test_refusal_any_file_of_readings(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(content)
    for columns in ((TIME, Column("displacement", "m", varies=True)), ELONGATION):
        with suppress(MetrologyError):
            read(path, columns)


@CHEAP
@given(st.binary(max_size=200) | st.text("ab: -[]{}'\"\n#&*!|>?,0", max_size=200).map(str.encode))
def test_refusal_any_campaign_file(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_bytes(content)
    with suppress(MetrologyError):
        read_document(path)


@pytest.mark.long
@CHEAP
@given(st.binary(max_size=200) | NESTED.map(lambda value: json.dumps(value).encode()))
def test_refusal_any_results(content: bytes) -> None:
    with pytest.raises(ValueError, match=r"."):
        from_json(content)


# -- limits

LIMITS = {
    "objects": (json.dumps({"results": [{}] * 650_000}).encode(), "more than 600000 objects"),
    "keys": (json.dumps(dict.fromkeys(map(str, range(20_000)))).encode(), "more than 10000 keys"),
    "entries": (b"[" + b"0," * 4_100_000 + b"0]", "more than 4000000 entries"),
    "depth": (b"[" * 50_000, "nested too deep"),
    "digits": (b"1" * 10_000, "digits"),
}


@pytest.mark.parametrize("name", LIMITS)
def test_refusal_limits_of_results(name: str) -> None:
    content, words = LIMITS[name]
    with pytest.raises(ValueError, match=words):
        from_json(content)


def test_refusal_limits_of_readings(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    for content, words in (
        ("#\n" * (MAX_NOTES + 1), "lines of notes"),
        ("time / s,displacement / m\n" + "1" * (MAX_LINE + 1) + "\n", "a line of 10001 characters"),
        ("," * (MAX_LINE + 1) + "\n", "a line of 10001 characters"),
        ("load,repeat,direction,reading / mm\n" + "A,1,loading,0.5\n" * 200_001, "more than 200000 lines of readings"),
    ):
        path.write_text(content, encoding="utf-8")
        with pytest.raises(MetrologyError, match=words):
            read(path, ELONGATION if "load" in content else (TIME, Column("displacement", "m", varies=True)))


def test_refusal_file_of_a_terabyte_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    with path.open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(MetrologyError, match=r"too large.*every n-th sample"):
        read(path, (TIME, Column("displacement", "m", varies=True)))


WORST = """
import gzip, resource, sys, time
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from metrology.declaration.columns import Column
from metrology.methods.decay import TIME
from metrology.readings.files import read
from metrology.errors import MetrologyError
def guard(event, arguments):
    if event.startswith("socket.connect"): raise AssertionError(event)
    if event == "open" and set(str(arguments[1])) & set("wax+"): raise AssertionError(arguments)
sys.addaudithook(guard)
try: print(len(read(Path(sys.argv[1]), (TIME, Column("displacement", "m", varies=True)))))
except MetrologyError as error: print(error)
"""


@pytest.mark.long
@pytest.mark.parametrize("kind", ["bomb", "emoji"])
def test_limit_hostile_readings_stay_within_half_a_gigabyte(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.csv.gz"
    block = b"\0" * (1 << 20) if kind == "bomb" else "time / s,\U0001f600\r\n".encode() * (1 << 16)
    with gzip.open(path, "wb", compresslevel=1) as file:
        for _ in range(300 if kind == "bomb" else 50):
            file.write(block)
    done = subprocess.run(
        [sys.executable, "-c", WORST, path, ROOT],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (650 << 20,) * 2),
    )  # address space: libraries map some 150 MB that they do not use
    assert done.returncode == 0, done.stderr
    assert "got" in done.stdout


def pdf(results: bytes, catalog: bytes = b"", *, lost: int = 0) -> bytes:
    """A PDF without pages to which `results.json` is attached, and whose table has one more object, which is lost."""
    packed = zlib.compress(results, 1)
    tree = b"<</Names[(results.json)<</UF(results.json)/EF<</F 2 0 R>>>>]>>"
    bodies = [
        b"<</Type/Catalog/Pages 3 0 R/Names<</EmbeddedFiles" + tree + b">>" + catalog + b">>",
        b"<</Filter/FlateDecode/Length %d>>\nstream\n" % len(packed) + packed + b"\nendstream",
        b"<</Type/Pages/Kids[]/Count 0>>",
    ]
    content, places = b"%PDF-1.7\n", []
    for number, body in enumerate(bodies, start=1):
        places.append(b"%010d 00000 n \n" % len(content))
        content += b"%d 0 obj\n" % number + body + b"\nendobj\n"
    table = b"xref\n0 5\n0000000000 65535 f \n" + b"".join(places) + b"%010d 00000 n \n" % lost
    return content + table + b"trailer\n<</Size 5/Root 1 0 R>>\nstartxref\n%d\n%%%%EOF\n" % len(content)


@pytest.mark.long
def test_refusal_pdf_whose_attachment_is_a_bomb(tmp_path: Path) -> None:
    """A stream of 300 MB in 300 kB."""
    (tmp_path / "report.pdf").write_bytes(pdf(b"0" * (300 << 20)))
    with pytest.raises(MetrologyError, match=r"damaged.*limit"):
        open_report(tmp_path / "report.pdf")


RESULTS = b'{"schema": "metrology-results/1", "campaign": {}, "inputs": [{"path": "a", "sha256": "0", "bytes": 1}]}'


@pytest.mark.parametrize(
    ("catalog", "lost"),
    [(b"/AcroForm<</Fields[4 0 R]>>", 10**6), (b"/AcroForm<</Fields[4 0 R]>>", 1), (b"/AcroForm 5", 9)],
)
def test_refusal_found_pdf_whose_fields_lead_nowhere(catalog: bytes, lost: int, tmp_path: Path) -> None:
    (tmp_path / "report.pdf").write_bytes(pdf(RESULTS))
    assert open_report(tmp_path / "report.pdf").signatures == ()
    (tmp_path / "report.pdf").write_bytes(pdf(RESULTS, catalog, lost=lost))
    with pytest.raises(MetrologyError, match=r"damaged or truncated PDF"):
        open_report(tmp_path / "report.pdf")
