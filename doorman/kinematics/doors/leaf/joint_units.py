"""A door's angle α and what goes with it in the units of the URDF's joint, in numbers and in words."""

from __future__ import annotations

import math


class InJointUnits:
    """What turns α, its rate and its torque into values of the URDF's joint, and back."""

    slides: bool
    """Whether the joint is a slide."""
    closed: float
    """Value of the URDF's joint where the door is closed [rad or m]."""
    per_angle: float
    """Change of the joint's value for one of α: 1, or metres."""
    unit: str
    """Unit of the joint's value: `rad` or `m`."""
    _turns: float
    """Sense of α as the door opens, 1 or −1."""
    _sense: float
    """Sense of the joint's value as the door opens, 1 or −1."""

    def joint_value(self, door_angle: float) -> float:
        """Value of the URDF's joint at α [rad or m]."""
        return self.closed + self._sense * self.opening_of(float(door_angle))

    def joint_rate(self, door_rate: float) -> float:
        """Rate of the URDF's joint [rad/s or m/s]."""
        return self._sense * self._turns * self.per_angle * door_rate

    def joint_torque(self, torque: float) -> float:
        """Torque, or force, in the URDF's joint [N m or N]."""
        return self._sense * self._turns * torque / self.per_angle

    def angle_of_joint(self, value: float) -> float:
        """α at a value of the URDF's joint [rad]."""
        return self.angle_of_opening(self._sense * (float(value) - self.closed))

    def opening_of(self, door_angle: float) -> float:
        """How far the door is open from closed [rad or m]."""
        return self._turns * self.per_angle * (door_angle - 0.5 * math.pi)

    def torque_of_closer(self, preload: float) -> float:
        """Torque of a closer that shuts the door, in the sense of damping [N m]."""
        return self._turns * preload

    def angle_of_opening(self, opening: float) -> float:
        """α of a door that is so far open [rad]."""
        return 0.5 * math.pi + self._turns * opening / self.per_angle

    def in_words(self, door_angle: float, digits: int = 1) -> str:
        """Angle as people say it: in degrees, or a slide's opening in metres."""
        return (
            f"{round(self.opening_of(door_angle), 3) + 0.0:.3f} m"
            if self.slides
            else f"{math.degrees(door_angle):.{digits}f}°"
        )

    def torque_in_words(self, torque: float) -> str:
        """A torque in the hinge in N m, or a slide's force in N."""
        return f"{torque / self.per_angle:.2f} {'N' if self.slides else 'N m'}"

    def rate_in_words(self, rate: float) -> str:
        """A rate of α in rad/s, or a slide's speed in m/s."""
        return f"{self.per_angle * rate:.3f} {self.unit}/s"

    def way_in_words(self, way: float) -> str:
        """A difference of α as people say it: in degrees, or a slide's in centimetres."""
        return f"{1e2 * self.per_angle * way:.1f} cm" if self.slides else f"{math.degrees(way):.1f}°"
