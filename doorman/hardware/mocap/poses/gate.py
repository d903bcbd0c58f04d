r"""Which poses can follow one another, by what the vehicle can do at most.

.. math::
    |\Delta P| \le n + v_{max} \Delta t, \qquad
    |\Delta P - v\,\Delta t| \le n + a_{max} \Delta t\,(\tfrac12 \Delta t + \lambda), \qquad
    \angle(q, q') \le n_q + \omega_{max} \Delta t

λ is the lag of the velocity v, in which it may have changed by a λ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from doorman.hardware.mocap.poses.velocity import TimedPose
from doorman.hardware.quaternions import Vector, angle_between


@dataclass(frozen=True)
class MotionGate:
    """Limits of the vehicle's motion and of the poses' noise."""

    max_speed: float  # [m/s]
    max_acceleration: float  # [m/s²]
    max_rotation_rate: float  # [rad/s]
    position_slack: float  # n: what noise and vibration add [m]
    attitude_slack: float  # n_q [rad]

    def beyond_speed(self, former: TimedPose, pose: TimedPose) -> str:
        """Whether the body would have had to move or turn too fast from pose to pose."""
        elapsed = pose.time - former.time
        distance = math.dist(former.position, pose.position)
        if not distance <= self.position_slack + self.max_speed * elapsed:
            return f"{distance:.3f} m in {1e3 * elapsed:.0f} ms"
        angle = angle_between(former.quaternion, pose.quaternion)
        if not angle <= self.attitude_slack + self.max_rotation_rate * elapsed:
            return f"{math.degrees(angle):.0f}° in {1e3 * elapsed:.0f} ms"
        return ""

    def beyond_limits(self, former: TimedPose, pose: TimedPose, velocity: Vector, lag: float) -> str:
        """Whether the body would have had to move, turn or speed up too much since the last pose."""
        too_fast = self.beyond_speed(former, pose)
        if too_fast:
            return too_fast
        elapsed = pose.time - former.time
        miss = math.dist(
            pose.position, [place + elapsed * rate for place, rate in zip(former.position, velocity, strict=True)]
        )
        if not miss <= self.position_slack + self.max_acceleration * elapsed * (0.5 * elapsed + lag):
            return f"{miss:.3f} m off its course in {1e3 * elapsed:.0f} ms"
        return ""
