"""`handgen view`: the page of a parameter file on this machine only, made anew whenever the file is saved.

A file with errors leaves the last good page standing, with the errors on it. Served are the page, its state,
and files of the hand's folder; nothing else, and to nobody but this machine.
"""

from __future__ import annotations

import contextlib
import json
import mimetypes
import os
import sys
import threading
import traceback
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urlsplit

import yaml

from handgen.errors import HandgenError, InputError, Problem
from handgen.report.page import waiting
from handgen.report.write import compose, home

HOST = "127.0.0.1"
PORT = 8765
EVERY = 0.4
"""Seconds between looks at the files."""
GRACE = 1.0
"""Seconds for the page in the making to be done; then it is dropped."""
LONGEST_CHAIN = 16
OURS = "this is a mistake in handgen itself; please report it: "
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; frame-ancestors 'none'"
"""For files of the folder, the worksheet among them: no scripts."""


class _OutdatedError(Exception):
    """The file was saved while its fingers were being bent."""


class Maker:
    """Makes page after page of one parameter file; `page` and `state` are what a server hands out."""

    def __init__(self, params: str | os.PathLike, out: str | os.PathLike | None = None, *,
                 workers: int | None = None, say: Callable[[str], None] = lambda line: None):
        self.params, self.out, self.workers, self.say = Path(params), out, workers, say
        self.serial, self.busy, self.problems = 0, "", list[str]()
        self.page = waiting(self.params.stem, 0).encode()
        self.folder = home(self.params.stem, out)

    @property
    def state(self) -> dict:
        return {"serial": self.serial, "busy": self.busy, "problems": self.problems}

    def follow(self, ended: threading.Event) -> None:
        """Make a page, then another at every change of the files, until `ended`."""
        seen = None
        while not ended.is_set():
            if (now := stamps(self.params)) != seen:
                seen = now
                self.make(lambda seen=seen: ended.is_set() or stamps(self.params) != seen)
            ended.wait(EVERY)

    def make(self, outdated: Callable[[], bool] = lambda: False) -> None:
        """A page with the bends that are known, then one with all, unless that is `outdated` before."""
        def note(line: str) -> None:
            if outdated():
                raise _OutdatedError
            self._note(line)

        try:
            if self._made(self._note, known=True):
                self._made(note, known=False)
        except _OutdatedError:
            pass
        except InputError as error:
            self.problems = [str(problem) for problem in error.problems]
        except (HandgenError, OSError) as error:
            self.problems = [str(error)]
        except Exception as error:
            # Whatever went wrong, the next save gets its page.
            traceback.print_exc()
            self.problems = [f"{OURS}{type(error).__name__}: {error}"]
        self.busy = ""

    def _made(self, note: Callable[[str], None], known: bool) -> bool:
        """Whether bends are left to solve."""
        note("Making the page anew." if known else "Bending the fingers that changed.")
        found = compose(self.params, self.out, workers=self.workers, progress=note, known=known,
                        serial=self.serial + 1)
        self.page, self.folder, self.problems = found.content, home(found.name, self.out), []
        self.serial += 1
        self.say(f"page {self.serial}: {len(found.content) / 1e6:.1f} MB, {found.findings} findings")
        return known and bool(found.missing)

    def _note(self, line: str) -> None:
        self.busy = line


def stamps(params: Path) -> list[tuple[str, int, int]]:
    """Path, time and size of the file and of all that it extends; a file that is missing has none."""
    found, path = [], params
    for _ in range(LONGEST_CHAIN):
        try:
            status = path.stat()
            found.append((str(path), status.st_mtime_ns, status.st_size))
            base = yaml.safe_load(path.read_text(encoding="utf-8")).get("extends")
            path = path.parent / base
        except (OSError, ValueError, TypeError, AttributeError, yaml.YAMLError):
            break
    return found


class Handler(BaseHTTPRequestHandler):
    """GET and HEAD of the page, its state, and files in the hand's folder."""

    protocol_version = "HTTP/1.1"
    server: Server

    def do_GET(self) -> None:
        if self.headers.get("Host") not in self.server.names:
            # A foreign page that was given this machine's address by name service.
            return self._send(HTTPStatus.FORBIDDEN, b"not from here", "text/plain")
        path = unquote(urlsplit(self.path).path)
        if path == "/":
            return self._send(HTTPStatus.OK, self.server.maker.page, "text/html; charset=utf-8")
        if path == "/state":
            return self._send(HTTPStatus.OK, json.dumps(self.server.maker.state).encode(), "application/json")
        file = inside(self.server.maker.folder, path)
        if file is None:
            return self._send(HTTPStatus.NOT_FOUND, b"not here", "text/plain")
        kind = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
        return self._send(HTTPStatus.OK, file.read_bytes(), kind, POLICY)

    def do_HEAD(self) -> None:
        self.do_GET()

    def _send(self, status: HTTPStatus, content: bytes, kind: str, policy: str = "") -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        if policy:
            self.send_header("Content-Security-Policy", policy)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def log_message(self, *_) -> None:
        """Silent: the terminal tells of pages, not of requests."""


def inside(folder: Path, path: str) -> Path | None:
    """The file of `folder` that a request's `path` names; None for anything else, hidden files among it."""
    steps = path.strip("/").split("/")
    if any(step in ("", ".", "..") or step.startswith(".") or "\\" in step or "\0" in step for step in steps):
        return None
    try:
        root = folder.resolve(strict=True)
        file = root.joinpath(*steps).resolve(strict=True)
    except (OSError, ValueError):
        return None
    return file if file.is_relative_to(root) and file.is_file() else None


class Server(ThreadingHTTPServer):
    """On the loopback address, at `port` (0: any that is free).

    Raises:
        InputError: the port is taken.
    """

    daemon_threads = True

    def __init__(self, maker: Maker, port: int = PORT):
        self.maker = maker
        try:
            super().__init__((HOST, port), Handler)
        except OSError as error:
            raise InputError([Problem("command line", "--port", port, error.strerror or str(error),
                                      "a free port, or 0 for any")]) from error
        self.names = {f"{host}:{self.server_port}" for host in (HOST, "localhost")}

    def handle_error(self, request, client_address) -> None:
        """A reader that leaves before the page has gone through is no news for the terminal."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    @property
    def address(self) -> str:
        return f"http://{HOST}:{self.server_port}/"


def view(params: str | os.PathLike, out: str | os.PathLike | None = None, port: int = PORT, *,
         workers: int | None = None, progress: Callable[[str], None] = lambda line: None) -> None:
    """Serve the page of `params` until interrupted.

    Raises:
        InputError: there is no such file, or the port is taken.
    """
    if not Path(params).is_file():
        raise InputError([Problem(str(params), "", None, "there is no such file")])
    maker = Maker(params, out, workers=workers, say=progress)
    with Server(maker, port) as server:
        ended = threading.Event()
        follower = threading.Thread(target=maker.follow, args=(ended,), daemon=True)
        follower.start()
        progress(f"{server.address} shows {params}; Ctrl+C ends")
        with contextlib.suppress(KeyboardInterrupt):
            server.serve_forever()
        ended.set()
        follower.join(GRACE)
