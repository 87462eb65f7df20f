"""Exports of instruments, made for tests after the public documentation of their formats."""

from __future__ import annotations

import math
import random
from pathlib import Path

STAMPS = [i / 1000 for i in range(600)]
MOVED = [round(50 * math.exp(-3 * t) * math.cos(140 * t) + 0.02 * ((7 * i) % 5 - 2), 3) for i, t in enumerate(STAMPS)]
PULLED = [i * 0.01 for i in range(200)]
SLOPE = 24.7
"""Of force against extension / (N/mm)."""


def force(i: int) -> float:
    return SLOPE * PULLED[i] + 0.01 * ((7 * i) % 5 - 2)


def german_workbook(path: Path) -> None:
    """A cover sheet, a block above the headings, words and headings in German, a column of remarks."""
    from openpyxl import Workbook

    book = Workbook()
    book.active.title = "Deckblatt"
    book.active.append(["Auftrag", "A-17"])
    sheet = book.create_sheet("Messung")
    for row in (
        ["Prüfprotokoll"],
        ["Prüfer:", "A. Schmidt"],
        [],
        ["Last [kg]", "Wiederholung", "Richtung", "Ablesung [mm]", "Bemerkung"],
    ):
        sheet.append(row)
    for repeat in (1, 2, 3):
        for word, loads in (("Belastung", (1, 2, 3)), ("Entlastung", (3, 2, 1))):
            for load in loads:
                sheet.append([load, repeat, word, round(0.4 * load + 0.01 * ((repeat + load) % 2), 2), None])
    book.save(path)


def polytec(path: Path) -> None:
    rows = [f"{t}\t{x}" for t, x in zip(STAMPS, MOVED, strict=True)]
    head = [
        "Polytec VibSoft",
        "Source File Name:\tscan1.pvd",
        "Date:\t2026-10-05",
        "Point Index:\t1",
        "",
        "Time\tDisplacement",
    ]
    path.write_text("\n".join([*head, "[ s ]\t[ um ]", *rows]) + "\n", encoding="utf-8")


def zwick(path: Path) -> None:
    head = ["testXpert II;V3.6", "Prüfer;A. Schmidt", "Datum;05.10.2026", "Probenname;Draht 7", ""]
    head += ["Prüfzeit;Standardweg;Standardkraft", "s;mm;N"]
    rows = [f"{0.1 * i:.1f};{x:.3f};{force(i):.3f}".replace(".", ",") for i, x in enumerate(PULLED)]
    path.write_bytes(("\r\n".join([*head, *rows]) + "\r\n").encode("cp1252"))


def instron(path: Path) -> None:
    head = ['"Instron Bluehill 3"', '"Specimen label","wire 7"', '"Time","Extension","Load"', '"(s)","(mm)","(N)"']
    rows = [f'"{0.1 * i:.4f}","{x:.4f}","{force(i):.4f}"' for i, x in enumerate(PULLED)]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


def mts(path: Path) -> None:
    head = ["MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A", "", "Data Header:\tTime:\t10.5\tSec\t10/5/2026 12:00:00 PM"]
    head += [
        "Data Acquisition: Timed\t",
        "Station Name:\tFrame2.cfg",
        "Time\tAxial Displacement\tAxial Force",
        "Sec\tmm\tkN",
    ]
    rows = [f"{0.1 * i:.4f}\t{x:.5f}\t{force(i) / 1000:.7f}" for i, x in enumerate(PULLED)]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


def motive(path: Path) -> None:
    head = [
        "Format Version,1.23,Take Name,Take 1,Capture Frame Rate,1000.000000,Export Frame Rate,1000.000000,"
        "Length Units,Millimeters,Coordinate Space,Global",
        "", ",,Rigid Body,Rigid Body,Rigid Body", ",,Module,Module,Module", ",,ID1,ID1,ID1",
        ",,Position,Position,Position", "Frame,Time (Seconds),X,Y,Z",
    ]  # fmt: skip
    rows = [
        f"{i},{t:.6f},{0.1 * (i % 3):.6f},{x:.6f},{0.2 * (i % 5):.6f}"
        for i, (t, x) in enumerate(zip(STAMPS, MOVED, strict=True))
    ]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


def vicon(path: Path) -> None:
    head = ["Trajectories", "1000", ",,Module:M1,,", "Frame,Sub Frame,X,Y,Z", ",,mm,mm,mm"]
    rows = [f"{i + 1},0,{x:.4f},{0.1 * (i % 3):.4f},{0.2 * (i % 5):.4f}" for i, x in enumerate(MOVED)]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


TEXTS = (polytec, zwick, instron, mts, motive, vicon)
"""Exports that are texts."""


MODULUS = 2.4e9
"""Of a strip of 10 mm by 1 mm / Pa."""


def zwick_with_strain(path: Path, number: int) -> None:
    """Crosshead with slack and a soft set-up, and an extensometer; the block has the sizes of the specimen."""
    head = ["testXpert II;V3.6", "Probenname;Band 3", "Probenbreite;10,00;mm", "Probendicke;1,00;mm", ""]
    head += ["Prüfzeit;Traversenweg;Standardkraft;Dehnung", "s;mm;N;%"]
    rows = []
    for i in range(300):
        pulled = 1.0 * i
        strain = pulled / (MODULUS * 10e-6) * 100 + 1e-4 * ((number + 4) * i % 7 - 3)
        rows.append(
            f"{0.1 * i:.1f};{0.05 + pulled * 4e-3:.3f};{pulled + 0.05 * ((number + 6) * i % 5 - 2):.2f};{strain:.4f}"
        )
    text = "\r\n".join([*head, *(row.replace(".", ",") for row in rows)]) + "\r\n"
    path.write_bytes(text.encode("cp1252"))


def hold(path: Path, held: str) -> None:
    """A ramp of 5 s, then elongation or load is held while the other relaxes or creeps."""
    rows = ["Specimen diameter;0.50;mm", "", "Time;Extension;Force", "s;mm;N"]
    for i in range(600):
        t = 0.5 * i
        ramp, rest = min(t / 5, 1.0), max(t - 5, 0.0)
        answer = 0.7 + 0.3 * math.exp(-rest / 30)
        noise = 0.001 * ((7 * i) % 5 - 2)
        x, force = (ramp, 100 * ramp * answer) if held == "elongation" else (ramp * (1.7 - answer), 100 * ramp)
        rows.append(f"{t:.1f};{x + 1e-4 * noise:.5f};{force + noise:.4f}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def thrust(path: Path, force: float) -> None:
    """A module of 25 kg on a line of 169 N/m and 7.9 N·s/m that is taut at 1.5 m; thrust from 1 s on."""
    rows, x, v, step = ["Zeit [s];Position [m];Geschwindigkeit [m/s];Kraft [N];Schub [N]"], 1.45, 0.0, 1e-3
    drawn = random.Random(round(10 * force))
    for i in range(10_000):
        push = force if i >= 1000 else 0.0
        pull = max(169.0 * (x - 1.5) + 7.9 * v, 0.0) if x > 1.5 else 0.0
        if i % 10 == 0:
            noise = drawn.randint(-2, 2)
            rows.append(
                f"{i * step:.2f};{x + 2e-5 * noise:.5f};{v + 1e-4 * noise:.5f};{pull + 1e-3 * noise:.4f};{push}"
            )
        v += (push - pull) / 25.0 * step
        x += v * step
    path.write_text("\n".join(rows).replace(".", ",") + "\n", encoding="utf-8")
