"""The language server, asked by a client over stdin and stdout, as an editor does."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

pygls = pytest.importorskip("pygls")
from lsprotocol import types  # noqa: E402
from pygls.lsp.client import BaseLanguageClient  # noqa: E402

pytestmark = pytest.mark.long
WAIT = 60
NOTHING = types.CodeActionContext([])
WIRE = """\
format: metrology-campaign/1
id: wire
title: Stiffness of a steel wire
instruments:
  indicator: {kind: dial indicator, resolution: 0.01 mm}
samples:
  wire:
    section: {shape: round, diameter: 0.500(2) mm}

    length: 2.000(1) m
tests:
  pull:
    method: elongation
    sample: wire
    instruments: {extension: indicator}
    gravity: 9.8065(3) m/s^2
    loads: {A: {mass: 1.0000(1) kg}, B: {mass: 2.0000(1) kg}, C: {mass: 3.0000(2) kg}}
    readings: wire.csv
"""
READINGS = "load,repeat,direction,reading / mm\n" + "".join(
    f"{load},{repeat},loading,{reading + repeat * 0.01:.2f}\n"
    for repeat in (1, 2, 3)
    for load, reading in zip("ABC", (0.49, 0.97, 1.47), strict=True)
)


class Editor:
    """One document in an editor."""

    def __init__(self, client: BaseLanguageClient, path: Path) -> None:
        self.client, self.path, self.version = client, path, 0
        self.told: asyncio.Queue[list[types.Diagnostic]] = asyncio.Queue()

        @client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def take(told: types.PublishDiagnosticsParams) -> None:
            assert told.uri == path.as_uri()
            self.told.put_nowait(list(told.diagnostics))

    async def open(self, text: str) -> list[types.Diagnostic]:
        document = types.TextDocumentItem(self.path.as_uri(), "yaml", self.version, text)
        self.client.text_document_did_open(types.DidOpenTextDocumentParams(document))
        return await asyncio.wait_for(self.told.get(), WAIT)

    async def write(self, text: str) -> list[types.Diagnostic]:
        self.version += 1
        which = types.VersionedTextDocumentIdentifier(self.version, self.path.as_uri())
        change = [types.TextDocumentContentChangeWholeDocument(text)]
        self.client.text_document_did_change(types.DidChangeTextDocumentParams(which, change))
        return await asyncio.wait_for(self.told.get(), WAIT)

    def at(self, text: str, mark: str, past: int = 0) -> dict[str, Any]:
        before = text[: text.index(mark) + past]
        position = types.Position(before.count("\n"), len(before.rpartition("\n")[2].encode("utf-16-le")) // 2)
        return {"text_document": types.TextDocumentIdentifier(self.path.as_uri()), "position": position}

    async def completed(self, text: str, mark: str, past: int) -> dict[str, types.CompletionItem]:
        found = await self.client.text_document_completion_async(types.CompletionParams(**self.at(text, mark, past)))
        assert isinstance(found, list)
        return {one.label: one for one in found}

    async def hovered(self, text: str, mark: str) -> types.Hover | None:
        return await self.client.text_document_hover_async(types.HoverParams(**self.at(text, mark)))


def edit(folder: Path, work: Callable[[Editor], Awaitable[None]], *server: str) -> None:
    """Start the server, let an editor work with it, and see it end well."""
    (folder / "wire.csv").write_text(READINGS)

    async def session() -> None:
        client = BaseLanguageClient("editor", "1")
        await client.start_io(sys.executable, *(server or ("-m", "metrology", "lsp")))
        capabilities = types.ClientCapabilities()
        started = client.initialize_async(types.InitializeParams(capabilities, root_uri=folder.as_uri()))
        await asyncio.wait_for(started, WAIT)
        client.initialized(types.InitializedParams())
        await work(Editor(client, folder / "campaign.yaml"))
        await asyncio.wait_for(client.shutdown_async(None), WAIT)
        client.exit(None)
        await asyncio.wait_for(client.stop(), WAIT)

    asyncio.run(session())


def test_planted_faults_are_those_of_the_text_that_is_not_saved(tmp_path: Path):
    async def work(editor: Editor) -> None:
        assert await editor.open(WIRE) == []
        (fault,) = await editor.write(WIRE.replace("    length:", "    lenght:"))
        assert fault.message.startswith("samples.wire.lenght: got 'lenght', an unknown key")
        assert (fault.range.start, fault.range.end) == (types.Position(9, 4), types.Position(9, 22))
        assert not editor.path.exists()
        assert await editor.write(WIRE) == []

    edit(tmp_path, work)


def test_law_columns_are_those_of_the_editor_beyond_the_basic_plane(tmp_path: Path):
    text = WIRE.replace("{kind: dial indicator, resolution: 0.01 mm}", "{kind: '𝛿 indicator', resolution: 0.01 mmm}")

    async def work(editor: Editor) -> None:
        (fault,) = await editor.open(text)
        start = editor.at(text, "0.01 mmm")["position"]
        assert (fault.range.start, fault.range.end.character) == (start, start.character + len("0.01 mmm"))

    edit(tmp_path, work)


def test_planted_fault_of_the_readings_stands_where_they_are_named(tmp_path: Path):
    async def work(editor: Editor) -> None:
        assert await editor.open(WIRE) == []
        (tmp_path / "wire.csv").write_text(READINGS.replace("0.50", "0,50", 1))
        which = types.TextDocumentIdentifier(editor.path.as_uri())
        editor.client.text_document_did_save(types.DidSaveTextDocumentParams(which))
        found = await asyncio.wait_for(editor.told.get(), WAIT)
        assert found
        assert all(one.range.start == editor.at(WIRE, "wire.csv")["position"] for one in found)
        assert "wire.csv:2" in found[0].message

    edit(tmp_path, work)


def test_limit_half_a_file_has_its_fault_and_the_server_lives(tmp_path: Path):
    async def work(editor: Editor) -> None:
        assert len(await editor.open(WIRE[: WIRE.index("0.500")])) == 1
        assert await editor.write(WIRE) == []

    edit(tmp_path, work)


def test_limit_a_yaml_file_of_another_kind_is_left_alone(tmp_path: Path):
    async def work(editor: Editor) -> None:
        text = "name: something else\nformat: metrology-campaign/1\n"
        assert await editor.open(text) == []
        assert await editor.completed(text, "name", 0) == {}
        assert await editor.hovered(text, "format") is None

    edit(tmp_path, work)


def test_law_keys_and_words_are_completed_where_the_cursor_is(tmp_path: Path):
    async def work(editor: Editor) -> None:
        text = WIRE.replace("    sample: wire\n", "    sa\n")
        await editor.open(text)
        offered = await editor.completed(text, "    sa\n", 6)
        assert {"sample", "exclusions"} <= set(offered)
        assert not {"method", "gravity", "mass", "id"} & set(offered)
        assert "sample" in offered["sample"].documentation.value.lower()
        assert offered["sample"].insert_text == "sample: "
        text = WIRE.replace("diameter: 0.500(2) mm", "")
        await editor.write(text)
        assert set(await editor.completed(text, "round, ", 7)) == {"diameter"}
        text = WIRE.replace("method: elongation", "method: ")
        await editor.write(text)
        assert {"elongation", "decay"} <= set(await editor.completed(text, "method: ", 8))

    edit(tmp_path, work)


def test_law_hover_says_what_a_key_means_in_its_kind_of_entry(tmp_path: Path):
    async def work(editor: Editor) -> None:
        await editor.open(WIRE)
        found = await editor.hovered(WIRE, "gravity")
        assert found is not None
        assert "gravity" in found.contents.value.lower()
        assert found.range == types.Range(types.Position(15, 4), types.Position(15, 11))
        assert await editor.hovered(WIRE, "wire:") is None

    edit(tmp_path, work)


def test_limit_of_a_document_that_is_not_open_nothing_is_known(tmp_path: Path):
    async def work(editor: Editor) -> None:
        assert await editor.hovered(WIRE, "gravity") is None

    edit(tmp_path, work)


def test_planted_mechanical_fault_has_its_quick_fix(tmp_path: Path):
    async def work(editor: Editor) -> None:
        text = WIRE.replace("    length:", "    lenght:")
        (fault,) = await editor.open(text)
        which = types.TextDocumentIdentifier(editor.path.as_uri())
        asked = types.CodeActionParams(which, fault.range, types.CodeActionContext([fault]))
        (action,) = await editor.client.text_document_code_action_async(asked)
        (change,) = action.edit.changes[editor.path.as_uri()]
        assert (change.range.start, change.range.end) == (types.Position(9, 4), types.Position(9, 10))
        assert change.new_text == "length"

    edit(tmp_path, work)


SLOW = """
import time
from metrology.lsp import faults, server

