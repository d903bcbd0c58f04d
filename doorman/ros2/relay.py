"""Relay: poses of ROS 2 into the stream that cameras send, one publisher at a time."""

from __future__ import annotations

from collections import deque

from doorman.background import EventLog
from doorman.copying import Uncopied
from doorman.exceptions import BackendError
from doorman.hardware.mocap import MocapConfig, MocapEvent, MocapFault, PoseSender
from doorman.hardware.mocap.faults import FaultBook
from doorman.hardware.mocap.packets import MOST_ITEMS
from doorman.kinematics.quaternions import Quaternion, Vector


class PoseRelay(Uncopied):
    """Sends the poses of one publisher on. What it refuses it counts as the receiver of cameras does, which it tells."""

    # The first publisher that sends is the one, until it has been silent for as long as the receiver waits. Its frames are
    # numbered by their stamps; the receiver judges those.

    def __init__(self, name: str, target: tuple[str, int], rate: float) -> None:
        self._name, self._target, self._rate = name, target, rate
        self._log = EventLog[MocapEvent]()
        self._book = FaultBook(self._log, MocapConfig.hold)
        self._sender = PoseSender(target, rate)
        self._publisher: int | None = None
        self._heard = 0.0
        self._untold: deque[MocapFault] = deque(maxlen=MOST_ITEMS - 1)
        self.received = 0  # poses that were sent on

    @property
    def refused(self) -> int:
        """Poses that were not."""
        return self._book.counts.total()

    def events(self) -> list[MocapEvent]:
        return self._log.take()

    def take(self, publisher: int, position: Vector, quaternion: Quaternion, taken: float | None, now: float) -> None:
        if not self._welcome(publisher, now):
            self.refuse(MocapFault.FOREIGN, now, "a second publisher sends poses; they are left out")
            return
        taken = now if taken is None else taken
        try:
            self._send({self._name: (position, quaternion)}, taken)
            self.received += 1
        except BackendError as error:
            self.refuse(MocapFault.CORRUPT, now, str(error))
            self._send({}, taken)

    def refuse(self, fault: MocapFault, now: float, why: str) -> None:
        """Leave a pose out."""
        self._untold.append(fault)
        self._book.strike(fault, now, why)

    def tick(self, now: float) -> None:
        """Let faults end that have not struck for a while."""
        self._book.tick(now)

    def close(self) -> None:
        self._sender.close()

    def _send(self, poses: dict[str, tuple[Vector, Quaternion]], taken: float) -> None:
        if self._sender.send(poses, taken, tuple(self._untold)):
            self._untold.clear()

    def _welcome(self, publisher: int, now: float) -> bool:
        if self._publisher != publisher:
            if self._publisher is not None and now - self._heard < MocapConfig.silent_after:
                return False
            self._publisher = publisher
            self._sender.close()
            self._sender = PoseSender(self._target, self._rate)  # a stream of its own, as of other cameras
        self._heard = now
        return True
