r"""Where a door stands against the map: a filter whose rows are touches of its frame, a track about its hinge, and a sensor.

A door that stands off the map by h and is turned by ψ about its hinge has the map's point q, from the hinge, at
:math:`h + R_\psi q`. With the state :math:`g = R_\psi^T h`, ψ and ρ, a place t in the world, seen from the map's hinge, is in
the door's own axes at

.. math:: s = R_\psi^T\, t - g .

A tip that touches a face with the normal n at q measures :math:`n^T s = n^T q`; one that grips a leaf goes round,
:math:`|s| = \rho`; where the leaf is closed, s has the azimuth of the map's leaf. Two touches of the front, far apart, give the
offset along its normal and ψ; one beside the hinge gives the offset along the wall.

The frame of the poses may walk: h is known for the time of the last reading, and walks on.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from doorman.arrays import Array
from doorman.estimation.filter import Filter
from doorman.estimation.measurement import Measurement
from doorman.estimation.model import ProcessModel
from doorman.estimation.status import Status

_TRACK_GATE = 4.0
"""Deviations from which on a tip does not go round any more: it has slipped."""
_ANY_RADIUS = 1.0
"""Deviation of a radius of which nothing is known [m]."""
_WANDERS = 5e-4
"""By which the frame of the poses may wander from that of a sensor in a second [m/s^½], [rad/s^½]."""
_BEFORE = 1e-3
"""Between the start of the filter and its first reading [s]."""
_YEARS = 1e9
"""Longest time between two readings: any [s]."""


class DoorPlace:
    """Offset and turn of a door on a vertical hinge.

    Deviations of the hinge from the map [m] and its yaw [rad], of the frame's walk in a second [m/s^½], of touch and track [m].
    """

    def __init__(
        self,
        place_deviation: float,
        yaw_deviation: float,
        walk: float = 0.0,
        touch: float = 0.003,
        track: float = 0.002,
    ) -> None:
        self._lazy: Filter | None = None
        self._doubt = np.array([place_deviation, place_deviation, yaw_deviation, _ANY_RADIUS])
        self._walk, self._touch, self._track = walk, touch, track
        self._know(math.nan, np.zeros(4), np.diag(self._doubt**2))
        self.found = False
        """Whether the frame has been found, by touches or by a sensor."""

    def _know(self, time: float, mean: Array, covariance: Array) -> None:
        self._mean, self._covariance = mean, covariance
        self.time = time
        """Time of the last reading [s]; NaN before the first."""
        self.turn = turned(self.yaw)
        """Rotation of the map to the door, shape (3, 3)."""
        turn = self.turn[:2, :2]
        self.offset: Array = turn @ mean[:2]
        """h, shape (2,), world frame [m]."""
        x, y = self.offset
        slope = np.array([[*turn[0], -y], [*turn[1], x], [0.0, 0.0, 1.0]])
        self.covariance: Array = slope @ covariance[:3, :3] @ slope.T
        """Covariance of h and ψ at the last reading, shape (3, 3)."""

    @property
    def _filter(self) -> Filter:
        if self._lazy is None:
            self._lazy = _filter()
        return self._lazy

    def prepare(self) -> DoorPlace:
        """Load the kernels, so that no reading has to wait for them."""
        assert self._filter is not None
        return self

    @property
    def yaw(self) -> float:
        """ψ [rad]."""
        return float(self._mean[2])

    def covariance_at(self, time: float) -> Array:
        """The same later, in a frame of the poses that has walked on."""
        passed = 0.0 if math.isnan(self.time) else time - self.time
        return self.covariance + np.diag([1.0, 1.0, 0.0]) * self._walk**2 * passed

    def placed(self, point: Array) -> Array:
        """Where a place of the map is, both from the map's hinge, shape (3,) [m]."""
        at = self.turn @ point
        at[:2] += self.offset
        return np.asarray(at)

    def deviation(self, point: Array, normal: Array, time: float = math.nan) -> float:
        """Standard deviation along its normal of a face of the map, at a place from the map's hinge [m]; later, if given."""
        x, y = point[:2] + self._mean[:2]
        slope = np.array([normal[0], normal[1], normal[1] * x - normal[0] * y])
        passed = time - self.time if time > self.time else 0.0
        return math.sqrt(float(slope @ self._covariance[:3, :3] @ slope) + self._walk**2 * passed)

    def touched(self, time: float, tip: Array, point: Array, normal: Array) -> Status:
        """Take in a touch of a face: the tip and the map's point, from the map's hinge, (3,) [m], and the face's normal."""
        return self._fuse("touch", time, [float(normal @ point)], [*tip[:2], *normal[:2], self._touch])

    def met(self, time: float, tip: Array, off: float) -> Status:
        """Take in that a closed leaf was met: the tip from the map's hinge, (2,) [m], and its azimuth beyond the leaf [rad]."""
        return self._fuse("closed", time, [off], [*tip, 0.0, 0.0, self._track])

    def goes_round(self, time: float, tip: Array) -> Status:
        """Take in where a tip is that grips one point of the leaf, from the map's hinge, shape (2,) [m]."""
        return self._fuse("round", time, [0.0], [*tip, 0.0, 0.0, self._track])

    def seen(self, time: float, offset: Array, yaw: float, deviations: tuple[float, float]) -> Status:
        """Take in where a sensor has seen the frame: h, shape (2,) [m], ψ [rad], and the deviations of both."""
        self._filter.parameters[:] = max(self._walk, _WANDERS), _WANDERS
        if not self.found:  # a sensor searches farther than the map's doubt
            there = np.array([*(turned(yaw)[:2, :2].T @ offset), yaw, 0.0])
            self._begin(time, there, np.array([deviations[0], deviations[0], deviations[1], _ANY_RADIUS]))
            self.found = True
            return Status.OK
        return self._fuse("frame", time, [*offset, yaw], [0.0, 0.0, *deviations, 0.0])

    def _begin(self, time: float, mean: Array, deviations: Array) -> None:
        self._filter.start(time, mean, deviations)
        self._know(time, mean, np.diag(deviations**2))

    def _fuse(self, name: str, time: float, reading: list[float], inputs: list[float]) -> Status:
        """Take in one reading."""
        if not self._filter.running:
            self._filter.parameters[:] = self._walk, 0.0
            self._begin(time - _BEFORE, self._mean, self._doubt)
        self._filter.acted(inputs)
        status = max(self._filter.measure(name, time, reading), self._filter.step(time, inputs))
        known = self._filter.estimate()
        self._know(known.time, known.mean, known.covariance)
        return status


