"""An emulated Vicon Tracker: it sends the UDP object stream of a body that its caller moves."""

from __future__ import annotations

import socket

from doorman.background import InThread
from doorman.clocks import REAL_TIME, Clock
from doorman.rig.emulators.mocap.stream import BodyPose, PoseSource, StreamFaults, TrackerSetup, TrackerStream

__all__ = ["BodyPose", "MocapEmulator", "PoseSource", "StreamFaults", "TrackerSetup", "TrackerStream"]

BEHIND = 0.5
"""A thread that was held up for longer leaves frames out instead of making up for them [s]."""


class MocapEmulator(InThread):
    """Tracker that exists only in software. The constructor opens nothing."""

    def __init__(
        self,
        source: PoseSource,
        setup: TrackerSetup | str,
        target: tuple[str, int] = ("127.0.0.1", 51001),
        clock: Clock = REAL_TIME,
    ) -> None:
        super().__init__("emulated mocap", clock)
        self.stream = TrackerStream(source, TrackerSetup(setup) if isinstance(setup, str) else setup)
        self.target = target
        self.sent = 0  # datagrams sent

    @property
    def faults(self) -> StreamFaults:
        """Faults of cameras, Tracker and network; may be switched while it runs."""
        return self.stream.faults

    def _run(self) -> None:
        exposure = self._clock.now()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as channel:
            channel.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
            while not self._stopping.is_set():
                now = self._clock.now()
                while exposure <= now:
                    if now - exposure <= BEHIND:
                        self.stream.expose(exposure)
                    else:
                        self.stream.skip()
                    exposure += 1.0 / self.stream.rate
                for datagram in self.stream.take(self._clock.now()):
                    self._send(channel, datagram)
                self._stopping.wait(max(min(exposure, self.stream.next_due) - self._clock.now(), 0.0))

    def _send(self, channel: socket.socket, datagram: bytes) -> None:
        try:
            channel.sendto(datagram, self.target)
        except OSError:  # nobody listens, or there is no such network: on a wire, packets are lost too
            return
        self.sent += 1
