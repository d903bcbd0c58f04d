"""Time that passes only while everybody waits: threads, sockets and terminals stay real, and nobody waits in earnest.

`CLOCK` is the clock of this process. The thread that imports it takes part, and so does every thread that it makes. As long as
one of them computes, time stands still; once all of them wait, whoever can read something goes on, else time jumps to the next
moment that somebody waits for. A busy machine makes that slower, never different.
"""

from __future__ import annotations

import math
import select
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from doorman.clocks import Clock

REAL_PATIENCE = 0.01
"""Between two looks at files where nobody waits for a moment: then only another process can go on [s]."""


class _Wait:
    """A thread that waits: until a moment, for files, or to be woken."""

    def __init__(self, until: float, files: Sequence[int] = ()) -> None:
        self.until, self.files = until, files
        self.woken = False
        self.gate = threading.Lock()
        self.gate.acquire()


class VirtualClock(Clock):
    """Discrete events over real threads."""

    def __init__(self) -> None:
        self._now = time.monotonic()
        self._lock = threading.Lock()
        self._members = {threading.get_ident()}
        self._running = 1
        self._waits: list[_Wait] = []
        self._terminals: dict[int, bool] = {}

    # ------------------------------------------------------------ as of Clock

    def now(self) -> float:  # type: ignore[override]
        return self._now

    def nanoseconds(self) -> int:  # type: ignore[override]
        return round(self._now * 1e9)

    def raw(self) -> float:  # type: ignore[override]
        return self._now

    def sleep(self, duration: float) -> None:  # type: ignore[override]
        if duration < 0.0:
            raise ValueError("sleep length must be non-negative")
        self._wait(_Wait(self._moment(duration)))

    def reach(self, moment: float) -> None:
        if moment > self._now:
            self._wait(_Wait(moment))

    def readable(self, files: Sequence[Any], timeout: float) -> list[Any]:
        ready = select.select(files, [], [], 0.0)[0]
        if ready or timeout <= 0.0:
            return ready
        self._wait(_Wait(self._moment(timeout), [one if isinstance(one, int) else one.fileno() for one in files]))
        return select.select(files, [], [], 0.0)[0]

    def event(self) -> threading.Event:  # type: ignore[override]
        return VirtualEvent(self)

    def condition(self) -> threading.Condition:  # type: ignore[override]
        return VirtualCondition(self)

    def lock(self) -> VirtualLock:  # type: ignore[override]
        return VirtualLock(self)

    def thread(self, target: Callable[..., None], *args: Any, name: str | None = None) -> threading.Thread:
        return VirtualThread(self, target, args, name)

    # ------------------------------------------------------------ for what it makes

    def wait(self, woken_by: list[_Wait], timeout: float | None, happened: Callable[[], bool | None]) -> bool:
        """Wait to be woken; whether one was in time.

        Args:
            woken_by: Where those wait whom the same call wakes.
            timeout: [s].
            happened: Whether that is so already; called when nobody can miss being woken any more.
        """
        wait = _Wait(math.inf if timeout is None else self._moment(timeout))
        with self._lock:
            woken_by.append(wait)
        if not happened():
            self._wait(wait)
        with self._lock:
            if wait in woken_by:
                woken_by.remove(wait)
                return False
        return True

    def wake(self, waits: list[_Wait], count: int | None = None) -> None:
        """Let those go on who wait, and forget them."""
        if not waits:  # who comes now looks again before it waits
            return
        with self._lock:
            chosen = waits[:count]
            del waits[:count]
            self._wake(chosen)

    def join_in(self) -> None:
        """Count a thread that is about to start."""
        with self._lock:
            self._running += 1

    def began(self) -> None:
        """Know the thread that calls."""
        with self._lock:
            self._members.add(threading.get_ident())

    def leave(self) -> None:
        """Do without the thread that calls."""
        with self._lock:
            self._members.discard(threading.get_ident())
            self._running -= 1
        self._go_on()

    # ------------------------------------------------------------ inside

    def _moment(self, duration: float) -> float:
        """A later moment: no wait is so short that time stands still."""
        return max(self._now + duration, math.nextafter(self._now, math.inf)) if duration > 0.0 else self._now

    def _wake(self, waits: Iterable[_Wait]) -> None:
        for wait in waits:
            if not wait.woken:
                wait.woken = True
                self._running += 1
                wait.gate.release()

    def _wait(self, wait: _Wait) -> None:
        if threading.get_ident() not in self._members:
            raise RuntimeError(f"{threading.current_thread().name} takes no part in virtual time")
        with self._lock:
            self._waits.append(wait)
            self._running -= 1
        try:
            self._go_on()
            wait.gate.acquire()
        except BaseException:  # a signal's handler raises
            with self._lock:
                if not wait.woken:
                    wait.woken = True
                    self._running += 1
            raise
        finally:
            with self._lock:
                self._waits.remove(wait)

    def _go_on(self) -> None:
        """Where everybody waits, wake those whose turn it is."""
        while True:
            with self._lock:
                if self._running or not self._waits:
                    return
                waits = [wait for wait in self._waits if not wait.woken]
                moment = min(wait.until for wait in waits)
                # Nothing is under way: `send` on loopback returns when it has arrived, and `poll` has a terminal hand it on.
                ready = _ready(waits, 0.0 if moment < math.inf else REAL_PATIENCE)
                if not ready and moment < math.inf:
                    self._now = max(self._now, moment)
                    ready = [wait for wait in waits if wait.until <= self._now]
                if not ready and not any(wait.files for wait in waits):
                    raise RuntimeError("everybody waits for ever")
                self._wake(ready)


