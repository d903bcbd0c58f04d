"""Signals between a vehicle and what flies it: what is measured, and what is commanded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.one_line import OneLine


@dataclass(frozen=True, eq=False, repr=False)
class LeafReading(OneLine):
    """Where a sensor of the door has seen the leaf."""

    joint: float
    """Value of the door's joint, as in its URDF [rad, or m]."""
    time: float
    """When that was true, since the backend was opened [s]; the same as before if nothing new has come."""
    deviation: float
    """Its standard deviation [rad, or m]."""


@dataclass(frozen=True, eq=False, repr=False)
class FrameReading(OneLine):
    """Where a sensor of the door has seen its frame: what stands around the leaf, as the door's URDF draws it."""

    position: Array
    """Of the origin of the door's URDF, shape (3,), world frame [m]; zeros where the map is right."""
    yaw: float
    """By which the door is turned about the vertical against its URDF [rad]."""
    time: float
    """When that was true, since the backend was opened [s]."""
    position_deviation: float
    """Standard deviation along each axis, at the door [m]."""
    yaw_deviation: float
    """Standard deviation [rad]."""

    def placed(self, point: Array) -> Array:
        """Where a point of the map's door is.

        Args:
            point: As the door's URDF has it, shape (3,), world frame [m].

        Returns:
            The same point of the measured door, shape (3,), world frame [m].
        """
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        x, y, z = point.tolist()
        return np.asarray(self.position + [cosine * x - sine * y, sine * x + cosine * y, z])


@dataclass(frozen=True, eq=False, repr=False)
class Measurement(OneLine):
    """What the sensors say at one time. Only a vehicle or laboratory with a sensor of the door has `leaf` and `frame`."""

    time: float
    """Since the backend was opened [s]."""
    position: Array
    """P of O_B, shape (3,), world frame [m]."""
    velocity: Array
    """Ṗ, shape (3,), world frame [m/s]."""
    attitude: Array
    """Φ = [φ, θ, ψ], shape (3,) [rad]."""
    body_rates: Array
    """Ω, shape (3,), body frame [rad/s]."""
    arm_angles: Array
    """H, shape (n,) [rad]."""
    arm_rates: Array
    """Ḣ, shape (n,) [rad/s]."""
    pose_time: float
    """When position, velocity and attitude were true, as the receiver knows it [s]: at most `time`, the same as before if
    nothing new has come, and before 0 where the pose is older than the backend's opening."""
    arm_time: float | None = None
    """When the arm's angles were true [s]; None: at `time`."""
    tip_force: float | None = None
    """With which a tip that pushes presses on what it touches, along the face's normal [N]; None without a sensor or a reading
    of it."""
    leaf: LeafReading | None = None
    """Where the leaf is; None without a sensor or a usable reading of it."""
    frame: FrameReading | None = None
    """Where the door's frame is; None without a sensor or a usable reading of it."""


@dataclass(frozen=True, eq=False, repr=False)
class Command(OneLine):
    """What the vehicle is to do until the next command."""

    thrust: float
    """f_t along the body's z axis [N]."""
    attitude: Array
    """Φ_d, shape (3,) [rad]."""
    arm_rates: Array
    """Ḣ_d, shape (n,) [rad/s]."""
    grip: bool = False
    """Whether the tip holds on to the leaf that it touches; a tip that can only push takes no notice."""
    side_force: tuple[float, float] = (0.0, 0.0)
    """Force along the body's x and y axis, of a fully actuated vehicle [N]."""

    @property
    def body_force(self) -> Array:
        """Force of the rotors, shape (3,), body frame [N]."""
        return np.array([*self.side_force, self.thrust])
