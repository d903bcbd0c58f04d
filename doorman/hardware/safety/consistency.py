"""What an observer checks by itself: that pose, arm and held door fit together, and that an autopilot obeys."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model

EVERY = 0.1
"""Time over which a measurement is averaged: the noise of poses is independent by then [s]."""


_ANGLE_NOISE = 0.005
"""Deviation of the angle that a held tip measures: noise of poses and of joint angles together [rad]."""


class HeldTip:
    r"""Follows one tip from the moment at which the gripper holds: whether pose, joint angles and door fit together.

    A held tip t goes round the hinge at its height. With the hinge off the map by h, which is stated to be about 0,

    .. math:: \|t - p_h - h\| = \rho, \qquad t_z = \zeta

    A Kalman filter knows h, ρ and ζ from what was measured before. A measurement that is many standard deviations off, or one
    that needs a hinge so far from the map, does not fit: the cameras' frame or a joint angle drifts, or the tip slips. A drift
    along the circle looks like a leaf that swings; it shows once the leaf has turned.
    """

    def __init__(self, model: Model) -> None:
        settings = model.scenario.estimation
        self._coupling, self._hinge = model.coupling, model.door.hinge_position
        self._noise = (_ANGLE_NOISE * model.coupling.lever_length) ** 2
        self._doubt, self._walk = settings.door_place_deviation**2, settings.frame_walk**2
        self._most = model.scenario.safety.misfit
        self.let_go()

    @classmethod
    def of(cls, model: Model) -> HeldTip | None:
        """The follower for a scenario; None where no tip is held, or the hinge is not plumb."""
        return cls(model) if model.scenario.contact.kind == "grip" and model.door.vertical else None

    def let_go(self) -> None:
        """The gripper does not hold any more."""
        self._known: Array | None = None  # hx, hy, ρ, ζ
        self._covariance = np.zeros((4, 4))
        self._sum, self._count, self._since = np.zeros(3), 0, math.nan
        self.misfit = 0.0  # by how much the last average does not fit, in standard deviations

    def take(self, position: Array, attitude: Array, arm_angles: Array, now: float) -> None:
        self._since = now if self._count == 0 else self._since
        self._sum = self._sum + position + self._coupling.tips(attitude[None], arm_angles[None])[0]
        self._count += 1
        if now - self._since >= EVERY:
            away = self._sum / self._count - self._hinge
            if self._known is None:
                self._begin(away)
            else:
                self._follow(away, now - self._since)
            self._sum, self._count = np.zeros(3), 0

    def _begin(self, away: Array) -> None:
        radius = float(np.hypot(away[0], away[1]))
        slope = np.array([-away[0] / radius, -away[1] / radius])  # of ρ by h
        self._known = np.array([0.0, 0.0, radius, away[2]])
        self._covariance[:2, :2] = self._doubt * np.eye(2)
        self._covariance[:2, 2] = self._covariance[2, :2] = self._doubt * slope
        self._covariance[2, 2] = self._doubt + self._noise
        self._covariance[3, 3] = self._noise

    def _follow(self, away: Array, elapsed: float) -> None:
        assert self._known is not None
        self._covariance[0, 0] += self._walk * elapsed
        self._covariance[1, 1] += self._walk * elapsed
        from_hinge = away[:2] - self._known[:2]
        radius = float(np.hypot(from_hinge[0], from_hinge[1]))
        rows = np.array([[*(-from_hinge / radius), -1.0, 0.0], [0.0, 0.0, 0.0, -1.0]])
        off = np.array([radius - self._known[2], away[2] - self._known[3]])
        spread = self._covariance @ rows.T
        variance = rows @ spread + self._noise * np.eye(2)
        misfits = np.abs(off) / np.sqrt(np.diag(variance))
        gain = spread @ np.linalg.inv(variance)
        known = self._known - gain @ off
        place = float(np.hypot(known[0], known[1])) / math.sqrt(self._doubt) if self._doubt > 0.0 else 0.0
        self.misfit = max(float(misfits.max()), place)
        if self.misfit <= self._most:
            self._known, self._covariance = known, self._covariance - gain @ spread.T


SHAPING = 0.2
"""Time constant of the slowest autopilot that obeys, the delay of telemetry included [s]."""


class Obedience:
    r"""Whether an autopilot steers by the attitude commanded to it, or is on its way there.

    An autopilot may shape its command: ArduCopter's target follows a step with `ATC_INPUT_TC`, 0.15 s, and is heard late. It is
    compared with the way from a slow follower to the command,

    .. math:: R_s \leftarrow R_s \exp\left((1 - e^{-\Delta t / \tau}) \log(R_s^T R)\right)

    so that one that is as fast as the follower, or faster, obeys.
    """

    def __init__(self) -> None:
        self._commanded: Array | None = None
        self._followed = np.eye(3)
        self._last = -math.inf

    def forget(self) -> None:
        self._commanded = None

    def follow(self, commanded: Array, now: float) -> None:
        rotation = rotation_body_to_world(commanded)
        if self._commanded is None:
            self._followed = rotation
        else:
            share = 1.0 - math.exp(-max(now - self._last, 0.0) / SHAPING)
            self._followed = self._followed @ pin.exp3(share * pin.log3(self._followed.T @ rotation))
        self._commanded, self._last = rotation, now

    def angle(self, steered: Array) -> float:
        if self._commanded is None:
            return math.nan
        off = pin.log3(self._commanded.T @ rotation_body_to_world(steered))
        behind = pin.log3(self._commanded.T @ self._followed)
        length = float(behind @ behind)
        share = min(max(float(off @ behind) / length, 0.0), 1.0) if length > 0.0 else 0.0
        return float(np.linalg.norm(off - share * behind))
