"""Mocap receiver: what a backend holds to know where the vehicle is, and the thread that owns the socket."""

from __future__ import annotations

import contextlib
import math
import socket
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from types import MappingProxyType

from doorman.background import EventLog, InThread
from doorman.clocks import BRIEFLY, LONGEST_WAIT, REAL_TIME, RESTART, Clock
from doorman.exceptions import BackendError, how_to_install
from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.connection import CamerasLink, ClientProcess, listen, parse_cameras
from doorman.hardware.mocap.faults import MocapEvent, MocapFault, MocapStatistics
from doorman.hardware.mocap.packets import LARGEST
from doorman.hardware.mocap.sample import PoseSample
from doorman.hardware.mocap.tracker import Pipeline

BATCH = 64
"""Datagrams that are read before deadlines are looked at: a flood must not hide them."""
Judge = Callable[[PoseSample], PoseSample]
"""What a pose is worth to whoever flies by it."""


class MocapReceiver(InThread):
    """The body's pose from cameras, received by a thread of its own: Vicon Tracker's stream, or whatever `connection` names.

    `read` returns the newest pose at once, with its age as of the call. The constructor touches no device. Whatever happens to
    the stream shows in samples and events; nothing raises but misuse.

    Args:
        config: Stream, object, frames and limits.
        clock: Clock of all its waits.
        beside: Further objects of the same stream, by what they are: the door's leaf and frame.
        judge: Returns every pose as it is to be used.
    """

    def __init__(
        self, config: MocapConfig, clock: Clock = REAL_TIME, beside: Mapping[str, MocapConfig] = MappingProxyType({}),
        judge: Judge = lambda pose: pose,
    ) -> None:  # fmt: skip
        super().__init__("mocap receiver", clock)
        self.config, self.beside, self._judge = config, beside, judge
        self._log = EventLog[MocapEvent]()
        self._cameras = parse_cameras(config.connection)
        self._changed = clock.condition()
        self._client: ClientProcess | None = None
        self._channel: socket.socket | None = None

    def open(self, timeout: float | None = None) -> None:
        """Listen, and wait for a steady pose at the configured rate.

        Args:
            timeout: How long to wait [s]; `config.open_timeout` if None.

        Raises:
            BackendError: if it is open already, the address cannot be listened on, the rate is another, or no pose comes; it
                says what comes instead. Or if the cameras need an extra that is not installed.
        """
        self._require_closed()
        if self._cameras is not None and find_spec("motioncapture") is None:
            raise BackendError(f"these cameras need the package motioncapture; {how_to_install('mocap')}",
                               field="mocap.connection", given=self.config.connection)  # fmt: skip
        super().open()
        try:
            self._await_pose(self.config.open_timeout if timeout is None else timeout)
        except BaseException:
            self.stop()
            raise

    def read(self) -> PoseSample:
        """Newest pose, at once. Look at `fresh` or `usable` before use.

        Raises:
            BackendError: if it is not open.
        """
        self._require_open()
        return self._judge(self._pipeline.at(self._clock.now()))

    def read_beside(self, part: str) -> PoseSample:
        """Newest pose of a further object, at once; what is wrong with it is in the sample alone.

        Args:
            part: One of `beside`.

        Raises:
            BackendError: if it is not open.
        """
        self._require_open()
        return self._beside[part].at(self._clock.now())

    def wait(self, sample: PoseSample, timeout: float) -> PoseSample:
        """Wait for a measurement that is newer than another.

        Args:
            sample: The other.
            timeout: How long to wait [s].

        Raises:
            BackendError: if none comes in time, or it is not open.
        """
        self._require_open()
        if not self._wait(lambda pipeline: pipeline.latest.count > sample.count, timeout):
            raise BackendError("no new pose", field="mocap", given=f"after {timeout:g} s")
        return self.read()

    def events(self) -> list[MocapEvent]:
        """Take what has happened since the last call, oldest first."""
        return self._log.take()

    @property
    def statistics(self) -> MocapStatistics:
        """How the stream ran since `open`.

        Raises:
            BackendError: if it is not open.
        """
        self._require_open()
        return self._pipeline.statistics()

    def stop(self) -> None:
        """End the thread and close the socket; may be called twice."""
        super().stop()

    def _wait(self, condition: Callable[[Pipeline], bool], timeout: float) -> bool:
        with self._changed:
            return self._changed.wait_for(lambda: condition(self._pipeline), timeout)

    def _await_pose(self, timeout: float) -> None:
        pipeline = self._pipeline
        self._wait(lambda one: one.ready or one.wrong_rate is not None or bool(self._client_words), timeout)
        if (rate := pipeline.wrong_rate) is not None:
            raise BackendError("the cameras send frames at another rate", field="mocap.rate", given=self.config.rate,
                               allowed=f"the stream's {rate:.1f} 1/s")  # fmt: skip
        if self._client_words or not pipeline.ready:
            why = self._client_words or pipeline.stream.diagnosis()
            raise BackendError(
                f"no pose of '{self.config.object_name}' within {timeout:g} s: {why}", field="mocap.connection",
                given=self.config.connection,
                allowed="the address that Tracker's UDP object stream is sent to, or cameras that can be reached",
            )  # fmt: skip

    # ------------------------------------------------------------ the thread

    def _begin(self) -> None:
        self._channel = listen(self.config.connection)
        self._pipeline = Pipeline(self.config, self._log)  # only the thread may change it
        self._beside = {part: Pipeline(one, EventLog()) for part, one in self.beside.items()}
        self._started, self._client_words = -math.inf, ""  # of the cameras' client, and why it ended last

    def _stuck(self) -> None:
        raise BackendError("the mocap receiver does not stop", field="mocap.connection", given=self.config.connection)

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                try:
                    self._turn()
                except Exception as error:  # the last line of defence: without the thread, no fault would be reported
                    now = self._clock.now()
                    self._pipeline.book.strike(MocapFault.INTERNAL, now, f"{type(error).__name__}: {error}")
                    self._stopping.wait(BRIEFLY)  # a failure that lasts must not take the whole processor
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
        for pipeline in (self._pipeline, *self._beside.values()):
            pipeline.tick(self._clock.now())

    def _look_after_client(self, cameras: CamerasLink, channel: socket.socket) -> None:
        """Start the cameras' client, and start it again where it has ended; it ends with this thread."""
        words, now = None if self._client is None else self._client.last_words, self._clock.now()
        if words is not None:
            self._client_words = words
            self._pipeline.book.keep(MocapFault.CLIENT, True, now, f"{cameras.kind}: {words}")
        due = now - self._started > RESTART
        if due and (self._client is None or words is not None):
            self._drop_client()
            self._client = ClientProcess(cameras, channel.getsockname()[1], self.config.rate)
            self._started = self._clock.now()
        elif due:
            self._pipeline.book.keep(MocapFault.CLIENT, False, now)

    def _drop_client(self) -> None:
        client, self._client = self._client, None
        if client is not None:
            client.close()

    def _receive(self, channel: socket.socket) -> None:
        """Wait for packets until the next deadline, and read what has come."""
        now = self._clock.now()
        patience = (
            min(self._pipeline.deadline(now) - now, LONGEST_WAIT) + 1e-4
        )  # a little more: the deadline has passed
        try:
            if not self._clock.readable((channel,), max(patience, 0.0)):
                return
            for _ in range(BATCH):
                datagram, sender = channel.recvfrom(LARGEST)
                arrival = self._clock.now()  # before the other one: what comes between makes poses older, not newer
                raw = self._clock.raw()
                for pipeline in (self._pipeline, *self._beside.values()):
                    pipeline.feed(datagram, sender, arrival, raw)
        except BlockingIOError:
            return
        except (OSError, ValueError) as error:  # ValueError: the socket is closed
            channel.close()
            self._channel = None
            self._drop_client()  # it sends to a port that is gone
            words = str(getattr(error, "strerror", None) or error)
            self._pipeline.book.keep(MocapFault.SOCKET, True, self._clock.now(), words)

    def _reopen(self) -> None:
        self._stopping.wait(LONGEST_WAIT)
        with contextlib.suppress(BackendError):  # not yet: tried again
            self._channel = listen(self.config.connection)
            self._pipeline.book.keep(MocapFault.SOCKET, False, self._clock.now(), "opened again")
