r"""Numbers of the shipped vehicle carried to one of another size, by Froude's law: gravity is the same for both.

With L times its lengths and M times its mass, a vehicle has M times its forces, and all that falls or tilts takes
:math:`\sqrt L` times as long. A number that is tuned for the shipped vehicle is multiplied by the scale of its unit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from doorman.kinematics.doors.door import Door
from doorman.scenario import ContactSection

_SHIPPED_RADIUS, _SHIPPED_MASS = 0.40, 3.0
"""R_A and m_A of the vehicle for which the numbers are tuned [m], [kg]."""
_SHIPPED_LEVER = ContactSection().distance_from_hinge
"""Distance from the hinge at which the shipped tip touches its leaf [m]."""
_SHIPPED_WIDTH = 1.2
"""Width of the shipped leaf [m]."""
_SHIPPED_LEAF = 11.0 * _SHIPPED_WIDTH
"""Mass of the shipped leaf times its width [kg m]."""


@dataclass(frozen=True)
class Scale:
    """Ratios of a vehicle's units to those of the shipped one."""

    length: float
    force: float
    """As of the weight."""

    @classmethod
    def of(cls, radius: float, mass: float) -> Scale:
        """Scale of a vehicle."""
        return cls(radius / _SHIPPED_RADIUS, mass / _SHIPPED_MASS)

    @property
    def time(self) -> float:
        """Scale of times."""
        return math.sqrt(self.length)

    @property
    def speed(self) -> float:
        """Scale of speeds."""
        return self.length / self.time

    @property
    def rate(self) -> float:
        """Scale of angular rates."""
        return 1.0 / self.time

    @property
    def torque(self) -> float:
        """Scale of torques."""
        return self.force * self.length

    @property
    def stiffness(self) -> float:
        """Scale of forces per length."""
        return self.force / self.length

    @property
    def damping(self) -> float:
        """Scale of forces per speed."""
        return self.force / self.speed

    def turned(self, door: Door, lever: float) -> float:
        """How many times farther than a leaf the same way of the tip turns a lever of a length [m]; 1 of anything else."""
        return max(_SHIPPED_LEVER * self.length / lever, 1.0) if door.in_plane else 1.0

    def hinge(self, door: Door) -> float:
        """Scale of a hinge's expected resistance: a room door's, unless leaf and vehicle are both smaller or larger.

        A lever resists at its end with the force of a door at its edge, whatever it weighs.
        """
        if door.in_plane:
            return sorted((self.torque, door.width / _SHIPPED_WIDTH, 1.0))[1]
        lever = door.per_angle if door.slides else door.height if door.lies else door.width
        return sorted((self.torque, door.mass * lever / _SHIPPED_LEAF, 1.0))[1]
