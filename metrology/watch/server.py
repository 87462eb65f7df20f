"""The pages on loopback: for the browsers of this machine, and for no page that comes from elsewhere."""

from __future__ import annotations

import json
import re
import sys
from http.server import BaseHTTPRequestHandler
from socketserver import ThreadingTCPServer
from time import sleep
from typing import TYPE_CHECKING, Any

from metrology.errors import Fault, MetrologyError, hindrance
from metrology.watch.board import Board

if TYPE_CHECKING:
    from metrology.watch.pages import Pages

ADDRESS = "127.0.0.1"
_PATH = re.compile(r"/(?:campaign/(?P<number>\d{1,6})/)?(?P<what>|report|events)(?:\?\d*)?", re.ASCII)
ALIVE = 15.0
"""How often a browser is sent something though there is no news, so that one which has gone is noticed, s."""
PAUSE = 0.05
"""Time between two messages to a browser, s."""
HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class Server(ThreadingTCPServer):
    """Serves the pages of a board; `url` says where."""

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, board: Board, pages: Pages, port: int) -> None:
        self.board, self.pages = board, pages
        try:
            super().__init__((ADDRESS, port), _Handler)
        except (OSError, OverflowError) as error:
            got = f"{port}: {hindrance(error) if isinstance(error, OSError) else 'no port'}"
            raise MetrologyError(Fault("--port", got, "a free port, or none to have one chosen")) from None
        port = self.server_address[1]
        self.url = f"http://{ADDRESS}:{port}/"
        # A page from elsewhere can give its own name the address of this machine, but not another name to its requests.
        self.hosts = {f"{name}:{port}" for name in (ADDRESS, "localhost")}

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a browser that has gone."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"
    timeout = 60

    def do_GET(self) -> None:
        """Answer one request."""
        found = _PATH.fullmatch(self.path)
        if self.headers.get("Host", "") not in self.server.hosts:
            self._send(403, b"This page is for browsers of this machine alone.\n", "text/plain")
        elif found is None or (found["number"] and int(found["number"]) not in self.server.board.campaigns):
            self._send(404, b"There is no such page.\n", "text/plain")
        else:
            number = int(found["number"]) if found["number"] else self.server.pages.first
            {"": self._page, "report": self._report, "events": self._events}[found["what"]](number)

    def _page(self, number: int | None) -> None:
        text, policy = self.server.pages.page(number)
        self._send(200, text.encode(), "text/html; charset=utf-8", policy)

    def _report(self, number: int | None) -> None:
        page = None if number is None else self.server.board.campaigns[number].page
        if page is None:
            self._send(404, b"There is no report yet.\n", "text/plain")
        else:
            self._send(200, page.html, "text/html; charset=utf-8", "frame-ancestors 'self'")

    def _events(self, number: int | None) -> None:
        """Send the state at once, and again whenever it changes, for as long as the browser listens."""
        self._head(200, "text/event-stream", "", {"Connection": "close"})
        self.close_connection = True
        seen, last = -1, ""
        while True:
            seen = self.server.board.wait(seen, ALIVE)
            now = json.dumps(self.server.pages.state(number))
            self.wfile.write((f"data: {now}\n\n" if now != last else ": still here\n\n").encode())
            last = now
            sleep(PAUSE)

    def _send(self, status: int, content: bytes, kind: str, policy: str = "") -> None:
        self._head(status, kind, policy, {"Content-Length": str(len(content))})
        self.wfile.write(content)

    def _head(self, status: int, kind: str, policy: str, more: dict[str, str]) -> None:
        self.send_response(status)
        for name, value in {**HEADERS, "Content-Type": kind, **more}.items():
            self.send_header(name, value)
        self.send_header("Content-Security-Policy", policy or "default-src 'none'; frame-ancestors 'none'")
        self.end_headers()

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002
        """Print nothing: the terminal is for faults."""
