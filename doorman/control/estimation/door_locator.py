r"""Where the door truly stands, from the track of a tip that grips one point of the leaf.

A point of the leaf goes round the true hinge, which `DoorPlace` takes in.

The leaf is turned about the hinge by as much as it stood off its angle where the tip met it closed. From there on measurements
are seen as if the door stood where the map has it, and commands are turned back: what plans and decides knows no other door.
A tip that is not tied creeps on the leaf, and says nothing; it may touch the frame before. Nor does one that holds a lever, which
turns on the leaf. A leaf that does not start at its joint's stop says nothing either: it gives way to the tip.

"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from doorman.arrays import Array
from doorman.estimation.door_place import DoorPlace, turned
from doorman.model import Model
from doorman.signals import Command, Measurement

_EVERY = 0.1
"""Between measurements of the track, each an average: the noise of poses is a new one by then [s]."""
_ELSEWHERE, _AJAR = 3.0, 1.5
"""A leaf that is met so many deviations before its place is not the map's; one that is met so many behind it stands ajar."""
_LOST = 0.2
"""A tip that leaves the leaf for so long comes back to another point of it [s]."""
_SPEED, _TURN = 0.005, 0.01
"""With which what is found is used: the vehicle is not to jump after it [m/s], [rad/s]."""


def place_of(model: Model) -> DoorPlace:
    """What is known of where a scenario's door stands."""
    known = model.scenario.estimation
    return DoorPlace(
        known.door_place_deviation, known.door_yaw_deviation, known.frame_walk, known.frame_touch, known.frame_track
    )


