r"""Velocity and body rates: slopes of straight lines through the poses of a short window, by least squares.

.. math::
    v = \frac{\sum_i \tau_i\, P_i}{\sum_i \tau_i^2}, \qquad
    \Omega = \frac{\sum_i \tau_i \log(q_n^{-1} q_i)}{\sum_i \tau_i^2}, \qquad \tau_i = t_i - \bar t

At constant velocity they are exact, whatever poses are missing. Otherwise they are those of the window's middle: they lag by
:math:`t_n - \bar t`, half the window where no pose is missing. Noise of σ in the position gives
:math:`\sigma / \sqrt{\textstyle\sum \tau_i^2}` in the velocity.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from doorman.hardware.quaternions import Quaternion, Vector, conjugate, multiply, rotation_vector

FEWEST = 3
"""Poses that are kept however old they are."""
_TOLERANCE = 1e-9


class TimedPose(NamedTuple):
    """A pose of the body."""

    time: float  # by the frames' own clock [s]
    position: Vector  # world frame [m]
    quaternion: Quaternion  # body to world


class VelocityFilter:
    """Poses of the last moments and the velocity that they show."""

    def __init__(self, window: float) -> None:
        self._window = window
        self._poses: deque[TimedPose] = deque()
        self.velocity: Vector = (0.0, 0.0, 0.0)  # world frame [m/s]; means nothing before there are two poses
        self.body_rates: Vector = (0.0, 0.0, 0.0)  # body frame [rad/s]
        self.lag = 0.0  # between the time for which these are true and the newest pose [s]

    @property
    def newest(self) -> TimedPose | None:
        """Newest pose, if there is any."""
        return self._poses[-1] if self._poses else None

    def clear(self) -> None:
        """Forget everything."""
        self._poses.clear()

    def add(self, pose: TimedPose) -> None:
        """Take in a pose."""
        poses = self._poses
        poses.append(pose)
        while len(poses) > FEWEST and pose.time - poses[0].time > self._window + _TOLERANCE:
            poses.popleft()
        if len(poses) < 2:
            return
        mean = sum(one.time - pose.time for one in poses) / len(poses)
        back = conjugate(pose.quaternion)
        spread = 0.0
        sums = [0.0] * 6
        for time, position, quaternion in poses:
            tau = time - pose.time - mean
            spread += tau * tau
            turn = rotation_vector(multiply(back, quaternion))
            for axis in range(3):
                sums[axis] += tau * (position[axis] - pose.position[axis])
                sums[3 + axis] += tau * turn[axis]
        self.velocity = (sums[0] / spread, sums[1] / spread, sums[2] / spread)
        self.body_rates = (sums[3] / spread, sums[4] / spread, sums[5] / spread)
        self.lag = -mean
