r"""Where the centre of mass may be for rotors that hold a level vehicle: the bound on the arm's static moment.

Gravity's moment about O_B, :math:`c \times m g e_3`, is held by rotor thrusts
:math:`f_i = m g\,(B^+_{i0} + B^+_{i1} c_y - B^+_{i2} c_x)`. With every :math:`f_i` between 0 and its limit, the horizontal part
of c lies in a polygon around O_B.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array, frozen
from doorman.exceptions import BackendError
from doorman.kinematics.vehicles.rotor_layout import RotorLayout, rotor_layout
from doorman.kinematics.vehicles.vehicle import Vehicle

_SAME = 5
"""Digits by which the directions of two sides are the same."""
_LEAST_SLOPE = 1e-9
"""Least slope of a rotor that feels the centre of mass [N/m]."""


@dataclass(frozen=True)
class Balance:
    r"""Sides of the polygon: :math:`n_k^T c \le r_k`."""

    normals: Array
    """Outward, body axes x and y, shape (k, 2)."""
    reaches: Array
    """Distances of the sides from O_B; negative where the rotors cannot lift the weight, shape (k,) [m]."""

    @classmethod
    def of(cls, layout: RotorLayout, weight: float) -> Balance:
        """Polygon of a vehicle."""
        inverse = weight * layout.inverse
        slopes = np.column_stack([-inverse[:, 2], inverse[:, 1]])
        sides: dict[tuple[float, ...], tuple[Array, float]] = {}
        for slope, level, limit in zip(slopes, inverse[:, 0], layout.max_thrusts, strict=True):
            size = float(np.linalg.norm(slope))
            if size < _LEAST_SLOPE:
                continue
            for normal, room in ((slope / size, limit - level), (-slope / size, level)):
                key = tuple((np.round(normal, _SAME) + 0.0).tolist())
                if key not in sides or room / size < sides[key][1]:
                    sides[key] = (normal, float(room / size))
        return cls(
            frozen([normal for normal, _ in sides.values()]).reshape(-1, 2), frozen([r for _, r in sides.values()])
        )

    def room(self, center: Array) -> Array:
        """Distance of a centre of mass from every side, negative outside."""
        return np.asarray(self.reaches - self.normals @ center[:2])

    def numbers(self) -> dict[str, Array]:
        """Normals and reaches in SI units, by the names that a symbolic task knows them by."""
        return {"balance.normals": self.normals.ravel(), "balance.reaches": self.reaches}


def balance_numbers(vehicle: Vehicle) -> dict[str, Array]:
    """Bodies and polygon of a vehicle, by the names that a symbolic task knows them by; nothing of a balanced one."""
    polygon = balance_of(vehicle)
    bodies = {} if vehicle.bodies.balanced else vehicle.bodies.numbers()
    return bodies if polygon is None else {**bodies, **polygon.numbers()}


def balance_of(vehicle: Vehicle) -> Balance | None:
    """Polygon of a vehicle whose arm has mass, or whose centre of mass is not O_B."""
    if vehicle.bodies.balanced:
        return None
    try:
        layout = rotor_layout(vehicle, torque_per_thrust=1.0)  # it scales yaw alone
    except BackendError:
        return None
    return Balance.of(layout, vehicle.weight)
