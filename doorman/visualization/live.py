"""Live view: a page on this machine that shows a flight while it is flown.

The flight hands over its messages and goes on; a thread per browser sends what was drawn since. No browser, a slow one or one
that leaves does not change the flight. Pages of other sites get nothing: a request must ask for this machine by its own name, and
come from this page.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Mapping
from email.message import Message
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from doorman.copying import Uncopied
from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.visualization.scene.drawing import Drawing
from doorman.visualization.scene.moments import FRAMES_PER_SECOND, CurrentMoment
from doorman.visualization.scene.page import page

_HOST = "127.0.0.1"
_NAMES = (_HOST, "localhost", "[::1]")
"""Names by which a browser on this machine, or at the end of a tunnel to it, asks for the page."""
_PATH = "/frames"
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
}
"""With every answer: no other site keeps, frames or embeds it."""


class LiveView(Uncopied):
    """Serves the page of a flight that is flown now.

    `with LiveView(model) as view:` starts and stops the server; give `view.listen` to the recorder of the flight. A browser
    that comes late gets everything from the start.

    Args:
        model: Model of the scenario.
        title: Heading of the page.
        port: On the loopback interface; any that is free if 0.
    """

    def __init__(self, model: Model, title: str, port: int = 0) -> None:
        self._drawing = Drawing(model)
        self._current = CurrentMoment()
        self._next = 0.0
        self._frames: list[str] = []
        self._ended = False
        self._changed = threading.Condition()
        self._seen_to_the_end = 0
        self._page = page(title, self._drawing.scene(), [], live=_PATH).encode()
        self._port = port
        self._server: ThreadingHTTPServer | None = None

    @property
    def url(self) -> str:
        """Address of the page.

        Raises:
            DoormanError: if the view is not open.
        """
        if self._server is None:
            raise DoormanError("the live view is not open", field="url", allowed="within `with view:`")
        return f"http://{_HOST}:{self._server.server_address[1]}/"

    def listen(self, topic: str, time: float, fields: Mapping[str, Any]) -> None:
        """Take in a message of the flight; draws a frame 30 times per second of flight.

        Args:
            topic: Its topic.
            time: Its time [s].
            fields: Its values.
        """
        moment = self._current.update(topic, time, fields)
        if moment is None or time < self._next - 1e-6:
            return
        self._next = max(self._next + 1.0 / FRAMES_PER_SECOND, time)
        frame = json.dumps(self._drawing.frame(moment), allow_nan=False, separators=(",", ":"))
        with self._changed:
            self._frames.append(frame)
            self._changed.notify_all()

    def end(self, patience: float = 0.0) -> bool:
        """The flight is over.

        Args:
            patience: How long to wait for a browser that has everything [s].

        Returns:
            Whether there was one.
        """
        deadline = time.monotonic() + patience
        with self._changed:
            self._ended = True
            self._changed.notify_all()
            while not self._seen_to_the_end and (left := deadline - time.monotonic()) > 0.0:
                self._changed.wait(left)
            return self._seen_to_the_end > 0

    def __enter__(self) -> LiveView:
        try:
            self._server = ThreadingHTTPServer((_HOST, self._port), self._handler())
        except OSError as error:
            raise DoormanError(
                f"the live view cannot be served: {error.strerror}",
                field="port", given=self._port, allowed="a free port",
            ) from error  # fmt: skip
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, args=(0.1,), name="live view", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self.end()
        if self._server is not None:
            self._server.shutdown()
            self._server.server_close()
            self._server = None

    def _batches(self, most: int = 300, silence: float = 0.5) -> Any:
        """Frames as they come, as events; ends with the flight. A thread that is silent looks whether the view is closed."""
        sent = 0
        while True:
            with self._changed:
                if sent == len(self._frames) and not self._ended:
                    self._changed.wait(silence)
                batch, ended = self._frames[sent : sent + most], self._ended
            sent += len(batch)
            if batch:
                yield f"data: [{','.join(batch)}]\n\n"
            elif ended:
                yield "event: end\ndata: \n\n"
                return
            else:
                yield ": nothing new\n\n"

    def _handler(self) -> type[BaseHTTPRequestHandler]:
        view = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                if not _is_ours(self.headers):
                    self.send_error(403, "Not a request of this page")
                elif self.path == "/":
                    self._answer("text/html; charset=utf-8")
                    self.wfile.write(view._page)
                elif self.path == _PATH:
                    self._answer("text/event-stream")
                    self._stream()
                else:
                    self.send_error(404)

            def _answer(self, kind: str) -> None:
                self.send_response(200)
                self.send_header("Content-Type", kind)
                for name, value in _HEADERS.items():
                    self.send_header(name, value)
                self.end_headers()

            def _stream(self) -> None:
                try:
                    for batch in view._batches():
                        self.wfile.write(batch.encode())
                        self.wfile.flush()
                except OSError:
                    return  # the browser left
                with view._changed:
                    view._seen_to_the_end += 1
                    view._changed.notify_all()

            def log_message(self, format: str, *args: Any) -> None:
                pass

        return Handler


def _is_ours(headers: Message) -> bool:
    """Whether a request comes from this page, or from somebody who typed its address."""
    # The name in `Host` tells apart a site whose name was made to point at this machine; `Origin` and `Sec-Fetch-Site` name the
    # page that asks. The port may be that of a tunnel.
    hosts, origins = headers.get_all("Host", []), headers.get_all("Origin", [])
    if len(hosts) != 1 or _without_port(hosts[0]) not in _NAMES:
        return False
    if any(origin.lower() != f"http://{hosts[0].lower()}" for origin in origins):
        return False
    embedded = headers.get("Sec-Fetch-Dest", "document") != "document"
    return not (embedded and headers.get("Sec-Fetch-Site") in ("cross-site", "same-site"))


def _without_port(host: str) -> str:
    name, colon, port = host.strip().lower().rpartition(":")
    return name if colon and port.isdecimal() else host.strip().lower()
