"""Between a vehicle and what flies it: what is measured, what is commanded, and the backend that the mission loop flies."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar, runtime_checkable

import numpy as np

from doorman.arrays import Array
from doorman.background import Opened
from doorman.one_line import OneLine
from doorman.stored_at_once import stored_at_once


@stored_at_once
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
    """Displacement of the origin of the door's URDF, shape (3,), world frame [m]; zeros where the map is right."""
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


@stored_at_once
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
    """With which a tip that is not tied presses on what it touches, along the face's normal [N]; None without a sensor or a
    reading of it."""
    leaf: LeafReading | None = None
    """Where the leaf is; None without a sensor or a usable reading of it."""
    frame: FrameReading | None = None
    """Where the door's frame is; None without a sensor or a usable reading of it."""


@stored_at_once
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
        return np.array((*self.side_force, self.thrust))

    def gripping(self, grip: bool) -> Command:
        """The same, with another `grip`."""
        return self if self.grip is grip else Command(self.thrust, self.attitude, self.arm_rates, grip, self.side_force)


Sample_co = TypeVar("Sample_co", covariant=True)


@runtime_checkable
class Source(Protocol[Sample_co]):
    """Three methods: poses of the vehicle come so (`PoseSource`), and readings of the door (`DoorSource`)."""

    def open(self) -> None:
        """Begin to receive; a source of poses waits for a steady one."""

    def read(self) -> Sample_co:
        """Newest sample, at once."""

    def stop(self) -> None:
        """End it; may be called twice."""


class Backend(Opened, ABC):
    """A vehicle with an arm, simulated or real. Constructors touch no device: `open` does, and `with` always stops."""

    real_time: bool = False
    """Whether the plant goes on while the mission computes: plans are made in a thread of their own then."""
    comes_back: bool = False
    """Whether the vehicle lands after the mission, and so leaves in the end even a door that would not stay by itself."""

    @property
    def feedback_lag(self) -> float:
        """Lag of the attitude loop's feedback, where feed-forward makes it follow commands sooner [s]; 0 if it has none."""
        return 0.0

    @abstractmethod
    def open(self) -> None:
        """Start the plant or connect the links; `read` may be called from here on.

        Raises:
            BackendError: if it cannot be opened.
        """

    @abstractmethod
    def read(self) -> Measurement:
        """Wait for the next tick of the controller and return what the sensors say then.

        Raises:
            BackendError: if no valid measurement arrives in time.
        """

    @abstractmethod
    def command(self, command: Command) -> None:
        """Send a command; it holds until the next one.

        Args:
            command: Thrust, attitude and joint rates.

        Raises:
            BackendError: if the command is not finite or cannot be sent.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop the arm and let go of every device; may be called twice."""

    def watch_mission(self, abort: Callable[[str], None]) -> None:  # noqa: B027 - most have nothing to ask
        """Take how the mission, which calls this before it opens the backend, is asked to leave the door and come back.

        Args:
            abort: To be called with the reason, from any thread.
        """
