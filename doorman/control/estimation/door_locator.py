r"""Where the door truly stands, from the track of a tip that grips one point of the leaf.

A point of the leaf goes round the true hinge. With h, the hinge's offset from the map, a Kalman filter of h and ρ takes in

.. math:: \|p - p_h - h\| = \rho .

The leaf is turned about the hinge by as much as it stood off its angle where the tip met it closed. From there on measurements
are seen as if the door stood where the map has it, and commands are turned back: what plans and decides knows no other door.
A tip that only pushes creeps on the leaf, and says nothing; it may touch the frame before (`frame_fit`). Nor does one that
holds a lever, which turns on the leaf. A leaf that does not start at its joint's stop says nothing either: it gives way to the
tip.

Where the frame of the poses walks, h is known for the time of the last measurement, and walks on.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.frame_fit import FrameFit
from doorman.model import Model
from doorman.signals import Command, Measurement

Array = NDArray[np.float64]

_EVERY = 0.1
"""Between measurements of the track, each an average: the noise of poses is a new one by then [s]."""
_TRACK_NOISE = 0.002
"""Of them [m]."""
_UNLIKELY = 4.0
"""A measurement that is so many deviations off is left out: the tip has slipped."""
_ELSEWHERE, _AJAR = 3.0, 1.5
"""A leaf that is met so many deviations before its place is not the map's; one that is met so many behind it stands ajar."""
_LOST = 0.2
"""A tip that leaves the leaf for so long comes back to another point of it [s]."""
_SPEED, _TURN = 0.005, 0.01
"""With which what is found is used: the vehicle is not to jump after it [m/s], [rad/s]."""
_WANDERS = 1e-4
"""By which the frame of the poses may wander from one reading of a sensor to the next [m], [rad]."""
_STEP = 1e-5


