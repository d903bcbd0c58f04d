r"""The kinematic constraint between vehicle and door, and the state conversion both ways.

:math:`P + R\,d = P_h + D_V c(\alpha) - o\,n_D + D_H e_3` (the paper's kinematic constraint, with o = 0 there), with the
leaf's direction c, its normal n_D and the lever J as `Door` has them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import vector
from doorman.copying import PerThread
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.arms.arm import ArmParameters, tip_motion
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.numba_types.handles import held
from doorman.one_line import OneLine

BESIDE = math.radians(14.0)
"""Direction of the tip from the vehicle beside the leaf's normal that friction easily carries, μ = 0.5."""

ROOM_TO_LEVEL = 0.045
"""Gap between disc and jamb below which a vehicle that grips, and leans on a door that stands, leaves the doorway: it swings
back about its tip as it levels to let go [m]."""
_GUSTS = 0.01
"""Room beyond that in which gusts move a vehicle at the leaf [m]."""


def distance_in_doorway(reach: float, room: float) -> float:
    r"""Distance from the hinge at which a vehicle can push all the way through, behind its tip, without meeting the latch jamb.

    Behind a tip at D_V, turned by β from the leaf's normal, the vehicle comes as far from the hinge's side of the doorway as
    :math:`\sqrt{(D_V - r\sin\beta)^2 + (r\cos\beta)^2}`. Nearer to the jamb it would have to push from the side, and the
    tip's force would turn it away.
    """
    beside, behind = reach * math.sin(BESIDE), reach * math.cos(BESIDE)
    return beside + math.sqrt(max(room**2 - behind**2, 0.0))


def distance_before_doorway(before: float, width: float, radius: float) -> float:
    r"""Largest distance from the hinge at which a vehicle before the frame holds a shut leaf with room to let go.

    With O_B at b before the frame, the disc's gap to the latch jamb is :math:`\sqrt{b^2 + (w - D_V)^2} - R_A`. The middle is
    farthest from both jambs.
    """
    needed = radius + ROOM_TO_LEVEL + _GUSTS
    return max(width - math.sqrt(max(needed**2 - max(before, 0.0) ** 2, 0.0)), 0.5 * width)


@dataclass(frozen=True, eq=False, repr=False)
class VehicleMotion(OneLine):
    """Where the vehicle is and how it moves, in the world frame."""

    position: Array
    """P of O_B, shape (3,) [m]."""
    velocity: Array
    """Ṗ, shape (3,) [m/s]."""


class Coupling:
    """Tie between the tip of a vehicle's arm and a point of a door's leaf: D_V from the hinge, D_H above its lower end [m]."""

    def __init__(self, vehicle: Vehicle, door: Door, distance_from_hinge: float, height: float) -> None:
        self.vehicle = vehicle
        self.door = door
        self.distance_from_hinge = distance_from_hinge
        self.height = height
        self.lever_length = door.lever_length(distance_from_hinge)
        """Speed of the contact point along the normal for a unit rate of α [m]."""
        self._own: PerThread[ArmParameters] = PerThread()

    @property
    def _arm(self) -> ArmParameters:
        return self._own.get(lambda: held(ArmParameters.of(self.vehicle.arm)))

    def contact_point(self, door_angle: float) -> Array:
        """Point where the tip touches the leaf."""
        return self.door.contact_point(door_angle, self.distance_from_hinge, self.height)

    def angle_of_face(self, before: float) -> float:
        """By how much α of a tip on the face is less if the face stands before its place [rad]."""
        return self.door.angle_of_face(before, self.distance_from_hinge)

    def vehicle_position(self, attitude: ArrayLike, door_angle: float, arm_angles: ArrayLike) -> Array:
        r"""Position of O_B with the tip at the contact point, :math:`P = P_h + D_V c(\alpha) + D_H e_3 - R\,d`."""
        n = self.vehicle.n_arm
        angles = vector(arm_angles, n, "arm_angles")
        tip = self._tip_in_world(vector(attitude, 3, "attitude"), np.zeros(3), angles, np.zeros(n))
        return self.contact_point(float(door_angle)) - tip[:3]

    def vehicle_motion(self, state: ArrayLike, body_rates: ArrayLike, arm_rates: ArrayLike) -> VehicleMotion:
        r"""Motion of the vehicle that belongs to a state: :math:`\dot P = \dot\alpha J - R(\Omega\times d) - R\dot d`."""
        n = self.vehicle.n_arm
        x = vector(state, 5 + n, "state")
        rates = vector(body_rates, 3, "body_rates"), vector(arm_rates, n, "arm_rates")
        tip = self._tip_in_world(x[:3], rates[0], x[5:], rates[1])
        lever = self.door.lever(float(x[3]), self.distance_from_hinge)
        return VehicleMotion(self.contact_point(float(x[3])) - tip[:3], float(x[4]) * lever - tip[3:])

    def door_state(
        self,
        position: ArrayLike,
        velocity: ArrayLike,
        attitude: ArrayLike,
        body_rates: ArrayLike,
        arm_angles: ArrayLike,
        arm_rates: ArrayLike,
    ) -> tuple[float, float]:
        r"""Door angle and rate from the tip: :math:`\alpha = \mathrm{atan2}(a^Tr,\ i^Tr) - \arcsin(o/|r|)`, r = P_e − P_h.

        :math:`\dot\alpha = -n_D^T\dot P_e/D_V` with the tip's velocity
        :math:`\dot P + R(\Omega\times d) + R\,\dot d` (the paper's state conversion, without its singularity).
        """
        n = self.vehicle.n_arm
        relative = self._tip_in_world(
            vector(attitude, 3, "attitude"), vector(body_rates, 3, "body_rates"),
            vector(arm_angles, n, "arm_angles"), vector(arm_rates, n, "arm_rates"),
        )  # fmt: skip
        angle = self.door.angle_of(vector(position, 3, "position") + relative[:3] - self.door.hinge_position)
        speed = float(self.door.normal(angle) @ (vector(velocity, 3, "velocity") + relative[3:]))
        return angle, -speed / self.lever_length

    def tips(self, attitudes: Array, arm_angles: Array) -> Array:
        r"""Tips of many postures relative to O_B, :math:`R\,d`."""
        still, arms = np.zeros(3 + self.vehicle.n_arm), np.ascontiguousarray(arm_angles)
        tips = [
            self._tip_in_world(attitude, still[:3], arm, still[3:])[:3]
            for attitude, arm in zip(np.ascontiguousarray(attitudes), arms, strict=True)
        ]
        return np.array(tips).reshape(-1, 3)

    def _tip_in_world(self, attitude: Array, body_rates: Array, arm_angles: Array, arm_rates: Array) -> Array:
        """Position and velocity of the tip relative to O_B, world axes, shape (6,)."""
        out = np.empty(6)
        tip_motion(self._arm, attitude, body_rates, arm_angles, arm_rates, out[:3], out[3:])
        return out
