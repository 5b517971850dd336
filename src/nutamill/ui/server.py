"""The server of the page: loopback only, a token in its address, one folder."""

import secrets
import sys
import traceback
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlsplit

from nutamill.base.errors import CaseError, DamagedError, Fault, MillError
from nutamill.ui.answers import Answer, Answers, json_answer
from nutamill.ui.folder import Folder
from nutamill.ui.guard import Guard

LOOPBACK = "127.0.0.1"
"""The address that only this machine reaches."""
TOKEN_BYTES = 32
"""Random bytes of a token [1]."""
SILENCE = 30.0
"""Time after which a connection without a request is closed [s]."""
HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "SAMEORIGIN",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}
"""Headers of every answer: nothing is stored, nothing leaves, no other page frames or reads it."""


class Server(ThreadingHTTPServer):
    """Serves one folder until it is closed.

    Parameters
    ----------
    folder : the folder of cases and results
    port : port on loopback; a free one for 0

    Raises
    ------
    CaseError : no such folder, or the port is taken
    """

    daemon_threads = True

    def __init__(self, folder: str | Path, port: int = 0):
        self.answers = Answers(Folder(folder))
        try:
            super().__init__((LOOPBACK, port), Handler)
        except OSError as error:
            what = f"port {port} cannot be used: {error.strerror}"
            raise CaseError(Fault("--port", what, "Leave it out, and a free one is taken")) from None
        self.guard = Guard(self.server_port, secrets.token_urlsafe(TOKEN_BYTES))

    @property
    def address(self) -> str:
        """The address of the page, with its token."""
        return f"http://{LOOPBACK}:{self.guard.port}/{self.guard.token}/"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print a defect. A browser that has gone is none."""
        if not isinstance(sys.exception(), OSError):
            traceback.print_exc()

    def server_close(self) -> None:
        """Close the server, stop its runs and wait until they have saved."""
        super().server_close()
        self.answers.runs.end()


class Handler(BaseHTTPRequestHandler):
    """Answers one connection."""

    server: Server
    protocol_version = "HTTP/1.1"
    server_version = "nutamill"
    sys_version = ""
    timeout = SILENCE

    def do_GET(self) -> None:
        """Answer a request without a body."""
        self._answer("GET")

    def do_POST(self) -> None:
        """Take and answer a request with a body."""
        self._answer("POST")

    def _answer(self, method: str) -> None:
        refused = self.server.guard.refusal(method, self.path, self.headers)
        if refused is not None:
            self.close_connection = True  # a body that is not read must not count as the next request
            self._send(json_answer({"error": refused.why}, refused.status))
            return
        body = self.rfile.read(int(self.headers["Content-Length"])) if method == "POST" else b""
        try:
            answer = self._admitted(method, body)
        except MillError as error:
            missing = isinstance(error, (CaseError, DamagedError))
            status = HTTPStatus.BAD_REQUEST if missing else HTTPStatus.CONFLICT
            answer = json_answer({"error": str(error)}, status)
        except Exception:
            traceback.print_exc()  # a defect: the terminal shows it, the page goes on
            answer = json_answer({"error": "failed, see the terminal"}, HTTPStatus.INTERNAL_SERVER_ERROR)
        self._send(answer)

    def _admitted(self, method: str, body: bytes) -> Answer:
        """Return the answer to a request that is admitted."""
        parts = urlsplit(self.path)
        name = parts.path.split("/", 2)[2] if parts.path.count("/") > 1 else "/"
        answers = self.server.answers
        if method == "POST":
            answer = answers.performed(name, body)
        else:
            answer = answers.asked(name, dict(parse_qsl(parts.query)))
        return answer or json_answer({"error": "there is nothing here"}, HTTPStatus(404))

    def _send(self, answer: Answer) -> None:
        self.send_response(answer.status)
        self.send_header("Content-Type", f"{answer.kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(answer.body)))
        self.send_header("Content-Security-Policy", answer.policy)
        for name, value in HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(answer.body)

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing: addresses hold the token."""
