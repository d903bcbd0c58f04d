r"""Force to the side over MAVLink: `thrust_body` of SET_ATTITUDE_TARGET, of an autopilot that knows its rotors to be tilted.

PX4 takes it with the bit THRUST_BODY_SET since 1.12 (`mavlink_receiver.cpp`). Since 1.14 its control allocation makes it, by
the rotors of the parameters CA_ROTORi. Each axis is normalised by the mean of what its rotors do
(`ControlAllocationPseudoInverse.cpp`), so that rotors i with the columns s, l of `RotorLayout` answer to

.. math::
    u_x = \frac{f_x}{f_{max}}\,\frac{\mathrm{mean}_{s_{ix} \ne 0} |s_{ix}|}{\mathrm{mean}_i\, l_i}

ArduPilot reads thrust along the body's z axis alone (`GCS_MAVLink_Copter.cpp`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.hardware.pixhawk.dialect import PX4, Dialect
from doorman.hardware.pixhawk.wire.frames import flu_to_frd
from doorman.kinematics.vehicles.rotor_layout import RotorLayout

COUNT, OLD_SWITCH = "CA_ROTOR_COUNT", "SYS_CTRL_ALLOC"
"""Number of rotors, and the switch that PX4 1.13 allocates by or not."""
_MOST_ROTORS = 12
"""Most rotors for which PX4 has parameters."""
_SAME_AXIS, _SAME_PLACE = 0.05, 0.2
"""Difference of unit vectors, and of positions as a share of the farthest rotor's distance, that is no other rotor."""


@dataclass(frozen=True)
class TiltedRotors:
    """Rotors as the autopilot must know them, and what it makes of a force to the side."""

    positions: tuple[tuple[float, float, float], ...]  # in the body, x forward, y left, z up [m]
    axes: tuple[tuple[float, float, float], ...]  # unit vectors of the thrusts, in the body
    side_scale: tuple[float, float]
    """Normalised thrust along the body's x and y axis, by that along z for the same force."""

    @classmethod
    def of(cls, layout: RotorLayout) -> TiltedRotors:
        """Rotors of a fully actuated vehicle, all alike."""
        lift, side = float(layout.inverse[:, 0].mean()), np.abs(layout.side_inverse)
        x, y = (float(each[each > 1e-6].mean()) / lift for each in side.T)
        return cls(_rows(layout.positions), _rows(layout.thrust_axes), (x, y))

    def missing(self, dialect: Dialect, values: Mapping[str, float]) -> str:
        """Why the autopilot does not make forces to the side; nothing if it does."""
        if dialect is not PX4:
            return f"{dialect.name} takes thrust along the body's z axis alone"
        if COUNT not in values or not round(values.get(OLD_SWITCH, 1.0)):
            return "PX4 before 1.14 makes thrust along the body's z axis alone"
        known, same_place = allocated(values), _SAME_PLACE * float(np.linalg.norm(self.positions, axis=1).max())
        for position, axis in zip(self.positions, self.axes, strict=True):
            if not any(
                math.dist(place, position) < same_place and math.dist(direction, axis) < _SAME_AXIS
                for place, direction in known
            ):
                x, y, z = flu_to_frd(axis)
                a, b, _ = flu_to_frd(position)
                return f"no CA_ROTOR at PX {a:.2f}, PY {b:.2f} with AX {x:.2f}, AY {y:.2f}, AZ {z:.2f}"
        return ""


def names(count: int = _MOST_ROTORS) -> list[str]:
    parts = ("PX", "PY", "PZ", "AX", "AY", "AZ")
    return [f"CA_ROTOR{i}_{part}" for i in range(min(count, _MOST_ROTORS)) for part in parts]


def allocated(values: Mapping[str, float]) -> list[tuple[Array, Array]]:
    """Position and direction of the thrust of every rotor that PX4 knows."""
    rotors = []
    for i in range(round(values.get(COUNT, 0.0))):
        place, axis = (
            flu_to_frd([values.get(f"CA_ROTOR{i}_{kind}{letter}", 0.0) for letter in "XYZ"]) for kind in "PA"
        )
        rotors.append((place, axis / max(float(np.linalg.norm(axis)), 1e-9)))
    return rotors


def _rows(values: Array) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in values)
