r"""What an emulated Tracker sends, frame by frame, without a socket, a thread or a clock of its own.

The body at P with R is seen as the object that is fixed to it, in Vicon's axes, which stand in the world:

.. math::
    R_{VO} = R_{WV}^T R R_{BO}, \qquad p_{VO} = R_{WV}^T (P + R\, p_O - p_V)

Noise is added to every pose, as cameras do: a pose that repeats to the last bit means that the object is occluded.
"""

from __future__ import annotations

import heapq
import math
import socket
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.background import InThread
from doorman.checks import NonNegative, Range, check_fields, vector
from doorman.clocks import REAL_TIME, Clock
from doorman.kinematics.quaternions import to_rotation
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.rig.emulators.mocap.faults import StreamFaults

SIZES = (256, 512, 1024)
"""Sizes of packets [byte]; zeros fill what the items leave."""
_OBJECT_ID = 0
_BODY = struct.Struct("<24sdddddd")


def euler_xyz(rotation: Array) -> Array:
    """Angles (a, b, c) of R = Rx(a) Ry(b) Rz(c)."""
    return np.array(
        [
            np.arctan2(-rotation[1, 2], rotation[2, 2]),
            np.arcsin(np.clip(rotation[0, 2], -1.0, 1.0)),
            np.arctan2(-rotation[0, 1], rotation[0, 0]),
        ]
    )


def item(name: str, translation: Array, rotation: Array) -> bytes:
    body = _BODY.pack(name.encode(), *translation.tolist(), *rotation.tolist())
    return struct.pack("<BH", _OBJECT_ID, len(body)) + body


def packet(frame_number: int, items: Sequence[bytes], size: int | None = SIZES[0]) -> bytes:
    content = struct.pack("<IB", frame_number % (1 << 32), len(items)) + b"".join(items)
    if size is None:
        return content
    return content.ljust(min((fit for fit in SIZES if fit >= max(size, len(content))), default=len(content)), b"\0")


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
    others: Mapping[str, BodyPose] = field(default_factory=dict)
    """Poses of further objects, as Vicon sees them; they stand still."""
    bodies: Mapping[str, TrackedBody] = field(default_factory=dict)  # further objects that move, by name
    block: Annotated[int, Range(1, 13)] = 3  # objects in a packet at most; a frame takes as many packets as it needs
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
        self._own = TrackedBody(source, setup.object_position, setup.object_attitude)
        self._mounts = {
            name: (vector(one.position, 3, "object_position"), rotation_body_to_world(one.attitude))
            for name, one in {"": self._own, **setup.bodies}.items()
        }  # fmt: skip
        self.faults_of = {name: StreamFaults() for name in setup.bodies}
        """Faults of single further objects: `absent`, `frozen`, `zeroed`, `wrong_name`, `jump`, `outliers`, `not_finite`."""
        self._queue: list[tuple[float, int, bytes]] = []
        self._queued = 0
        self._due = -math.inf
        self._held: list[bytes] = []
        self._last_seen: dict[str, tuple[Array, Array]] = {}
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
                self._put(faults.random_bytes())
            for _ in range(1 + faults.strike(faults.duplicate)):
                self._put(faults.spoil(datagram))
        for datagram in held:
            self._put(datagram)

    def take(self, now: float) -> list[bytes]:
        """Packets that have left by now, in order."""
        taken = []
        while self._queue and self._queue[0][0] <= now:
            taken.append(heapq.heappop(self._queue)[2])
        return taken

    def _put(self, datagram: bytes) -> None:
        self._queued += 1
        heapq.heappush(self._queue, (self._due, self._queued, datagram))

    def _frame(self, at: float) -> list[bytes]:
        """Packets of the next frame, as faults of cameras and Tracker leave them."""
        faults, size = self.faults, self.setup.block
        number = self._last_number if faults.stuck_number else self.frame_number
        self._last_number = number
        self.frame_number += 1
        items = [item(name, *_still(pose)) for name, pose in self.setup.others.items()]
        for name, body in self.setup.bodies.items():
            own = self.faults_of[name]
            if not own.absent:
                items.append(item(own.wrong_name or name, *self._see(body.source(at), own, name)))
        if not faults.absent:
            items.append(item(faults.wrong_name or self.setup.object_name, *self._see(self.source(at), faults)))
        blocks = [items[start : start + size] for start in range(0, len(items), size)] or [[]]
        return [packet(number + faults.number_offset, block, self.setup.packet_size) for block in blocks]

    def _see(self, body: BodyPose, faults: StreamFaults, name: str = "") -> tuple[Array, Array]:
        """Pose of an object in Vicon's axes, [mm] and [rad]."""
        if faults.zeroed:
            return np.zeros(3), np.zeros(3)
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
        angles = euler_xyz(self._axes.T @ rotation @ mounting) + faults.noise(self.setup.attitude_noise)
        self._last_seen[name] = (1e3 * seen, angles)
        return self._last_seen[name]


def _still(pose: BodyPose) -> tuple[Array, Array]:
    return 1e3 * vector(pose.position, 3, "position"), euler_xyz(to_rotation(pose.quaternion))


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
        except OSError:  # no listener or no such network: on a wire, packets are lost too
            return
        self.sent += 1
