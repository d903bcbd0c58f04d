r"""What an emulated Tracker sends, frame by frame, without a socket, a thread or a clock of its own.

The body at P with R is seen as the object that is fixed to it, in Vicon's axes, which stand in the world:

.. math::
    R_{VO} = R_{WV}^T R R_{BO}, \qquad p_{VO} = R_{WV}^T (P + R\, p_O - p_V)

Noise is added to every pose, as cameras do: a pose that repeats to the last bit means that the object is occluded.
"""

from __future__ import annotations

import math
import socket
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from doorman.background import InThread
from doorman.checks import NonNegative, Range, check_fields, vector
from doorman.clocks import HELD_UP, REAL_TIME, Clock
from doorman.hardware.mocap.frames import MILLIMETRES, object_angles
from doorman.hardware.mocap.packets import TrackedObject, pack
from doorman.kinematics.quaternions import from_rotation, to_rotation
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.rig.emulators.mocap.faults import StreamFaults

SIZES = (256, 512, 1024)
"""Sizes of packets [byte]; zeros fill what the items leave."""
_BLOCK = 3
"""Objects in a packet at most; a frame takes as many packets as it needs."""


@dataclass(frozen=True)
class BodyPose:
    position: ArrayLike  # P, shape (3,), world frame [m]
    quaternion: ArrayLike = (1.0, 0.0, 0.0, 0.0)  # [w, x, y, z], body to world, shape (4,)


PoseSource = Callable[[float], BodyPose]
"""Pose at a time [s]; called once a frame, in order."""


@dataclass(frozen=True)
class TrackedBody:
    source: PoseSource  # moves the body that it is fixed to
    position: ArrayLike = (0.0, 0.0, 0.0)  # origin of the object, shape (3,), in the body [m]
    attitude: ArrayLike = (0.0, 0.0, 0.0)  # attitude Φ of the object in the body, shape (3,) [rad]


@dataclass(frozen=True)
class TrackerSetup:
    object_name: str  # at most 24 bytes
    rate: Annotated[float, Range(0.0, 2000.0, "1/s", above=True)] = 100.0  # frames per second [1/s]
    latency: NonNegative = 0.005  # between a frame's exposure and the leaving of its packets [s]
    first_frame: int = 1  # its number
    position_noise: float = 5e-5  # standard deviation [m]
    attitude_noise: float = 2e-4  # standard deviation [rad]
    origin_position: ArrayLike = (0.0, 0.0, 0.0)  # Vicon's origin, shape (3,), world frame [m]
    origin_attitude: ArrayLike = (0.0, 0.0, 0.0)  # attitude Φ of Vicon's axes in the world, shape (3,) [rad]
    object_position: ArrayLike = (0.0, 0.0, 0.0)  # origin of the tracked object, shape (3,), body frame [m]
    object_attitude: ArrayLike = (0.0, 0.0, 0.0)  # attitude Φ of the tracked object in the body, shape (3,) [rad]
    bodies: Mapping[str, TrackedBody] = field(default_factory=dict)  # further objects that move, by name
    packet_size: int | None = SIZES[0]  # to which packets are padded at least [byte]; None pads nothing

    def __post_init__(self) -> None:
        check_fields(self)


