"""The other end of a worker: starts it, asks it, and gives up on it when it takes too long."""

from __future__ import annotations

import os
import pickle
import select
import subprocess
import time
from pathlib import Path
from typing import Any

from suite.task import Answer, Array, Task, Timing

ROOT = Path(__file__).parents[2]
SINGLE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


def surroundings(*first: Path) -> dict[str, str]:
    """Environment of a child: one thread, and the paths on which it finds what this process finds.

    Args:
        first: Folders to look into before all others.
    """
    given = [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path]
    paths = [*map(str, first), *map(os.path.abspath, given), str(ROOT)]
    return {**os.environ, **SINGLE_THREAD, "PYTHONPATH": os.pathsep.join(paths)}


class PeerError(Exception):
    """A worker failed, or took too long; the message is the peer's own."""


class Process:
    """A solver in a process of its own.

    Args:
        name: Of the solver, a key of `suite.peers.ENTRIES`.
        python: Interpreter of the environment that has it.
        core: Core on which it solves.
        folder: Where its log and its generated code go.
    """

    def __init__(self, name: str, python: Path, core: int, folder: Path) -> None:
        self.name = name
        folder.mkdir(parents=True, exist_ok=True)
        self._log = folder / "log.txt"
        to_worker, from_here = os.pipe()
        from_worker, to_here = os.pipe()
        environment = surroundings(ROOT / "benchmarks")
        with self._log.open("w", encoding="utf-8") as log:
            self._process = subprocess.Popen(
                [python, "-m", "suite.worker", name, str(core), str(to_worker), str(to_here)],
                stdin=subprocess.DEVNULL, stdout=log, stderr=log, cwd=folder, env=environment,
                pass_fds=(to_worker, to_here),
            )  # fmt: skip
        os.close(to_worker)
        os.close(to_here)
        self._requests, self._replies = os.fdopen(from_here, "wb"), os.fdopen(from_worker, "rb")

    @property
    def ended(self) -> bool:
        """Whether the process is gone."""
        return self._process.poll() is not None

    def begin(self, method: str, *arguments: Any) -> None:
        """Send a request without waiting."""
        try:
            pickle.dump((method, arguments), self._requests)
            self._requests.flush()
        except BrokenPipeError:
            pass  # `finish` finds the end of the other pipe and says why

    def finish(self, timeout: float) -> Any:
        """Wait for the reply to the last request.

        Raises:
            PeerError: if the worker raised, ended or did not reply in time; one that did not reply is ended.
        """
        deadline = time.monotonic() + timeout
        readable, _, _ = select.select([self._replies], [], [], max(deadline - time.monotonic(), 0.0))
        if not readable:
            self.close()
            raise PeerError(f"no reply within {timeout:g} s")
        try:
            succeeded, value = pickle.load(self._replies)
        except EOFError:
            status = self._process.wait(timeout=10.0)
            lines = self._log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
            raise PeerError(f"the process ended with status {status}: {lines[-1] if lines else ''}") from None
        if not succeeded:
            raise PeerError(value)
        return value

    def prepare(self, task: Task, timeout: float = 600.0) -> float:
        """Set the solver up; seconds that took."""
        self.begin("prepare", task)
        seconds: float = self.finish(timeout)
        return seconds

    def cold(self, task: str, state: Array, repeats: int, timeout: float = 120.0) -> tuple[list[Timing], Answer]:
        """Solve from hover inputs; the time of each repetition and the last answer."""
        self.begin("cold", task, state, repeats)
        result: tuple[list[Timing], Answer] = self.finish(timeout)
        return result

    def replan(self, task: str, states: list[Array], timeout: float = 120.0) -> list[tuple[Timing, Answer]]:
        """One iteration at each state; time and answer of each."""
        self.begin("replan", task, states)
        result: list[tuple[Timing, Answer]] = self.finish(timeout)
        return result

    def drop(self, task: str) -> None:
        """Let go of a task."""
        self.begin("drop", task)
        self.finish(60.0)

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait(timeout=10.0)
        for pipe in (self._requests, self._replies):
            try:
                pipe.close()
            except BrokenPipeError:
                pass
