"""Backend: what the mission loop flies, be it a simulator or a vehicle; nothing in the loop knows which."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measurement:
    """What the sensors say at one time; the door's angle is not among it."""

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


@dataclass(frozen=True)
class Command:
    """What is asked of the vehicle until the next command."""

    thrust: float
    """f_t along the body's z axis [N]."""
    attitude: Array
    """Φ_d, shape (3,) [rad]."""
    arm_rates: Array
    """Ḣ_d, shape (n,) [rad/s]."""


class Backend(ABC):
    """A vehicle with an arm, simulated or real. Constructors touch no device: `open` does, and `with` always stops."""

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

    def __enter__(self) -> Backend:
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.stop()
