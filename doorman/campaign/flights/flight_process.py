"""Starts the process that flies, hands it orders, waits for no longer than allowed, and tells how it died."""

from __future__ import annotations

import json
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping
from contextlib import ExitStack
from typing import IO, Any

from doorman.resources import own_process

_ONE_THREAD = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
)  # fmt: skip
"""Every flight process has one thread: as many as cores share the machine without getting into each other's way."""
ATTEMPTS = 3
"""How often a flight is tried whose worker, process or disk fails: that says nothing about the flight."""
_PREPARATION_TIME = 3600.0
"""Longest time for compiling everything, and for waiting while another flight process does [s]."""
_NOTHING = object()
_LAST_LINES = 5
"""Lines that are kept of what a flight process printed before it died."""


class FlightProcess:
    def __init__(self, module: str = "doorman.campaign.flights.flight_program") -> None:
        self._module = module
        self._process: subprocess.Popen[str] | None = None
        self._prepared_for: object = _NOTHING
        self._answers: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._held = ExitStack()  # what ends with the process

    def fly(self, order: dict[str, Any], files: Mapping[str, str], time_out: float) -> dict[str, Any]:
        if self._process is None:
            try:
                self._start()
            except OSError as error:
                return lost(f"no process could be started: {error.strerror or error}")
        if self._prepared_for != order.get("files"):
            ready = self._ask({**order, "prepare": True, "contents": dict(files)}, _PREPARATION_TIME)
            if self._process is None or ready.get("lost"):
                return ready
            # where that failed, this flight will fail too, and the next one prepares
            self._prepared_for = order.get("files") if ready["error"] is None else _NOTHING
        return self._ask(order, time_out)

    def close(self) -> None:
        """Let the flight process go, whatever it does; may be called twice."""
        self._process = None
        self._held.close()

    def _start(self) -> None:
        with ExitStack() as held:
            folder = tempfile.TemporaryDirectory(prefix="doorman-flights-", ignore_cleanup_errors=True)
            self._printed = held.enter_context(tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace"))
            process = subprocess.Popen(
                [sys.executable, "-m", self._module], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._printed,
                env=own_process() | dict.fromkeys(_ONE_THREAD, "1"), cwd=held.enter_context(folder), text=True,
                encoding="utf-8", start_new_session=True,
            )  # fmt: skip
            held.enter_context(process)  # closes its streams
            held.callback(process.wait)
            held.callback(process.kill)  # the last one first
            self._held = held.pop_all()
        self._process, self._answers, self._prepared_for = process, queue.SimpleQueue(), _NOTHING
        threading.Thread(target=_read, args=(process.stdout, self._answers), daemon=True).start()

    def _ask(self, order: dict[str, Any], time_out: float) -> dict[str, Any]:
        process = self._process
        assert process is not None and process.stdin is not None, "there is a flight process to ask"
        try:
            process.stdin.write(json.dumps(order) + "\n")
            process.stdin.flush()
            line = self._answers.get(timeout=time_out)
        except queue.Empty:
            self.close()
            return failed(f"timed out after {time_out:g} s of wall-clock time")
        except OSError:
            line = None
        if line is None:
            if self._process is None:
                return lost("closed by the campaign")
            words = f"the process died with status {process.wait()}: {self._last_words()}"
            self.close()
            return lost(words)
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _last_words(self) -> str:
        self._printed.seek(0)
        return " | ".join(self._printed.read().splitlines()[-_LAST_LINES:])


class FlightProcesses:
    """One flight process for every thread that flies."""

    def __init__(self) -> None:
        self._all: dict[int, FlightProcess] = {}
        self._lock = threading.Lock()
        self.over = False  # whether no flight is begun any more

    def mine(self) -> FlightProcess:
        """Process of the calling thread."""
        with self._lock:
            thread = threading.get_ident()
            if thread not in self._all:
                self._all[thread] = FlightProcess()
            return self._all[thread]

    def close(self) -> None:
        with self._lock:
            self.over = True
            for process in self._all.values():
                process.close()


def failed(error: str) -> dict[str, Any]:
    """An answer in place of a flight process's, for a flight that failed."""
    return {"summary": None, "error": error, "wall_time_s": None, "kernels_compiled": 0}


def lost(error: str) -> dict[str, Any]:
    return {**failed(error), "lost": True}


def _read(stream: IO[str], answers: queue.SimpleQueue[str | None]) -> None:
    for line in stream:
        answers.put(line)
    answers.put(None)