class DoorLocator:
    """Pose of a door on a vertical hinge, against the map. Others stand where the map has them."""

    def __init__(self, model: Model) -> None:
        settings = model.scenario.estimation
        self._model, self._door = model, model.door
        self.known = place_of(model)
        """Where the door stands, as far as it is known."""
        known = settings.door_place_deviation == 0.0
        self._start = model.start_angle
        stopped = model.door.at_its_stop(self._start)
        fixed = model.scenario.contact.kind == "grip" and not model.scenario.door.beside
        self._works = fixed and model.door.vertical and stopped and not known
        if self._works or model.frame_places:
            self.known.prepare()
        self._shuts = -model.travel.sense  # of α, towards the start
        self._doubt = settings.door_place_deviation, settings.door_yaw_deviation
        self._walk = settings.frame_walk**2
        self._began: float | None = None
        self._now = 0.0
        self._touches = False
        self._goes_round = False
        self._met: Array | None = None  # where the leaf was nearest to closed, from the map's hinge
        self._sum, self._count, self._since = np.zeros(3), 0, 0.0
        self._away, self._ended = 0.0, False
        self._offset, self._turned = np.zeros(2), 0.0  # as they are used
        self._moved, self._turn = False, np.eye(3)  # whether they are not zero, and the rotation of the map to the door

    @property
    def state(self) -> Array:
        """What is known, h and the turn, shape (3,): [m], [m], [rad]."""
        return np.array([*self.known.offset, self.known.yaw])

    @property
    def deviations(self) -> Array:
        """Their standard deviations, against the place in the world in which the flight began."""
        known, walked = self.known, 0.0
        if not math.isnan(known.time):
            walked = self._walk * max(known.time - (self._began or 0.0), 0.0)
        return np.sqrt(known.covariance.diagonal() + walked * np.array([1.0, 1.0, 0.0]))

    def angle_deviation(self, door_angle: float) -> float:
        r"""Standard deviation of α from that of the door's place, :math:`\delta\alpha = n_D^T\delta h/D - \delta\psi`.

        The frame of the poses has walked since the touches of the door's frame.
        """
        if not self.known.found or not self._touches:
            return math.nan
        normal = self._door.normal(door_angle)[:2] / self._model.coupling.lever_length
        slope = np.array([*normal, -self._door.hand])
        return math.sqrt(float(slope @ self.known.covariance_at(self._now) @ slope))

    def update(self, measured: Measurement, touches: bool, grips: bool, time_step: float) -> None:
        """Take in where the tip is."""
        self._follow(time_step)
        self._began = measured.time if self._began is None else self._began
        self._now, self._touches = measured.time, touches
        if not self._works:
            return
        if self._ended or not (touches or grips):
            self._sum, self._count, self._since = np.zeros(3), 0, 0.0
            self._away += time_step
            self._ended = self._ended or (self._goes_round and self._away > _LOST)
            return
        self._away = 0.0
        tips = self._model.coupling.tips(measured.attitude[None].copy(), measured.arm_angles[None].copy())
        self._sum += measured.position + tips[0]
        self._count += 1
        self._since += time_step
        if self._since >= _EVERY:
            tip = self._sum / self._count - self._door.hinge_position
            self._take(measured.time, tip[:2], grips)
            self._sum, self._count, self._since = np.zeros(3), 0, 0.0

    def measure(self, offset: Array, yaw: float, place_deviation: float, yaw_deviation: float) -> None:
        """Take in where a sensor has seen the frame: h, shape (2,), and the turn. The first one is used at once."""
        self._works = False  # the track of a grip would only be second to this
        if not self.known.found:
            self._offset, self._turned = np.array(offset), yaw
        self.known.seen(self._now, offset, yaw, (place_deviation, yaw_deviation))

    def seen(self, measured: Measurement) -> Measurement:
        """A measurement as it would be if the door stood where the map has it."""
        if not self._moved:
            return measured
        back = self._turn.T
        attitude = np.array(measured.attitude)
        attitude[2] -= self._turned
        origin = self._door.hinge_position
        moved = measured.position - origin
        moved[:2] -= self._offset
        position, velocity = origin + back @ moved, back @ measured.velocity
        return replace(measured, position=position, velocity=velocity, attitude=attitude)

    def in_world(self, command: Command) -> Command:
        """A command to the vehicle, from one for a door that stands where the map has it."""
        if not self._turned:
            return command
        attitude = np.array(command.attitude)
        attitude[2] += self._turned
        return replace(command, attitude=attitude)

    def place(self, point: Array) -> Array:
        """Where a place beside the map's door truly is."""
        if not self._moved:
            return point
        origin = self._door.hinge_position
        there = origin + self._turn @ (point - origin)
        there[:2] += self._offset
        return there

    def vectors(self, *vectors: Array) -> tuple[Array, ...]:
        """Vectors at the map's door, turned as the true door is."""
        return tuple(self._turn @ each for each in vectors) if self._moved else vectors

    def heading(self, yaw: float) -> float:
        """A heading at the map's door, turned as the true door is [rad]."""
        return yaw + self._turned

    def _take(self, now: float, tip: Array, grips: bool) -> None:
        """Measure that the tip keeps its distance from the hinge; and where the leaf was closed."""
        if self._met is None or self._shuts * (self._angle(tip) - self._angle(self._met)) > 0.0:
            self._met = tip
        if not grips:
            return
        if not self._goes_round:
            off = self._door.hand * (self._angle(self._met) - self._start)
            # the map's doubt must explain where the leaf was met: one that stands open does not say how the door is turned
            likely = math.hypot(self._doubt[0] / self._model.coupling.lever_length, self._doubt[1])
            if not -_AJAR * likely < self._shuts * self._door.hand * off < _ELSEWHERE * likely:
                self._ended = True
                return
            self._goes_round = True
            self.known.met(now - 0.5 * _EVERY, self._met, off)
        self.known.goes_round(now, tip)

    def _angle(self, tip: Array) -> float:
        """Angle about the map's hinge of the leaf on which a tip is [rad]."""
        return self._door.angle_of(np.array([*tip, 0.0]))

    def _follow(self, time_step: float) -> None:
        """Use what is found, little by little."""
        if not (self._goes_round or self.known.found):
            return
        off, turn = self.known.offset - self._offset, self.known.yaw - self._turned
        if self._moved and not (turn or off.any()):
            return
        most = _SPEED * time_step
        self._offset = self._offset + off * min(1.0, most / max(float(np.hypot(*off)), 1e-9))
        most = _TURN * time_step
        self._turned += min(max(turn, -most), most)
        self._moved, self._turn = True, turned(self._turned)
