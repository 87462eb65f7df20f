"""The language server on stdin and stdout."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

from lsprotocol import types
from pygls import uris
from pygls.lsp.server import LanguageServer

from metrology import __version__
from metrology.lsp import faults
from metrology.lsp.keys import Keys, described
from metrology.lsp.outline import Entry, Outline

if TYPE_CHECKING:
    from pygls.workspace import TextDocument

QUIET = 0.2
"""Time without a key pressed after which a text is checked, s."""
SOURCE = "metrology"


class Server(LanguageServer):
    """`waiting`: by document, the check that is about to begin; `found`: version and faults of the last one.

    One check at a time: none can be cancelled once it runs, and each may need the memory of a reader.
    """

    def __init__(self) -> None:
        super().__init__("metrology", __version__)
        self.waiting: dict[str, asyncio.Task[None]] = {}
        self.found: dict[str, tuple[int | None, list[faults.Marked]]] = {}
        self._one = ThreadPoolExecutor(1)

    def check_soon(self, uri: str, quiet: float) -> None:
        """Check a document, unless it changes again before that."""
        if uri in self.waiting:
            self.waiting[uri].cancel()
        self.waiting[uri] = asyncio.get_running_loop().create_task(self._check(uri, quiet))

    async def _check(self, uri: str, quiet: float) -> None:
        await asyncio.sleep(quiet)
        document = self.workspace.get_text_document(uri)
        text, version = document.source, document.version
        found: list[faults.Marked] = []
        if faults.is_campaign(text):
            # Cancelled while another one runs, it never begins.
            loop = asyncio.get_running_loop()
            found = await loop.run_in_executor(self._one, faults.faults, path_of(uri), text)
        # What was typed meanwhile is checked by itself.
        if uri in self.workspace.text_documents and document.version == version:
            self.found[uri] = version, found
            marks = [_diagnostic(document, one) for one in found]
            self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, marks, version))


def _opened(running: Server, uri: str) -> TextDocument | None:
    """A document that the editor has opened; of others the protocol knows nothing."""
    documents: Mapping[str, TextDocument] = running.workspace.text_documents
    return documents.get(uri)


def path_of(uri: str) -> Path:
    """Path of a document; of one that has none yet, a name in the folder in which the server runs."""
    return Path(uris.to_fs_path(uri) or "campaign.yaml")


def _range(document: TextDocument, row: int, column: int, end: int) -> types.Range:
    found = types.Range(types.Position(row, column), types.Position(row, end))
    return document.position_codec.range_to_client_units(document.lines, found)


def _diagnostic(document: TextDocument, one: faults.Marked) -> types.Diagnostic:
    where = _range(document, one.row, one.column, one.end)
    return types.Diagnostic(where, one.text, types.DiagnosticSeverity.Error, source=SOURCE)


server = Server()


@server.feature(types.TEXT_DOCUMENT_DID_OPEN)
async def opened(running: Server, parameters: types.DidOpenTextDocumentParams) -> None:
    """Check a document at once."""
    running.check_soon(parameters.text_document.uri, 0.0)


@server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
async def changed(running: Server, parameters: types.DidChangeTextDocumentParams) -> None:
    """Check a document when nothing more is typed."""
    running.check_soon(parameters.text_document.uri, QUIET)


@server.feature(types.TEXT_DOCUMENT_DID_SAVE)
async def saved(running: Server, parameters: types.DidSaveTextDocumentParams) -> None:
    """Check a document again: its readings may have changed."""
    running.check_soon(parameters.text_document.uri, 0.0)


@server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
async def closed(running: Server, parameters: types.DidCloseTextDocumentParams) -> None:
    """Take the marks away."""
    uri = parameters.text_document.uri
    if uri in running.waiting:
        running.waiting.pop(uri).cancel()
    running.found.pop(uri, None)
    running.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, []))


@server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=[" ", "{"]))
def complete(running: Server, parameters: types.CompletionParams) -> list[types.CompletionItem]:
    """Offer the keys that an entry can have and does not have yet, or the words that a key takes."""
    document = _opened(running, parameters.text_document.uri)
    if document is None or not faults.is_campaign(document.source):
        return []
    position = document.position_codec.position_from_client_units(document.lines, parameters.position)
    lines = document.source.split("\n")
    before = Outline("\n".join([*lines[: position.line], lines[position.line][: position.character]]))
    entries = Outline(document.source).entries
    keys = Keys(_values(entries))
    if before.of_value:
        return [
            types.CompletionItem(word, kind=types.CompletionItemKind.EnumMember) for word in keys.words(before.here)
        ]
    there = {one.place for one in entries if (one.row, one.place[-1]) != (position.line, before.word)}
    return [
        types.CompletionItem(
            key,
            kind=types.CompletionItemKind.Property,
            documentation=types.MarkupContent(types.MarkupKind.Markdown, described(key, what)),
            insert_text=f"{key}: ",
        )
        for key, what in keys.of(before.here).items()
        if (*before.here, key) not in there
    ]


@server.feature(types.TEXT_DOCUMENT_HOVER)
def hover(running: Server, parameters: types.HoverParams) -> types.Hover | None:
    """Say what the key at the cursor means."""
    document = _opened(running, parameters.text_document.uri)
    if document is None or not faults.is_campaign(document.source):
        return None
    position = document.position_codec.position_from_client_units(document.lines, parameters.position)
    entries = Outline(document.source).entries
    for one in entries:
        key = str(one.place[-1])
        if one.row == position.line and one.column <= position.character <= one.column + len(key):
            meaning = Keys(_values(entries)).meaning(one.place)
            if meaning is None:
                return None
            text = types.MarkupContent(types.MarkupKind.Markdown, described(key, meaning))
            return types.Hover(text, _range(document, one.row, one.column, one.column + len(key)))
    return None


@server.feature(types.TEXT_DOCUMENT_CODE_ACTION, types.CodeActionOptions([types.CodeActionKind.QuickFix]))
def fix(running: Server, parameters: types.CodeActionParams) -> list[types.CodeAction]:
    """Offer what `metrology check --fix` does to the faults at the cursor, as far as the text has been checked."""
    document = _opened(running, parameters.text_document.uri)
    version, found = running.found.get(parameters.text_document.uri, (None, []))
    if document is None or version != document.version:
        return []
    rows = range(parameters.range.start.line, parameters.range.end.line + 1)
    return [_action(document, one) for one in found if one.edit is not None and one.edit.line - 1 in rows]


def _action(document: TextDocument, one: faults.Marked) -> types.CodeAction:
    edit = one.edit
    assert edit is not None
    at = _range(document, edit.line - 1, edit.column - 1, edit.column - 1 + len(edit.old))
    change = types.WorkspaceEdit({document.uri: [types.TextEdit(at, edit.new)]})
    title = f"Replace '{edit.old}' by '{edit.new}'"
    return types.CodeAction(title, types.CodeActionKind.QuickFix, [_diagnostic(document, one)], edit=change)


def _values(entries: list[Entry]) -> dict[tuple[str | int, ...], str]:
    return {one.place: one.value for one in entries if one.value}
