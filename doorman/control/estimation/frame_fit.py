r"""Where a door stands, from touches of its frame.

A door that stands off the map by h and is turned by ψ about its hinge has the map's point q at
:math:`p_h + h + R_\psi (q - p_h)`. A tip t that touches the face with the normal n there measures

.. math:: r = (R_\psi n)^T (t - p_h - h) - n^T (q - p_h) = 0 .

Gauss and Newton's steps find h and ψ, with the map's doubt as a prior of mean 0. Two touches of the front, far apart, give the
offset along its normal and ψ; one beside the hinge gives the offset along the wall.

The fit takes the frame of the poses for still. Where that walks, by q in a second, the stated covariance of h grows by
:math:`q^2 t\, I` from the first touch on, which is a little more than it has after the last one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.doors.frame_places import FramePlace

Array = NDArray[np.float64]

_STEPS = 4
"""The residuals are almost linear: h moves by less than a micrometre in the last one."""


@dataclass(frozen=True, eq=False)
class FrameTouch:
    """What one touch says."""

    place: FramePlace
    """Where the map has what was touched."""
    tip: Array
    """Where the tip was, shape (3,), world frame [m]."""
    time: float = 0.0
    """When [s]."""


@dataclass(frozen=True, eq=False)
class FrameFit:
    """Pose of a door against the map."""

    hinge: Array
    """p_h of the map, shape (3,), world frame [m]."""
    offset: Array
    """h, shape (2,), world frame [m]."""
    yaw: float
    """ψ [rad]."""
    covariance: Array
    """Of h and ψ, shape (3, 3)."""
    time: float = 0.0
    """Of the first touch [s]."""

    def covariance_at(self, time: float, walk: float) -> Array:
        """Covariance of h and ψ for a frame of the poses that has walked on, shape (3, 3)."""
        return self.covariance + np.diag([1.0, 1.0, 0.0]) * walk**2 * (time - self.time)

    def placed(self, place: FramePlace) -> FramePlace:
        """Where a place of the map is."""
        turn = _turn(self.yaw)
        point = self.hinge + turn @ (place.point - self.hinge)
        point[:2] += self.offset
        return FramePlace(point, turn @ place.normal, place.turn)

    def deviation(self, place: FramePlace) -> float:
        """Standard deviation of a face along its normal, at a place of the map [m]."""
        slope = _slope(place.normal, self.placed(place).point - self.hinge, self)
        return math.sqrt(float(slope @ self.covariance @ slope))


def fit_frame(
    hinge: Array, touches: Sequence[FrameTouch], place_deviation: float, yaw_deviation: float, noise: float
) -> FrameFit:
    """Pose of a door from touches of its frame."""
    doubt = np.array([place_deviation, place_deviation, yaw_deviation]) ** 2
    fit = FrameFit(hinge, np.zeros(2), 0.0, np.diag(doubt))
    if not touches:
        return fit
    for _ in range(_STEPS):
        normals = [_turn(fit.yaw) @ touch.place.normal for touch in touches]
        slopes = np.array([_slope(touch.place.normal, touch.tip - hinge, fit) for touch in touches])
        known = np.array([*fit.offset, 0.0])
        off = np.array([
            float(normal @ (touch.tip - hinge - known) - touch.place.normal @ (touch.place.point - hinge))
            for normal, touch in zip(normals, touches, strict=True)
        ])  # fmt: skip
        # the prior's mean is 0: the linear residual is taken from there
        spread = np.diag(doubt) @ slopes.T
        gain = spread @ np.linalg.inv(slopes @ spread + noise**2 * np.eye(len(touches)))
        found = gain @ (slopes @ np.array([*fit.offset, fit.yaw]) - off)
        covariance = np.diag(doubt) - gain @ spread.T
        fit = FrameFit(hinge, found[:2], float(found[2]), covariance, touches[0].time)
    return fit


def _turn(yaw: float) -> Array:
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _slope(normal: Array, away: Array, fit: FrameFit) -> Array:
    """Of r by h and ψ, shape (3,)."""
    x, y, _ = _turn(fit.yaw) @ normal
    from_hinge = away[:2] - fit.offset
    return np.array([-x, -y, float(x * from_hinge[1] - y * from_hinge[0])])