class DoorLocator:
    """Pose of a door on a vertical hinge, against the map. Others stand where the map has them.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        settings = model.scenario.estimation
        self._model, self._door = model, model.door
        known = max(settings.door_place_deviation, settings.door_yaw_deviation) == 0.0
        self._start = model.start_angle
        stopped = model.door.at_its_stop(self._start)
        fixed = model.scenario.contact.kind == "grip" and not model.scenario.door.beside
        self._works = fixed and model.door.vertical and stopped and not known
        self._shuts = -model.travel.sense  # of α, towards the start
        self._doubt = settings.door_place_deviation, settings.door_yaw_deviation
        self._known = np.zeros(3)  # h, world frame, and ρ
        self._covariance = np.diag([self._doubt[0] ** 2, self._doubt[0] ** 2, 0.0])
        self._walk = settings.frame_walk**2 * np.diag([1.0, 1.0, 0.0])  # of that, in a second
        self._began: float | None = None
        self._located_at = self._now = 0.0  # h measured last, and time
        self._touches = False
        self._goes_round = False
        self.frame: FrameFit | None = None
        """What touches of the frame have found, or a sensor of it."""
        self._measured: Array | None = None  # covariance of what a sensor has found
        self._met: Array | None = None  # where the leaf was nearest to closed
        self._sum, self._count, self._since = np.zeros(3), 0, 0.0
        self._away, self._ended = 0.0, False
        self._offset, self._turned = np.zeros(2), 0.0  # as they are used
        self._moved, self._turn = False, np.eye(3)  # whether they are not zero, and the rotation of the map to the door
        self.yaw = 0.0
        """By which the door is turned against the map [rad]."""
        self.yaw_deviation = settings.door_yaw_deviation
        """Its standard deviation [rad]."""

    @property
    def offset(self) -> Array:
        """h, of the hinge from where the map has it, shape (2,), world frame [m]."""
        return self._known[:2].copy()

    @property
    def offset_deviation(self) -> Array:
        """Standard deviation of `offset` along the world's x and y, shape (2,) [m]."""
        return np.asarray(np.sqrt(np.diag(self._covariance)[:2]))

    @property
    def found(self) -> list[float]:
        """What is known, h and the turn: [m], [m], [rad]."""
        return [*self._known[:2].tolist(), self.yaw]

    @property
    def deviations(self) -> list[float]:
        """Their standard deviations, against the place in the world in which the flight began."""
        covariance = self._covariance + self._walk * max(self._located_at - (self._began or 0.0), 0.0)
        return [*(math.sqrt(max(covariance[k, k], 0.0)) for k in range(2)), self.yaw_deviation]

    def angle_deviation(self, door_angle: float) -> float:
        r"""Standard deviation of α from that of the door's place, :math:`\delta\alpha = n_D^T\delta h/D - \delta\psi`.

        The frame of the poses has walked since the touches of the door's frame.
        """
        if self.frame is None or not self._touches:
            return math.nan
        normal = self._door.normal(door_angle)[:2] / self._model.coupling.lever_length
        slope = np.array([*normal, -self._door.hand])
        covariance = self.frame.covariance_at(self._now, self._model.scenario.estimation.frame_walk)
        return math.sqrt(float(slope @ covariance @ slope))

    def update(self, measured: Measurement, touches: bool, grips: bool, time_step: float) -> None:
        """Take in where the tip is."""
        self._follow(time_step)
        self._began = measured.time if self._began is None else self._began
        self._now, self._touches = measured.time, touches
        if not self._works:
            return
        if self._ended or not (touches or grips):
            self._lose(time_step)
            return
        self._away = 0.0
        tips = self._model.coupling.tips(np.array([measured.attitude]), np.array([measured.arm_angles]))
        self._sum += measured.position + tips[0]
        self._count += 1
        self._since += time_step
        if self._since >= _EVERY:
            self._covariance = self._covariance + self._walk * self._since
            self._located_at = measured.time
            self._take(self._sum / self._count, grips)
            if self._goes_round:
                self._learn_yaw()
            self._sum, self._count, self._since = np.zeros(3), 0, 0.0

    def learn(self, frame: FrameFit) -> None:
        """Take in where the frame has been touched."""
        self.frame, self.yaw = frame, frame.yaw
        self._known = np.array([*frame.offset, 0.0])
        self._covariance[:2, :2] = frame.covariance[:2, :2]
        self._located_at = frame.time
        self.yaw_deviation = math.sqrt(float(frame.covariance[2, 2]))

    def measure(self, offset: Array, yaw: float, place_deviation: float, yaw_deviation: float) -> None:
        """Take in where a sensor has seen the frame: h, shape (2,), and the turn. The first one is used at once."""
        self._works = False  # the track of a grip would only be second to this
        if self._measured is None:
            self._measured = np.diag([place_deviation**2, place_deviation**2, yaw_deviation**2])
            found = np.array([*offset, yaw])
            self._offset, self._turned = found[:2].copy(), yaw
        else:
            noise = np.diag([place_deviation**2, place_deviation**2, yaw_deviation**2])
            doubt = self._measured + (_WANDERS**2) * np.eye(3)
            gain = doubt @ np.linalg.inv(doubt + noise)
            before = np.array([*self._known[:2], self.yaw])
            found = before + gain @ (np.array([*offset, yaw]) - before)
            self._measured = (np.eye(3) - gain) @ doubt
        hinge, covariance = self._door.hinge_position, self._measured
        self.learn(FrameFit(hinge, found[:2], float(found[2]), covariance, self._now))

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
        return Measurement(
            measured.time, origin + back @ moved, back @ measured.velocity, attitude, measured.body_rates,
            measured.arm_angles, measured.arm_rates, measured.pose_time, measured.arm_time, measured.tip_force,
            measured.leaf, measured.frame,
        )  # fmt: skip

    def told(self, command: Command) -> Command:
        """A command to the vehicle, from one for a door that stands where the map has it."""
        if not self._turned:
            return command
        attitude = np.array(command.attitude)
        attitude[2] += self._turned
        return Command(command.thrust, attitude, command.arm_rates, command.grip, command.side_force)

    def place(self, point: Array) -> Array:
        """Where a place beside the map's door truly is."""
        if not self._moved:
            return point
        origin = self._door.hinge_position
        there = origin + self._turn @ (point - origin)
        there[:2] += self._offset
        return there

    def vector(self, vector: Array) -> Array:
        """A vector at the map's door, turned as the true door is."""
        return self._turn @ vector if self._moved else vector

    def heading(self, yaw: float) -> float:
        """A heading at the map's door, turned as the true door is [rad]."""
        return yaw + self._turned

    def _take(self, tip: Array, grips: bool) -> None:
        """Measure that the tip keeps its distance from the hinge; and where the leaf was closed."""
        if (
            self._met is None
            or self._shuts * (self._angle(tip, self._known) - self._angle(self._met, self._known)) > 0.0
        ):
            self._met = tip
        if not grips:
            return
        if not self._goes_round:
            self._begin(tip)
            return
        away = self._away_from(tip, self._known)
        radius = float(np.linalg.norm(away))
        self._correct(radius - self._known[2], np.array([*(-away / radius), -1.0]), _TRACK_NOISE)

    def _learn_yaw(self) -> None:
        """The door's turn, from where its hinge is and where the leaf was met."""
        slope = self._slope(self._yaw_of)
        own = _TRACK_NOISE / self._model.coupling.lever_length  # of where the leaf was met
        self.yaw = self._yaw_of(self._known)
        self.yaw_deviation = math.sqrt(float(slope @ self._covariance @ slope) + own**2)

    def _begin(self, tip: Array) -> None:
        """From here on the tip goes round."""
        if not self._stands_closed():
            self._ended = True  # open already: nothing says by how much the door is turned
            return
        self._goes_round = True
        away, variance = self._away_from(tip, self._known), self._doubt[0] ** 2
        self._known[2] = radius = float(np.linalg.norm(away))
        slope = -away / radius  # of ρ by h
        self._covariance[:2, 2] = self._covariance[2, :2] = variance * slope
        self._covariance[2, 2] = variance + _TRACK_NOISE**2
        self._correct(self._yaw_of(self._known), self._slope(self._yaw_of), self._doubt[1])

    def _correct(self, off: float, slope: Array, noise: float) -> None:
        """Kalman's step for a scalar that should be 0."""
        spread = self._covariance @ slope
        variance = float(slope @ spread) + noise**2
        if off * off > _UNLIKELY**2 * variance:
            return
        self._known = self._known - spread * (off / variance)
        self._covariance = self._covariance - np.outer(spread, spread) / variance

    def _slope(self, value: Callable[[Array], float]) -> Array:
        """Of a value by what is known, shape (3,)."""
        steps = _STEP * np.eye(3)
        return np.array([(value(self._known + step) - value(self._known - step)) / (2.0 * _STEP) for step in steps])

    def _yaw_of(self, known: Array) -> float:
        """By which the leaf stood off its angle as the tip met it, about a hinge there [rad]."""
        assert self._met is not None
        return self._door.hand * (self._angle(self._met, known) - self._start)

    def _angle(self, tip: Array, known: Array) -> float:
        return self._door.angle_of(np.array([*self._away_from(tip, known), 0.0]))

    def _away_from(self, tip: Array, known: Array) -> Array:
        """From a hinge there to a tip, shape (2,) [m]."""
        return np.asarray((tip - self._door.hinge_position)[:2] - known[:2])

    def _stands_closed(self) -> bool:
        """Whether the map's doubt explains where the leaf was met, rather than a leaf that stands open."""
        lever = self._model.coupling.lever_length
        likely = math.hypot(self._doubt[0] / lever, self._doubt[1])
        before = self._shuts * self._door.hand * self._yaw_of(np.zeros(3))
        return -_AJAR * likely < before < _ELSEWHERE * likely

    def _lose(self, time_step: float) -> None:
        self._sum, self._count, self._since = np.zeros(3), 0, 0.0
        if not self._goes_round:
            return
        self._away += time_step
        self._ended = self._ended or self._away > _LOST

    def _follow(self, time_step: float) -> None:
        """Use what is found, little by little."""
        if not (self._goes_round or self.frame):
            return
        off, most = self._known[:2] - self._offset, _SPEED * time_step
        self._offset = self._offset + off * min(1.0, most / max(float(np.hypot(*off)), 1e-9))
        turn, most = self.yaw - self._turned, _TURN * time_step
        self._turned += min(max(turn, -most), most)
        cosine, sine = math.cos(self._turned), math.sin(self._turned)
        self._moved, self._turn = True, np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