class TrackerStream:
    """Packets of a Tracker, with faults of cameras, Tracker and network."""

    def __init__(self, source: PoseSource, setup: TrackerSetup) -> None:
        self.source = source
        self.setup = setup
        self.rate = setup.rate  # frames per second; may be changed at any time [1/s]
        self.frame_number = setup.first_frame  # number of the next frame; may be set at any time
        self.faults = StreamFaults()
        self._origin = vector(setup.origin_position, 3, "origin_position")
        self._axes = rotation_body_to_world(setup.origin_attitude)
        self._bodies = {
            **setup.bodies,
            setup.object_name: TrackedBody(source, setup.object_position, setup.object_attitude),
        }
        self._mounts = {
            name: (vector(one.position, 3, "object_position"), rotation_body_to_world(one.attitude))
            for name, one in self._bodies.items()
        }
        self.faults_of = {name: StreamFaults() for name in setup.bodies}
        """Faults of single further objects: `absent`, `frozen`, `zeroed`, `wrong_name`, `jump`, `outliers`, `not_finite`."""
        self._queue: deque[tuple[float, bytes]] = deque()
        self._due = -math.inf
        self._held: list[bytes] = []
        self._last_seen: dict[str, TrackedObject] = {}
        self._last_number = setup.first_frame
        self._frames = 0

    @property
    def next_due(self) -> float:
        """When the next packet leaves [s]; ∞ if none waits."""
        return self._queue[0][0] if self._queue else math.inf

    def skip(self) -> None:
        """A frame that is counted but not taken."""
        self.frame_number += 1

    def expose(self, at: float) -> None:
        """Take a frame, and put its packets on their way."""
        faults = self.faults
        packets = self._frame(at)
        self._frames += 1
        if faults.silent or self._frames % faults.stride:
            return
        self._due = max(at + self.setup.latency + faults.lateness(), self._due)
        held, self._held = self._held, []
        for datagram in packets:
            if faults.strike(faults.loss):
                continue
            if faults.strike(faults.reorder):
                self._held.append(datagram)
                continue
            if faults.strike(faults.garbage):
                self._queue.append((self._due, faults.random_bytes()))
            for _ in range(1 + faults.strike(faults.duplicate)):
                self._queue.append((self._due, faults.spoil(datagram)))
        self._queue.extend((self._due, datagram) for datagram in held)

    def take(self, now: float) -> list[bytes]:
        """Packets that have left by now, in order."""
        taken = []
        while self._queue and self._queue[0][0] <= now:
            taken.append(self._queue.popleft()[1])
        return taken

    def _frame(self, at: float) -> list[bytes]:
        """Packets of the next frame, as faults of cameras and Tracker leave them."""
        faults = self.faults
        number = self._last_number if faults.stuck_number else self.frame_number
        self._last_number = number
        self.frame_number += 1
        objects = []
        for name, body in self._bodies.items():
            own = self.faults_of.get(name, faults)
            if not own.absent:
                objects.append(self._see(name, body.source(at), own)._replace(name=own.wrong_name or name))
        blocks = [objects[start : start + _BLOCK] for start in range(0, len(objects), _BLOCK)] or [[]]
        return [self._padded(pack(number + faults.number_offset, block)) for block in blocks]

    def _padded(self, content: bytes) -> bytes:
        least = self.setup.packet_size
        if least is None:
            return content
        return content.ljust(min((fit for fit in SIZES if fit >= max(least, len(content))), default=0), b"\0")

    def _see(self, name: str, body: BodyPose, faults: StreamFaults) -> TrackedObject:
        """An object in Vicon's axes."""
        if faults.zeroed:
            return TrackedObject(name, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        if faults.frozen and name in self._last_seen:
            return self._last_seen[name]
        offset, mounting = self._mounts[name]
        rotation = to_rotation(body.quaternion)
        place = vector(body.position, 3, "position") + rotation @ offset
        seen = self._axes.T @ (place - self._origin) + np.asarray(faults.jump) + faults.noise(self.setup.position_noise)
        if faults.strike(faults.outliers):
            seen = seen + faults.outlier_distance * np.array(faults.direction())
        if faults.not_finite:
            seen[0] = np.nan
        turned = object_angles(from_rotation(self._axes.T @ rotation @ mounting))
        x, y, z = (seen * MILLIMETRES).tolist()
        a, b, c = (np.array(turned) + faults.noise(self.setup.attitude_noise)).tolist()
        self._last_seen[name] = TrackedObject(name, (x, y, z), (a, b, c))
        return self._last_seen[name]


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
                    if now - exposure <= HELD_UP:
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
        except OSError:  # no listener or no such network: on a wire, packets are lost too
            return
        self.sent += 1
