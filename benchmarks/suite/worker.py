"""Process of one solver: answers requests over a pipe, on the one core that all solvers share.

Run by `suite.process`: python -m suite.worker <name> <core> <file descriptor in> <file descriptor out>
"""

from __future__ import annotations

import os
import pickle
import resource
import sys
import time
import traceback
from collections.abc import Sequence
from typing import Any, BinaryIO

from suite.peers import ENTRIES
from suite.peers.interface import Peer
from suite.task import Answer, Array, Task, Timing


class Worker:
    """One solver, set up for any number of tasks."""

    def __init__(self, name: str, core: int) -> None:
        self._entry, self._core = ENTRIES[name], core
        self._peers: dict[str, Peer] = {}

    def prepare(self, task: Task) -> float:
        """Set the solver up, compilation included, on any core; solve once, so that nothing is done for the first time.

        Returns:
            Seconds until the first solve.
        """
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
        started = time.perf_counter()
        peer = self._entry.load()(task)
        seconds = time.perf_counter() - started
        peer.prepare_cold(task.start_state)
        peer.solve()
        os.sched_setaffinity(0, {self._core})
        self._peers[task.name] = peer
        return seconds

    def cold(self, task: str, state: Array, repeats: int) -> tuple[list[Timing], Answer]:
        """Solve from hover inputs some times in a row; the time of every solve, and the last answer."""
        peer, timings = self._peers[task], []
        for _ in range(repeats):
            peer.prepare_cold(state)
            timings.append(_timed(peer))
        return timings, peer.answer()

    def replan(self, task: str, states: Sequence[Array]) -> list[tuple[Timing, Answer]]:
        """One iteration at each state, each from the shifted answer before."""
        peer, results = self._peers[task], []
        for state in states:
            peer.prepare_replan(state)
            timing = _timed(peer)
            results.append((timing, peer.answer()))
        return results

    def drop(self, task: str) -> None:
        """Let go of what was set up for a task."""
        self._peers.pop(task, None)


def _timed(peer: Peer) -> Timing:
    interruptions = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw
    on_core = time.process_time()
    started = time.perf_counter()
    peer.solve()
    seconds = time.perf_counter() - started
    on_core = time.process_time() - on_core
    interrupted = resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw > interruptions
    own = peer.own_seconds()
    return Timing(seconds, on_core, interrupted) if own is None else Timing(own, min(own, on_core), interrupted)


def serve(worker: Worker, requests: BinaryIO, replies: BinaryIO) -> None:
    """Answer requests until the pipe is closed; an exception goes back as its type and text."""
    while True:
        try:
            method, arguments = pickle.load(requests)
        except EOFError:
            return
        reply: tuple[bool, Any]
        try:
            reply = (True, getattr(worker, method)(*arguments))
        except Exception as error:  # whatever a peer raises is a result of the comparison
            traceback.print_exc()
            reply = (False, f"{type(error).__name__}: {error}")
        pickle.dump(reply, replies)
        replies.flush()


if __name__ == "__main__":
    name, core, incoming, outgoing = sys.argv[1:]
    with os.fdopen(int(incoming), "rb") as requests, os.fdopen(int(outgoing), "wb") as replies:
        serve(Worker(name, int(core)), requests, replies)
