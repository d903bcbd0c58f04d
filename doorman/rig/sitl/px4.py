"""PX4's own code as the rig's autopilot: its simulation in the loop ("SITL") flies the rig's plant over its MAVLink interface.

PX4 calls by TCP, gets HIL_SENSOR and answers with HIL_ACTUATOR_CONTROLS. Its clock is the one of these messages. Where the rotors
are, and how they turn, it learns from its parameters, so that any vehicle will do. Source: PX4, docs/en/simulation and
simulator_mavlink.
"""

from __future__ import annotations

import contextlib
import select
import shlex
import socket
import time
from pathlib import Path
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.wire.frames import flu_to_frd
from doorman.hardware.pixhawk.wire.messages import mavlink
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.rig.emulators.autopilot.control import rotor_parameters
from doorman.rig.emulators.autopilot.dialects import MotorKind
from doorman.rig.sitl.rotor_pilot import RotorPilot
from doorman.simulation.truth import Truth

SIMULATOR_PORT = 4560
"""TCP port that PX4's first instance calls; every further one calls the next."""
PIXHAWK_PORT = 14540
"""UDP port that PX4's first instance sends to, likewise."""
_MOST_INSTANCES = 10
MOST_ROTORS = 12
AIRFRAME = 10016
"""Airframe without a simulator of its own, whose rotors are replaced."""
PARAMETERS = Path(__file__).with_name("px4.parm")
"""Parameters that PX4 starts with, but for the rotors'."""
_BACKLOG = 1_000_000
"""Most unanswered time of states; beyond it PX4 gets no further ones [µs]."""
_ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
_MOTION, _FIELD, _AIR = 0b111111, 0b111000000, 0b1101000000000
_SLOW_EVERY = 5
"""States between two samples of magnetometer and barometer."""
_NORTH = np.array([0.21, 0.0, -0.42])
"""Earth's field, in the world: x north, z up [gauss]."""
_NOISE = {"acceleration": 0.02, "rate": 0.001, "field": 0.001, "pressure": 0.01}
"""Deviations [m/s²], [rad/s], [gauss], [hPa]: sensors that say the same again and again count as broken."""
_SEA_LEVEL, _PER_METRE = 1013.25, 0.12
"""Pressure and its gradient [hPa], [hPa/m]."""


def simulator_port(pixhawk_port: int) -> int:
    """TCP port that the instance of PX4 calls which sends to a port."""
    instance = pixhawk_port - PIXHAWK_PORT
    if not 0 <= instance < _MOST_INSTANCES:
        raise BackendError("no instance of PX4 sends there", field="pixhawk_port", given=pixhawk_port,
                           allowed=f"{PIXHAWK_PORT} to {PIXHAWK_PORT + _MOST_INSTANCES - 1}")  # fmt: skip
    return SIMULATOR_PORT + instance


def _parser() -> Any:
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True
    return parser


