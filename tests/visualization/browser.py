"""A real browser without a window, driven by the DevTools protocol, with the websocket client that meshcat's tornado brings."""

from __future__ import annotations

import asyncio
import base64
import io
import itertools
import json
import os
import shutil
import subprocess
import time
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tornado.websocket import websocket_connect

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = (
    "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
    "--disable-extensions", "--disable-background-networking", "--remote-debugging-port=0", "--window-size=640,480",
)  # fmt: skip
PATIENCE = 60.0
"""For whatever the browser is asked [s]."""


def find_browser() -> str:
    """Path of a browser; without one the test fails."""
    given = os.environ.get("DOORMAN_BROWSER")
    found = given or next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        pytest.fail("the page is tested in a real browser: apt install chromium, or name one in DOORMAN_BROWSER")
    return found


class Browser:
    """One page in a browser of its own.

    Args:
        folder: For the browser's profile.
    """

    def __init__(self, folder: Path) -> None:
        self.errors: list[str] = []
        """What the page's scripts did not catch."""
        self._ids = itertools.count(1)
        self._loop = asyncio.new_event_loop()
        self._process = subprocess.Popen(
            [find_browser(), *OPTIONS, f"--user-data-dir={folder}", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self._socket: Any = None
        try:
            self._attach(folder / "DevToolsActivePort")
        except BaseException:
            self.close()
            raise

    def _attach(self, port_file: Path) -> None:
        self.wait_for(lambda: port_file.is_file() and port_file.read_text().count("\n") >= 1, "the browser to start")
        port = port_file.read_text().split()[0]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list", timeout=PATIENCE) as answer:
            address = next(one for one in json.load(answer) if one["type"] == "page")["webSocketDebuggerUrl"]
        self._socket = self._run(self._connect(address))
        self.call("Runtime.enable")
        self.call("Page.enable")

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        self._process.terminate()
        self._process.wait(PATIENCE)
        self._loop.run_until_complete(asyncio.sleep(0.1))
        self._loop.close()

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        number = next(self._ids)
        self._run(self._send({"id": number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self._run(self._receive()))
            if message.get("method") == "Runtime.exceptionThrown":
                details = message["params"]["exceptionDetails"]
                self.errors.append(details.get("exception", {}).get("description", details["text"]))
            if message.get("id") == number:
                assert "error" not in message, message
                return dict(message["result"])

    def open(self, address: str) -> None:
        """Load a page, up to the first picture."""
        self.call("Page.navigate", url=address)
        self.wait_for(lambda: self.evaluate("document.readyState") == "complete", "the page to load")
        self.settle()

    def evaluate(self, expression: str) -> Any:
        """Value of an expression in the page."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def settle(self) -> None:
        """Wait until what was asked for is drawn."""
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def click(self, selector: str, share: float = 0.5) -> None:
        """Press the mouse on an element, at a share of its width."""
        box = self.evaluate(f"(({{x, y, width, height}}) => [x, y, width, height])"
                            f"(document.querySelector('{selector}').getBoundingClientRect())")  # fmt: skip
        where = {"x": box[0] + share * box[2], "y": box[1] + 0.5 * box[3], "button": "left", "clickCount": 1}
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, **where)
        self.settle()

    def picture(self) -> np.ndarray:
        """What is seen, shape (height, width, 3), 0 to 255."""
        png = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        with Image.open(io.BytesIO(png)) as image:
            return np.asarray(image.convert("RGB")).astype(int)

    def wait_for(self, condition: Any, what: str) -> None:
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline and self._process.poll() is None, f"waited in vain for {what}"
            time.sleep(0.05)

    @staticmethod
    async def _connect(address: str) -> Any:
        return await websocket_connect(address, max_message_size=100_000_000)

    async def _send(self, message: dict[str, Any]) -> None:
        await self._socket.write_message(json.dumps(message))

    async def _receive(self) -> Any:
        return await self._socket.read_message()

    def _run(self, awaitable: Any) -> Any:
        async def bounded() -> Any:
            return await asyncio.wait_for(awaitable, PATIENCE)

        return self._loop.run_until_complete(bounded())