def _ready(waits: Iterable[_Wait], timeout: float) -> list[_Wait]:
    """Those that can read something, or whose file is gone."""
    watching = [wait for wait in waits if wait.files]
    poll, broken = select.poll(), set[int]()
    for file in {file for wait in watching for file in wait.files}:
        if file < 0:
            broken.add(file)
        else:
            poll.register(file, select.POLLIN)
    found = broken | {file for file, _ in poll.poll(0.0 if broken else timeout * 1e3)}
    return [wait for wait in watching if found.intersection(wait.files)]


class VirtualEvent(threading.Event):
    """An event that is waited for in virtual time."""

    def __init__(self, clock: VirtualClock) -> None:
        super().__init__()
        self._clock, self._waits = clock, list[_Wait]()

    def set(self) -> None:
        super().set()
        self._clock.wake(self._waits)

    def wait(self, timeout: float | None = None) -> bool:
        if self.is_set() or (timeout is not None and timeout <= 0.0):
            return self.is_set()
        self._clock.wait(self._waits, timeout, self.is_set)
        return self.is_set()


class VirtualCondition(threading.Condition):
    """A condition that is waited for in virtual time; its lock is real."""

    def __init__(self, clock: VirtualClock) -> None:
        super().__init__()
        self._clock, self._waits = clock, list[_Wait]()

    def wait(self, timeout: float | None = None) -> bool:
        if timeout is not None and timeout <= 0.0:
            return False
        try:
            return self._clock.wait(self._waits, timeout, self.release)
        finally:
            self.acquire()

    def wait_for(self, predicate: Callable[[], Any], timeout: float | None = None) -> Any:
        end = None if timeout is None else self._clock.now() + timeout
        while not (result := predicate()) and (end is None or self._clock.now() < end):
            self.wait(None if end is None else end - self._clock.now())
        return result

    def notify(self, n: int = 1) -> None:
        self._clock.wake(self._waits, n)

    def notify_all(self) -> None:
        self._clock.wake(self._waits)


class VirtualLock:
    """A lock whose owner may wait: meanwhile whoever wants it waits too. Its owner may take it again."""

    def __init__(self, clock: VirtualClock) -> None:
        self._clock, self._waits = clock, list[_Wait]()
        self._lock = threading.RLock()

    def acquire(self, blocking: bool = True, timeout: float = -1.0) -> bool:
        end = math.inf if timeout < 0.0 else self._clock.now() + timeout
        taken = False

        def take() -> bool:
            nonlocal taken
            taken = self._lock.acquire(blocking=False)
            return taken

        while not (taken or take()):
            if not blocking or self._clock.now() >= end:
                return False
            self._clock.wait(self._waits, None if end == math.inf else end - self._clock.now(), take)
        return True

    def release(self) -> None:
        self._lock.release()
        self._clock.wake(self._waits, 1)

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


class VirtualThread(threading.Thread):
    """A thread that takes part in virtual time."""

    def __init__(self, clock: VirtualClock, target: Callable[..., None], args: Sequence[Any], name: str | None) -> None:
        super().__init__(target=target, args=args, name=name, daemon=True)
        self._clock, self._over = clock, clock.event()

    def start(self) -> None:
        self._clock.join_in()
        super().start()

    def run(self) -> None:
        self._clock.began()
        try:
            super().run()
        finally:
            self._over.set()
            self._clock.leave()

    def join(self, timeout: float | None = None) -> None:
        if self._over.wait(timeout):
            super().join()


CLOCK = VirtualClock()


class Aside:
    """Something that is done beside a test, in virtual time.

    Args:
        task: What is done.
        after: How much later [s].
    """

    def __init__(self, task: Callable[[], Any], after: float = 0.0) -> None:
        self._task, self._after = task, after
        self._answer: Any = None
        self._error: BaseException | None = None
        self._thread = CLOCK.thread(self._run)
        self._thread.start()

    def _run(self) -> None:
        try:
            CLOCK.sleep(self._after)
            self._answer = self._task()
        except BaseException as error:  # raised again where the test asks for the answer
            self._error = error

    def result(self, timeout: float | None = None) -> Any:
        """Wait for its end, and return or raise what it did."""
        self._thread.join(timeout)
        if self._error is not None:
            raise self._error
        assert not self._thread.is_alive(), "not done in time"
        return self._answer
