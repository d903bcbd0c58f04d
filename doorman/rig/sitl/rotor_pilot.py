"""What the rig asks of an autopilot's own code that drives the plant's rotors."""

from __future__ import annotations

import socket
from abc import ABC, abstractmethod
from pathlib import Path

from doorman.arrays import Array
from doorman.background import Opened
from doorman.exceptions import BackendError
from doorman.gravity import weight_of
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.simulation.truth import Truth


class RotorPilot(Opened, ABC):
    """An autopilot's own code ("software in the loop") at the other end of a socket on loopback.

    The two run in lockstep: it answers every state with the outputs of its motors, and waits for the next state. Before it has
    called, and after it has fallen silent, the motors stand still.
    """

    program: str  # what it is called
    rate: float  # states a second [1/s]
    directions: Array  # in which the rotors turn, +1 counter-clockwise seen from above, shape (m,)
    patience = 0.5  # longest wait for an answer, and further time for a peer that sends other messages [s]
    _kind: socket.SocketKind

    def __init__(self, port: int) -> None:
        self._port, self._boot = port, 0.0  # the latter is the plant's time at which its clock began [s]
        self._socket: socket.socket | None = None
        self._last: Truth | None = None

    @property
    @abstractmethod
    def connected(self) -> bool:
        """Whether it has called, and not fallen silent since."""

    def open(self) -> None:
        """Take what comes to the port on loopback, and never wait for it."""
        one = socket.socket(socket.AF_INET, self._kind)
        try:
            if self._kind == socket.SOCK_STREAM:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            one.bind(("127.0.0.1", self._port))
            if self._kind == socket.SOCK_STREAM:
                one.listen(1)
        except OSError as error:
            one.close()
            raise BackendError(f"cannot listen: {error}", field="sitl port", given=self._port) from error
        one.setblocking(False)
        self._socket = one

    def stop(self) -> None:
        one, self._socket = self._socket, None
        if one is not None:
            one.close()

    @abstractmethod
    def thrusts(self, now: float) -> Array | None:
        """Thrust that the autopilot asks of every rotor, once it has answered the last state; None while motors stand still."""

    def tell(self, truth: Truth) -> None:
        """Send what the autopilot's sensors are made of."""
        last, self._last = self._last, truth
        if self.connected and last is not None and truth.time > last.time:
            acceleration = (truth.velocity - last.velocity) / (truth.time - last.time) + [0.0, 0.0, weight_of(1.0)]
            self._send(truth, rotation_body_to_world(truth.attitude).T @ acceleration)

    @abstractmethod
    def _send(self, truth: Truth, force: Array) -> None:
        """Send a state, and what accelerometers feel."""

    @abstractmethod
    def command(self, pixhawk_port: int, folder: Path) -> str:
        """What starts the autopilot in another terminal, with its parameters in a file of its own."""