def turned(yaw: float) -> Array:
    """Rotation about the vertical, shape (3, 3)."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _filter() -> Filter:
    """Rows of g, ψ and ρ; inputs are the place t, the normal or a sensor's deviations, and the deviation of the tip."""
    g, yaw, radius, walks = ca.SX.sym("g", 2), ca.SX.sym("yaw"), ca.SX.sym("radius"), ca.SX.sym("walks", 2)
    place, normal, tip = ca.SX.sym("place", 2), ca.SX.sym("normal", 2), ca.SX.sym("tip")
    cosine, sine = ca.cos(yaw), ca.sin(yaw)
    turn = ca.vertcat(ca.horzcat(cosine, -sine), ca.horzcat(sine, cosine))
    own = turn.T @ place - g
    away = place - turn @ g
    moved = ca.atan2(place[0] * away[1] - place[1] * away[0], ca.dot(place, away))  # of the azimuth, by h
    model = ProcessModel(
        ca.vertcat(g, yaw, radius), ca.vertcat(place, normal, tip), ca.SX.zeros(4),
        ca.vertcat(walks[0], walks[0], walks[1], 0), parameters=walks,
    )  # fmt: skip
    rows = [
        Measurement("touch", ca.dot(normal, own), tip),
        Measurement("round", ca.norm_2(own) - radius, tip, gate=_TRACK_GATE),
        Measurement("closed", yaw - moved, tip / ca.norm_2(place)),
        Measurement("frame", ca.vertcat(turn @ g, yaw), ca.vertcat(normal[0], normal[0], normal[1])),
    ]
    return Filter(model, measurements=rows, parameters=[0.0, 0.0], ticks=3, longest_step=_YEARS)
