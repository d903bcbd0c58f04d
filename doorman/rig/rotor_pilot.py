"""What the rig asks of an autopilot's own code that drives the plant's rotors."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from doorman.simulation.truth import Truth

Array = NDArray[np.float64]


class RotorPilot(Protocol):
    """An autopilot's own code ("software in the loop") at the other end of a socket on loopback.

    The two run in lockstep: it answers every state with the outputs of its motors, and waits for the next state. Before it has
    called, and after it has fallen silent, the motors stand still.
    """

    program: str
    """What it is called."""
    rate: float
    """States a second [1/s]."""
    directions: Array
    """In which the rotors turn, +1 counter-clockwise seen from above, shape (m,)."""

    def start(self) -> None:
        """Listen, on loopback only.

        Raises:
            BackendError: if the port is taken.
        """

    def stop(self) -> None:
        """Listen no more; may be called twice."""

    def thrusts(self, now: float) -> Array | None:
        """Thrust of every rotor that the autopilot asks for, once it has answered the last state; None: the motors stand still.

        Args:
            now: Time of the plant [s].

        Returns:
            Shape (m,) [N].
        """

    def tell(self, truth: Truth) -> None:
        """Send what the autopilot's sensors are made of.

        Args:
            truth: Newest state of the plant.
        """

    def command(self, pixhawk_port: int, folder: Path) -> str:
        """What starts the autopilot in another terminal, with its parameters in a file of its own.

        Args:
            pixhawk_port: UDP port on loopback that it sends to.
            folder: For the file.
        """
