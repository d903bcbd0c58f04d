"""Mocap receiver: what a backend holds to know where the vehicle is."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec
from types import MappingProxyType

from doorman.background import Opened
from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError, how_to_install
from doorman.hardware.events import EventLog
from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.connection import listen, parse_cameras
from doorman.hardware.mocap.faults import MocapEvent
from doorman.hardware.mocap.figures import MocapStatistics
from doorman.hardware.mocap.pipeline import Pipeline
from doorman.hardware.mocap.poses.sample import PoseSample
from doorman.hardware.mocap.worker import MocapWorker


class MocapReceiver(Opened):
    """The body's pose from cameras, received by a thread of its own: Vicon Tracker's stream, or whatever `connection` names.

    `read` returns the newest pose at once, with its age as of the call. The constructor touches no device. Whatever happens to
    the stream shows in samples and events; nothing raises but misuse.

    Args:
        config: Stream, object, frames and limits.
        clock: By which it waits.
        beside: Further objects of the same stream, by what they are: the door's leaf and frame.
    """

    def __init__(
        self, config: MocapConfig, clock: Clock = REAL_TIME, beside: Mapping[str, MocapConfig] = MappingProxyType({})
    ) -> None:
        self.config, self._clock, self.beside = config, clock, beside
        self._log = EventLog[MocapEvent]()
        self._worker: MocapWorker | None = None

    def open(self, timeout: float | None = None) -> None:
        """Listen, and wait for a steady pose at the configured rate.

        Args:
            timeout: How long to wait [s]; `config.open_timeout` if None.

        Raises:
            BackendError: if it is open already, the address cannot be listened on, the rate is another, or no pose comes; it
                says what comes instead. Or if the cameras need an extra that is not installed.
        """
        if self._worker is not None:
            raise BackendError("the mocap receiver is open already", allowed="stop() before another open()")
        if parse_cameras(self.config.connection) is not None and find_spec("motioncapture") is None:
            raise BackendError(f"these cameras need the package motioncapture; {how_to_install('mocap')}",
                               field="mocap.connection", given=self.config.connection)  # fmt: skip
        patience = self.config.open_timeout if timeout is None else timeout
        self._worker = MocapWorker(listen(self.config.connection), self.config, self._log, self._clock, self.beside)
        self._worker.open()
        try:
            self._await_pose(self._worker, patience)
        except BaseException:
            self.stop()
            raise

    def read(self) -> PoseSample:
        """Newest pose, at once. Look at `fresh` or `usable` before use.

        Raises:
            BackendError: if it is not open.
        """
        return self._as_of_now(self._opened())

    def read_beside(self, part: str) -> PoseSample:
        """Newest pose of a further object, at once; what is wrong with it is in the sample alone.

        Args:
            part: One of `beside`.

        Raises:
            BackendError: if it is not open.
        """
        config = self.beside[part]
        sample = self._opened().latest_beside(part)
        return sample.at(self._clock.now(), config.stale_after, config.prediction_limit)

    def wait(self, sample: PoseSample, timeout: float) -> PoseSample:
        """Wait for a measurement that is newer than another.

        Args:
            sample: The other.
            timeout: How long to wait [s].

        Raises:
            BackendError: if none comes in time, or it is not open.
        """
        worker = self._opened()
        if not worker.wait(lambda pipeline: pipeline.latest.count > sample.count, timeout):
            raise BackendError("no new pose", field="mocap", given=f"after {timeout:g} s")
        return self._as_of_now(worker)

    def events(self) -> list[MocapEvent]:
        """Take what has happened since the last call, oldest first."""
        return self._log.take()

    @property
    def statistics(self) -> MocapStatistics:
        """How the stream ran since `open`.

        Raises:
            BackendError: if it is not open.
        """
        return self._opened().pipeline.statistics()

    def stop(self) -> None:
        """End the thread and close the socket; may be called twice."""
        worker, self._worker = self._worker, None
        if worker is not None:
            worker.stop()

    def _await_pose(self, worker: MocapWorker, timeout: float) -> None:
        def decided(pipeline: Pipeline) -> bool:
            return pipeline.ready or pipeline.wrong_rate is not None or bool(worker.client_words)

        found = worker.wait(decided, timeout) and not worker.client_words
        rate = worker.pipeline.wrong_rate
        if rate is not None:
            raise BackendError("the cameras send frames at another rate", field="mocap.rate", given=self.config.rate,
                               allowed=f"the stream's {rate:.1f} 1/s")  # fmt: skip
        if not found:
            raise BackendError(
                f"no pose of '{self.config.object_name}' within {timeout:g} s: "
                f"{worker.client_words or worker.pipeline.diagnosis()}",
                field="mocap.connection",
                given=self.config.connection,
                allowed="the address that Tracker's UDP object stream is sent to, or cameras that can be reached",
            )

    def _as_of_now(self, worker: MocapWorker) -> PoseSample:
        sample = worker.latest
        return sample.at(self._clock.now(), self.config.stale_after, self.config.prediction_limit)

    def _opened(self) -> MocapWorker:
        if self._worker is None:
            raise BackendError("the mocap receiver is not open", allowed="open() before read()")
        return self._worker
