"""The thread that owns the socket: it waits for packets and deadlines, and hands on the newest sample."""

from __future__ import annotations

import contextlib
import math
import os
import socket
from collections.abc import Callable, Mapping
from types import MappingProxyType

from doorman.background import InThread
from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.events import EventLog
from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.connection import CamerasLink, listen, parse_cameras
from doorman.hardware.mocap.datagrams.packets import LARGEST
from doorman.hardware.mocap.faults import MocapEvent, MocapFault
from doorman.hardware.mocap.pipeline import Pipeline
from doorman.hardware.mocap.poses.sample import PoseSample
from doorman.hardware.mocap.sources.client_process import ClientProcess

REOPEN_INTERVAL = 0.1
"""How often a socket that failed is opened again [s]."""
RESTART_INTERVAL = 1.0
"""How often a cameras' client that ended is started again [s]."""
INTERNAL_PAUSE = 0.001
"""After a failure, so that a lasting one does not take the processor from everybody [s]."""
LONGEST_WAIT = 0.1
"""The thread looks at its deadlines at least this often [s]."""
BATCH = 64
"""Datagrams that are read before deadlines are looked at: a flood must not hide them."""


class MocapWorker(InThread):
    """Receives until it is stopped."""

    def __init__(
        self, channel: socket.socket, config: MocapConfig, log: EventLog[MocapEvent], clock: Clock = REAL_TIME,
        beside: Mapping[str, MocapConfig] = MappingProxyType({}),
    ) -> None:  # fmt: skip
        super().__init__("mocap", clock)
        self._channel: socket.socket | None = channel
        self._config = config
        self._cameras = parse_cameras(config.connection)
        self._client: ClientProcess | None = None
        self._started = -math.inf
        self.client_words = ""  # why the cameras' client ended last
        self._pipeline = Pipeline(config, log)
        self._beside = {part: Pipeline(one, EventLog()) for part, one in beside.items()}
        self._all = self._pipeline, *self._beside.values()
        self._changed = clock.condition()
        self._wake_read, self._wake_write = os.pipe()

    @property
    def latest(self) -> PoseSample:
        """Newest measurement."""
        return self._pipeline.latest

    def latest_beside(self, part: str) -> PoseSample:
        """Newest measurement of a further object."""
        return self._beside[part].latest

    @property
    def pipeline(self) -> Pipeline:
        """To look at; only the thread may change it."""
        return self._pipeline

    def wait(self, condition: Callable[[Pipeline], bool], timeout: float) -> bool:
        """Wait until something is so."""
        with self._changed:
            return self._changed.wait_for(lambda: condition(self._pipeline), timeout)

    def _interrupt(self) -> None:
        os.write(self._wake_write, b"!")

    def _stuck(self) -> None:
        raise BackendError("the mocap receiver does not stop", field="mocap.connection", given=self._config.connection)

    def _end(self) -> None:
        os.close(self._wake_read)
        os.close(self._wake_write)

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                try:
                    self._turn()
                except Exception as error:  # the last line of defence: without the thread, no fault would be told
                    now = self._clock.now()
                    self._pipeline.book.strike(MocapFault.INTERNAL, now, f"{type(error).__name__}: {error}")
                    self._pause(INTERNAL_PAUSE)
                with self._changed:
                    self._changed.notify_all()
        finally:
            if self._channel is not None:
                self._channel.close()
            self._drop_client()

    def _turn(self) -> None:
        if self._channel is None:
            self._reopen()
        else:
            if self._cameras is not None:
                self._look_after_client(self._cameras, self._channel)
            self._receive(self._channel)
        for pipeline in self._all:
            pipeline.tick(self._clock.now())

    def _look_after_client(self, cameras: CamerasLink, channel: socket.socket) -> None:
        """Start the cameras' client, and start it again where it has ended; it ends with this thread."""
        words = None if self._client is None else self._client.last_words
        if words is not None:
            self.client_words = words
            self._pipeline.book.keep(MocapFault.CLIENT, True, self._clock.now(), f"{cameras.kind}: {words}")
        if (self._client is None or words is not None) and self._clock.now() - self._started > RESTART_INTERVAL:
            self._drop_client()
            self._client = ClientProcess(cameras, channel.getsockname()[1], self._config.rate)
            self._started = self._clock.now()
        elif words is None and self._clock.now() - self._started > RESTART_INTERVAL:
            self._pipeline.book.keep(MocapFault.CLIENT, False, self._clock.now())

    def _drop_client(self) -> None:
        """End the cameras' client, if there is one."""
        client, self._client = self._client, None
        if client is not None:
            client.close()

    def _receive(self, channel: socket.socket) -> None:
        """Wait for packets until the next deadline, and read what has come."""
        try:
            if self._await_packets(channel):
                for _ in range(BATCH):
                    datagram, sender = channel.recvfrom(LARGEST)
                    arrival = self._clock.now()  # before the other one: what comes between makes poses older, not newer
                    raw = self._clock.raw()
                    for pipeline in self._all:
                        pipeline.feed(datagram, sender, arrival, raw)
        except BlockingIOError:
            return
        except (OSError, ValueError) as error:  # ValueError: the socket is closed
            channel.close()
            self._channel = None
            self._drop_client()  # it sends to a port that is gone
            self._pipeline.book.keep(
                MocapFault.SOCKET, True, self._clock.now(), str(getattr(error, "strerror", None) or error)
            )

    def _await_packets(self, channel: socket.socket) -> bool:
        now = self._clock.now()
        patience = (
            min(self._pipeline.deadline(now) - now, LONGEST_WAIT) + 1e-4
        )  # a little more: the deadline has passed
        return channel in self._clock.readable((channel, self._wake_read), max(patience, 0.0))

    def _pause(self, duration: float) -> None:
        """Wait, but not past `stop`."""
        self._clock.readable([self._wake_read], duration)

    def _reopen(self) -> None:
        self._pause(REOPEN_INTERVAL)
        if self._stopping.is_set():
            return
        with contextlib.suppress(BackendError):  # not yet: tried again
            self._channel = listen(self._config.connection)
            self._pipeline.book.keep(MocapFault.SOCKET, False, self._clock.now(), "opened again")
