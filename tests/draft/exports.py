"""Exports of instruments, made for tests after the public documentation of their formats."""

from __future__ import annotations

import math
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
