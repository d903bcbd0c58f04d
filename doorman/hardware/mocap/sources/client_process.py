"""The process of a cameras' client: started, looked after, and ended."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from typing import IO

from doorman.hardware.mocap.connection import CamerasLink

_KEPT = 300
"""Characters of its last words that are kept."""
_PATIENCE = 1.0
"""For a killed process to be gone [s]."""


class ClientProcess:
    """Runs the client from its making until `close`; ends with the thread that made it."""

    def __init__(self, link: CamerasLink, port: int, rate: float) -> None:
        self._words: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  # open as long as the process
        module = "doorman.hardware.mocap.sources.client"
        settings = [f"{key}={value}" for key, value in link.settings.items()]
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, link.kind, str(port), repr(rate), *settings],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._words,
        )  # fmt: skip

    @property
    def last_words(self) -> str | None:
        """Why it has ended; None while it runs."""
        code = self._process.poll()
        if code is None:
            return None
        self._words.seek(0)
        lines = self._words.read().decode(errors="replace").strip().splitlines()
        return (lines[-1] if lines else f"it ended with status {code}")[:_KEPT]

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait(_PATIENCE)
        self._words.close()