known, running = faults.faults, []

def slow(path, text):
    running.append(text)
    if len(running) > 1:
        (path.parent / "two at once").touch()
    (path.parent / "begun").touch()
    while not (path.parent / "go on").exists():
        time.sleep(0.05)
    running.pop()
    return known(path, text)

faults.faults = slow
server.server.start_io()
"""


def test_limit_slow_readings_take_one_check_at_a_time_and_block_nothing(tmp_path: Path):
    async def work(editor: Editor) -> None:
        opened = asyncio.create_task(editor.open(WIRE))
        while not (tmp_path / "begun").exists():
            await asyncio.sleep(0.05)
        for digit in (1, 2, 3):
            await asyncio.sleep(0.4)
            typed = asyncio.create_task(editor.write(WIRE.replace("    length:", f"    lenght: {digit}")))
        text, which = WIRE, types.TextDocumentIdentifier(editor.path.as_uri())
        asked = types.CodeActionParams(which, types.Range(types.Position(0, 0), types.Position(30, 0)), NOTHING)
        # While that check runs on, both are answered.
        assert not await asyncio.wait_for(editor.client.text_document_code_action_async(asked), WAIT)
        assert await asyncio.wait_for(editor.hovered(text, "gravity"), WAIT) is not None
        (tmp_path / "go on").touch()
        # The first check is of a text that is no longer there: it tells nothing, and the last one alone follows.
        (fault,) = await asyncio.wait_for(opened, WAIT)
        assert "lenght" in fault.message
        (action,) = await editor.client.text_document_code_action_async(asked)
        assert action.title == "Replace 'lenght' by 'length'"
        typed.cancel()

    edit(tmp_path, work, "-c", SLOW)
    assert not (tmp_path / "two at once").exists()
