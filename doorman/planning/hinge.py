"""What a plan takes the door's hinge for."""

from __future__ import annotations

import math
from typing import NamedTuple

from doorman.checks import number
from doorman.exceptions import DimensionError
from doorman.kinematics.doors.door import Door

_POSSIBLE = {
    "friction": (0.0, "a finite torque, not negative [N m]"), "disturbance": (-math.inf, "a finite torque [N m]"),
    "inertia": (math.ulp(0.0), "finite, positive [kg m²]"), "damping": (0.0, "finite, not negative [N m s/rad]"),
    "stiffness": (0.0, "finite, not negative [N m/rad]"),
}  # fmt: skip
"""Least value of each field, and what is allowed, in words."""


class Hinge(NamedTuple):
    """What is known of a hinge and is not the same in every plan, SI units."""

    friction: float
    """τ_c [N m]."""
    disturbance: float
    """τ_d of α̈ = … − τ_d/I_D, in the sense of damping: negative where it resists opening [N m]."""
    inertia: float
    """I_D of the leaf about the hinge [kg m²]."""
    damping: float
    """b [N m s/rad]."""
    stiffness: float
    """k of a spring or closer, relaxed at the door's `rest_angle` [N m/rad]."""

    @classmethod
    def of(cls, door: Door, disturbance: float = 0.0) -> Hinge:
        """Hinge as the scenario names it."""
        return cls(door.friction, disturbance + door.closing_torque, door.inertia, door.damping, door.stiffness)

    def changed(self, **values: float | None) -> Hinge:
        """The hinge with other values, by name; what is None stays."""
        hinge = self._replace(**{name: number(value, name) for name, value in values.items() if value is not None})
        for name, (least, allowed) in _POSSIBLE.items():
            value = getattr(hinge, name)
            if not (math.isfinite(value) and value >= least):
                raise DimensionError("impossible value of a hinge", field=name, given=value, allowed=allowed)
        return hinge

    def torque_at_rest(self, angle: float, rest_angle: float) -> float:
        """Torque of spring and disturbance in the sense of damping: negative where it resists opening [N m]."""
        return self.stiffness * (angle - rest_angle) + self.disturbance

    def numbers(self) -> dict[str, float]:
        """Numbers of the hinge in SI units, by the names that a task knows them by."""
        return {
            "door.friction": self.friction, "door.disturbance": self.disturbance, "door.inertia": self.inertia,
            "door.damping": self.damping, "door.stiffness": self.stiffness,
        }  # fmt: skip
