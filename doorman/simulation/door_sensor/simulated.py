"""The simulated sensor of the door: the truth as cameras, tags or an encoder measure it, noisy, late and faulty on demand.

The noise of a joint value is that of the mark's place and attitude together, as `LeafGeometry` weighs them.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.door_sensor.printing import usual_marks
from doorman.model import Model
from doorman.signals import FrameReading, LeafReading
from doorman.simulation.delay_line import ROUNDED
from doorman.simulation.truth import Truth

_STREAM = 7
"""Stream of random numbers of a seed for noise."""
_OLD = 0.3
"""Age from which on a reading counts as none [s]."""
_JUMP = math.radians(10.0)
"""Jump of a faulty sensor [rad, or as a share of a slide's metre]."""
_LATE = 0.3
"""Delay of a sensor that comes late, and stamps its readings when they come [s]."""


class Seen(NamedTuple):
    """What can be seen of the door at one time."""

    leaf: bool
    frame: bool


class _Reading(NamedTuple):
    due: float
    leaf: LeafReading | None
    frame: FrameReading | None


class SimulatedDoorSensor:
    """Readings of one flight."""

    def __init__(self, model: Model, seed: int, view: Callable[[Truth], Seen] | None = None) -> None:
        self._section = section = model.scenario.simulation.door_sensor
        self._door, self._view = model.true_door, view or (lambda truth: Seen(True, True))
        self._usual = usual = section.usual
        mark = usual_marks(model, section.tag_size)[0]
        lever = max(abs(float(self._door.in_doorway(_mark_on_closed(model, mark.position))[1])), 0.05)
        by_place = usual.place if self._door.slides else usual.place / lever
        self.deviation = usual.turn if section.kind == "encoder" else 1.0 / math.hypot(1.0 / by_place, 1.0 / usual.turn)
        """Standard deviation of a joint value [rad, or m]."""
        if self._door.slides:
            self.deviation = usual.place
        self._noise = np.random.default_rng([seed, _STREAM])
        self._next = 0.0
        self._coming: deque[_Reading] = deque()
        self._leaf: LeafReading | None = None
        self._frame: FrameReading | None = None
        self._frozen: float | None = None
        self._fault_began = False

    def due(self, time: float) -> bool:
        """Whether it is time for a reading; times must not decrease."""
        if time < self._next - ROUNDED:
            return False
        while self._next <= time + ROUNDED:
            self._next += 1.0 / self._usual.rate
        return True

    def take(self, time: float, leaf: LeafReading | None, frame: FrameReading | None) -> None:
        """Put a reading on its way."""
        if leaf is not None or frame is not None:
            late = _LATE if self._faulty("late") else 0.0
            self._coming.append(_Reading(time + self._usual.latency + late, leaf, frame))

    def measure(self, truth: Truth) -> tuple[LeafReading | None, FrameReading | None]:
        """What has come by now: the newest readings, held until the next ones, and none when they are old."""
        if self.due(truth.time):
            self._sample(truth)
        return self.arrived(truth.time)

    def arrived(self, now: float) -> tuple[LeafReading | None, FrameReading | None]:
        """The newest readings that have come, none where they are old."""
        while self._coming and self._coming[0].due <= now + ROUNDED:
            _, leaf, frame = self._coming.popleft()
            self._leaf, self._frame = leaf or self._leaf, frame or self._frame
        leaf, frame = self._leaf, self._frame
        return (
            None if leaf is None or now - leaf.time > _OLD else leaf,
            None if frame is None or now - frame.time > _OLD else frame,
        )

    def _sample(self, truth: Truth) -> None:
        seen, time, noise = self._view(truth), truth.time, self._noise.standard_normal(5)
        joint = self._seen_joint(truth.door_angle, time)
        leaf = frame = None
        if seen.leaf and joint is not None:
            stamp = time + (_LATE if self._faulty("late") else 0.0)
            joint += self.deviation * float(noise[0])
            if self._faulty("freeze"):
                joint = self._frozen = joint if self._frozen is None else self._frozen
            leaf = LeafReading(joint, stamp, self.deviation)
        if seen.frame and self._section.kind != "encoder":
            usual, placed = self._usual, self._door.placement[:3, 3]
            yaw = self._door.yaw + usual.turn * float(noise[4])
            frame = FrameReading(placed + usual.place * noise[1:4], yaw, time, usual.place, usual.turn)
        self.take(time, leaf, frame)

    def _seen_joint(self, door_angle: float, time: float) -> float | None:
        """Joint value that the sensor sees, its fault included; None where it has ended."""
        door, section = self._door, self._section
        self._fault_began = self._fault_began or (
            section.fault != "none" and door.opening_of(door_angle) >= section.fault_opening - ROUNDED
        )
        joint = door.joint_value(door_angle)
        if self._faulty("jump"):
            joint += _JUMP
        if self._faulty("upside_down"):
            joint = 2.0 * door.closed - joint
        if self._faulty("wrong_object"):
            joint = door.closed + 0.5 * math.sin(2.0 * time)
        return None if self._faulty("dies") else joint

    def _faulty(self, fault: str) -> bool:
        return self._fault_began and self._section.fault == fault


def _mark_on_closed(model: Model, place: tuple[float, float, float]) -> Array:
    """From the hinge to a place of the leaf's link, where the door is closed, shape (3,) [m]."""
    door = model.door
    link = door.link_placements(door.angle_of_opening(0.0))[door.section.leaf]
    return np.asarray((link @ [*place, 1.0])[:3] - door.hinge_position)
