r"""Frames of MAVLink autopilots and of this project, and the conversions between them; they stand nowhere else.

World: z up, x forward, y left; body: x forward, y left, z up (FLU). An autopilot's local frame is NED, its body FRD. Both pairs
differ by half a turn about x, which is its own inverse:

.. math::
    v_{NED} = \mathrm{diag}(1, -1, -1)\, v_{world}, \qquad (w, x, y, z) \mapsto (w, x, -y, -z), \qquad \psi \mapsto -\psi

Quaternions are [w, x, y, z] and map the body to its world, shape (4,).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import vector
from doorman.kinematics.quaternions import Quaternion, multiply, rotate, wrap

_HALF_TURN: Array = np.array([1, -1, -1], float)
_HALF_TURN_QUATERNION: Array = np.array([1, 1, -1, -1], float)


def half_turned(values: ArrayLike) -> Array:
    """Vector (x, y, z) as (x, −y, −z): of the world in NED, of the body z up in the body z down, and back."""
    return np.multiply(np.asarray(values, dtype=np.float64), _HALF_TURN)


world_to_ned = ned_to_world = flu_to_frd = frd_to_flu = half_turned


def half_turned_quaternion(quaternion: ArrayLike) -> Array:
    """Attitude FLU → world as attitude FRD → NED, and back: (w, x, −y, −z)."""
    return np.multiply(np.asarray(quaternion, dtype=np.float64), _HALF_TURN_QUATERNION)


quaternion_world_to_ned = quaternion_ned_to_world = half_turned_quaternion


@dataclass(frozen=True)
class LocalFrame:
    """Where the autopilot's local frame stands in the world: its origin, and the world's direction of its north."""

    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """World frame [m]."""
    yaw: float = 0.0
    """Yaw of north about the world's z axis [rad]; 0 where north is the world's x, as with poses sent by this project."""
    _turn: Quaternion = field(init=False, repr=False, compare=False)
    _back: Quaternion = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        vector([*self.origin, self.yaw], 4, "pixhawk.local_frame")
        w, z = math.cos(0.5 * self.yaw), math.sin(0.5 * self.yaw)
        object.__setattr__(self, "_turn", (w, 0.0, 0.0, z))
        object.__setattr__(self, "_back", (w, 0.0, 0.0, -z))

    @classmethod
    def through(cls, position: ArrayLike, yaw: float, position_in_ned: ArrayLike, yaw_in_ned: float) -> LocalFrame:
        """Frame in which a pose that the autopilot reports is a known pose of the world.

        For flights by the autopilot's own estimate: put the vehicle down at a known place and compare.

        Args:
            position: True position, shape (3,), world frame [m].
            yaw: True yaw [rad].
            position_in_ned: As reported, shape (3,), NED [m].
            yaw_in_ned: As reported, clockwise from north [rad].
        """
        turned = cls((0.0, 0.0, 0.0), wrap(yaw + yaw_in_ned))
        x, y, z = (vector(position, 3, "position") - turned.vector_to_world(position_in_ned)).tolist()
        return cls((x, y, z), turned.yaw)

    def vector_to_world(self, values: ArrayLike) -> Array:
        """Direction, velocity or acceleration in the world.

        Args:
            values: In NED, shape (3,).

        Returns:
            Shape (3,), world frame, in the same unit.
        """
        return np.array(rotate(self._turn, ned_to_world(values).tolist()))

    def vector_to_ned(self, values: ArrayLike) -> Array:
        """Direction, velocity or acceleration in NED.

        Args:
            values: In the world, shape (3,).

        Returns:
            Shape (3,), NED, in the same unit.
        """
        return world_to_ned(rotate(self._back, np.asarray(values, dtype=np.float64).tolist()))

    def position_to_world(self, values: ArrayLike) -> Array:
        """Position in the world.

        Args:
            values: In NED, shape (3,) [m].

        Returns:
            Shape (3,), world frame [m].
        """
        return np.add(self.vector_to_world(values), self.origin)

    def position_to_ned(self, values: ArrayLike) -> Array:
        """Position in NED.

        Args:
            values: In the world, shape (3,) [m].

        Returns:
            Shape (3,), NED [m].
        """
        return self.vector_to_ned(np.asarray(values, dtype=np.float64) - np.asarray(self.origin))

    def quaternion_to_world(self, quaternion: ArrayLike) -> Array:
        """Attitude of the body in the world, FLU → world.

        Args:
            quaternion: [w, x, y, z], FRD → NED, shape (4,).

        Returns:
            [w, x, y, z], shape (4,).
        """
        return np.array(multiply(self._turn, quaternion_ned_to_world(quaternion).tolist()))

    def quaternion_to_ned(self, quaternion: ArrayLike) -> Array:
        """Attitude of the body in NED, FRD → NED.

        Args:
            quaternion: [w, x, y, z], FLU → world, shape (4,).

        Returns:
            [w, x, y, z], shape (4,).
        """
        return quaternion_world_to_ned(multiply(self._back, np.asarray(quaternion, dtype=np.float64).tolist()))

    def yaw_to_ned(self, yaw: float) -> float:
        """Yaw from north, clockwise, in (−π, π] [rad].

        Args:
            yaw: In the world, counter-clockwise [rad].
        """
        return wrap(self.yaw - yaw)