class Px4Sitl(RotorPilot):
    program = "PX4"
    rate = 250.0  # of PX4's gyroscope in simulation
    _kind = socket.SOCK_STREAM

    def __init__(self, layout: RotorLayout, port: int = SIMULATOR_PORT, motors: MotorKind = "linear") -> None:
        if layout.count > MOST_ROTORS:
            raise BackendError(
                "PX4 has no such vehicle", field="rotors", given=layout.count, allowed=f"up to {MOST_ROTORS}"
            )
        super().__init__(port)
        self.directions = layout.directions
        self._layout, self._motors = layout, motors
        self._peer: socket.socket | None = None
        self._mavlink = _parser()
        self._random = np.random.default_rng(0)
        self._count, self._sent, self._heard = 0, 0, -1
        self._in_step = False
        self._controls: Array | None = None

    @property
    def connected(self) -> bool:
        return self._peer is not None

    def stop(self) -> None:
        super().stop()
        self._hang_up()

    def thrusts(self, now: float) -> Array | None:
        if self._peer is None:
            self._answer_call(now)
        if self._peer is None:
            return None
        before = self._heard
        answered = self._listen()
        self._in_step = answered or self._heard > before  # one that is a state behind is worth waiting for
        if not answered or self._controls is None:
            return None
        signals: Array = np.clip(self._controls[: self._layout.count], 0.0, 1.0)
        return signals * signals * self._layout.max_thrusts

    def _send(self, truth: Truth, force: Array) -> None:
        assert self._peer is not None, "it is connected"
        if self._heard >= 0 and self._sent - self._heard > _BACKLOG:  # its clock waits for us to wait for it
            return
        to_body = rotation_body_to_world(truth.attitude).T
        slow = self._count % _SLOW_EVERY == 0
        self._count += 1
        self._sent = round((truth.time - self._boot) * 1e6)
        message = self._mavlink.hil_sensor_encode(
            self._sent,
            *self._measured(force, "acceleration"),
            *self._measured(truth.body_rates, "rate"),
            *self._measured(to_body @ _NORTH, "field"),
            _SEA_LEVEL - _PER_METRE * float(truth.position[2]) + _NOISE["pressure"] * self._random.standard_normal(),
            0.0,
            float(truth.position[2]),
            20.0,
            _MOTION | (_FIELD | _AIR if slow else 0),
        )
        try:
            self._peer.sendall(message.pack(self._mavlink))
        except OSError:  # PX4 has ended
            self._hang_up()

    def command(self, pixhawk_port: int, folder: Path) -> str:
        calls = simulator_port(pixhawk_port)
        if calls != self._port:
            raise BackendError("no instance of PX4 that sends to that pixhawk_port calls here", field="sitl_port",
                               given=self._port, allowed=str(calls))  # fmt: skip
        lines = PARAMETERS.read_text(encoding="utf-8").splitlines()
        parameters = dict(line.split() for line in lines if line and not line.startswith("#"))
        parameters["THR_MDL_FAC"] = "1" if self._motors == "linear" else "0"
        parameters["CA_ROTOR_COUNT"] = str(self._layout.count)
        parameters |= {name: f"{value:.4f}" for name, value in rotor_parameters(self._layout).items()}
        parameters |= {f"PWM_MAIN_FUNC{number + 1}": str(101 + number) for number in range(self._layout.count)}
        words = [f"PX4_SYS_AUTOSTART={AIRFRAME}", *(f"PX4_PARAM_{name}={value}" for name, value in parameters.items())]
        file = folder / "px4.env"
        file.write_text("\n".join(words) + "\n", encoding="utf-8")
        return f"env $(cat {shlex.quote(str(file))}) px4 -d -i {pixhawk_port - PIXHAWK_PORT}"

    def _measured(self, vector: Array, kind: str) -> list[float]:
        """In PX4's axes, x forward, y right, z down, with noise."""
        values: list[float] = flu_to_frd(vector + _NOISE[kind] * self._random.standard_normal(3)).tolist()
        return values

    def _answer_call(self, now: float) -> None:
        if self._socket is None:
            return
        with contextlib.suppress(OSError):  # no call yet
            peer, _ = self._socket.accept()
            peer.setblocking(False)
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._peer, self._boot, self._sent, self._heard = peer, now, 0, -1
            self._controls, self._in_step = None, False
            self._mavlink = _parser()

    def _hang_up(self) -> None:
        peer, self._peer, self._controls, self._in_step = self._peer, None, None, False
        if peer is not None:
            peer.close()

    def _listen(self) -> bool:
        """Take the answer to the last state, and wait for it if the one before came in time; whether it is there."""
        deadline = time.monotonic() + (self.patience if self._in_step else 0.0)
        while self._peer is not None and (left := deadline - time.monotonic()) > -self.patience:
            try:
                data = self._peer.recv(4096)
            except BlockingIOError:
                if self._heard >= self._sent or left <= 0.0:
                    break
                select.select([self._peer], [], [], left)
                continue
            except OSError:
                data = b""
            if not data:
                self._hang_up()
                return False
            for message in self._mavlink.parse_buffer(data) or ():
                if message.get_type() == "HIL_ACTUATOR_CONTROLS":
                    self._heard = int(message.time_usec)
                    self._controls = np.array(message.controls) if message.mode & _ARMED else None
        return self._heard >= self._sent
