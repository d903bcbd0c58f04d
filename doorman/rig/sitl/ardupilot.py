"""ArduPilot's own code as the rig's autopilot: its simulation in the loop ("SITL") flies the rig's plant over its JSON interface.

Source: ArduPilot, libraries/SITL/examples/JSON/readme.md. The two run in lockstep: ArduPilot answers every state with the outputs
of its motors, and waits for the next state.
"""

from __future__ import annotations

import contextlib
import select
import shlex
import socket
import struct
import time
from pathlib import Path

import numpy as np

from doorman.arrays import Array
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.wire.frames import flu_to_frd
from doorman.kinematics.rotations import quaternion_of
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.rig.emulators.autopilot.dialects import MotorKind
from doorman.rig.sitl.rotor_pilot import RotorPilot
from doorman.simulation.truth import Truth

SERVO_PORT = 9002
"""UDP port to which ArduPilot sends the outputs of its motors."""
FRAMES = {
    4: ((45.0, 1), (-135.0, 1), (-45.0, -1), (135.0, -1)),
    6: ((90.0, -1), (-90.0, 1), (-30.0, -1), (150.0, 1), (30.0, 1), (-150.0, -1)),
    8: ((22.5, -1), (-157.5, -1), (67.5, 1), (157.5, 1), (-22.5, 1), (-112.5, 1), (-67.5, -1), (112.5, -1)),
}
"""ArduPilot's frames of type X by number of rotors: of every output the angle from the front, clockwise seen from above [deg],
and the sense, +1 counter-clockwise. Source: AP_MotorsMatrix.cpp."""
EXPO, FULL = 0.65, 0.95
"""MOT_THST_EXPO and MOT_SPIN_MAX: what ArduPilot makes of thrust, and the plant undoes."""
PARAMETERS = Path(__file__).with_name("ardupilot.parm")
"""Parameters that ArduPilot starts with, but for the frame's class."""
_CLASSES = {4: 1, 6: 2, 8: 3}
_MAGICS = {18458: 16, 29569: 32}
_LEAST_PWM = 1050
_FARTHEST = 20


def outputs_of(layout: RotorLayout) -> list[int]:
    """ArduPilot's output of every rotor, from 0, matched by where they are."""
    frame = FRAMES.get(layout.count)
    if frame is None:
        raise BackendError("ArduPilot has no such frame here", field="rotors", given=layout.count,
                           allowed=", ".join(map(str, FRAMES)))  # fmt: skip
    azimuths = np.degrees(np.arctan2(-layout.positions[:, 1], layout.positions[:, 0]))
    off = np.abs((azimuths[:, None] - [angle for angle, _ in frame] + 180.0) % 360.0 - 180.0)
    outputs: list[int] = off.argmin(axis=1).tolist()
    if off.min(axis=1).max() > _FARTHEST or len(set(outputs)) < layout.count:
        raise BackendError("the rotors are not those of ArduPilot's X frame", field="rotors",
                           given=f"{', '.join(f'{one:.0f}' for one in azimuths)}° clockwise from the front",
                           allowed=", ".join(f"{angle:g}" for angle, _ in frame))  # fmt: skip
    return outputs


class ArduPilotSitl(RotorPilot):
    program = "ArduPilot"
    rate = 400.0  # ArduCopter's loop rate
    _kind = socket.SOCK_DGRAM

    def __init__(self, layout: RotorLayout, port: int = SERVO_PORT, motors: MotorKind = "linear") -> None:
        super().__init__(port)
        self._outputs = outputs_of(layout)
        self.directions = np.array([float(FRAMES[layout.count][output][1]) for output in self._outputs])
        self._limits = layout.max_thrusts
        self._expo = EXPO if motors == "linear" else 1.0
        self._peer: tuple[str, int] | None = None
        self._pwm = np.zeros(max(_MAGICS.values()))
        self._frame = 0

    @property
    def connected(self) -> bool:
        return self._peer is not None

    def stop(self) -> None:
        super().stop()
        self._peer = None

    def thrusts(self, now: float) -> Array | None:
        if not self._listen(now):
            self._peer = None
            return None
        outputs = self._pwm[self._outputs]
        if not (outputs > _LEAST_PWM).any():
            return None
        spin = np.clip((outputs - 1000.0) / 1000.0, 0.0, 1.0)
        share = _thrust(spin, self._expo) / _thrust(np.array(FULL), self._expo)
        return np.minimum(share, 1.0) * self._limits

    def _send(self, truth: Truth, force: Array) -> None:
        assert self._socket is not None and self._peer is not None, "it is connected"
        w, x, y, z = quaternion_of(truth.attitude.tolist())
        text = (
            f'\n{{"timestamp":{truth.time - self._boot:.6f},"imu":{{"gyro":{_turned(truth.body_rates)},'
            f'"accel_body":{_turned(force)}}},"position":{_turned(truth.position)},"velocity":{_turned(truth.velocity)},'
            f'"quaternion":[{w:.7f},{x:.7f},{-y:.7f},{-z:.7f}],"no_time_sync":1}}\n'
        )
        with contextlib.suppress(OSError):  # ArduPilot has ended
            self._socket.sendto(text.encode(), self._peer)

    def command(self, pixhawk_port: int, folder: Path) -> str:
        defaults = folder / PARAMETERS.name
        frame = f"FRAME_CLASS {_CLASSES[len(self._limits)]}\n"
        defaults.write_text(PARAMETERS.read_text(encoding="utf-8") + frame, encoding="utf-8")
        words = ["arducopter", "--wipe", "--model", "JSON:127.0.0.1", "--defaults", str(defaults), "--speedup", "1"]
        return shlex.join([*words, "--serial0", f"udpclient:127.0.0.1:{pixhawk_port}"])

    def _listen(self, now: float) -> bool:
        """Take the answer to the last state; whether it has come in time."""
        if self._socket is None:
            return False
        deadline, heard = time.monotonic() + (self.patience if self.connected else 0.0), False
        while True:
            try:
                data, peer = self._socket.recvfrom(256)
            except BlockingIOError:
                left = deadline - time.monotonic()
                if heard or left <= 0.0:
                    return heard
                select.select([self._socket], [], [], left)
                continue
            except OSError:
                return False
            heard = self._take(data, peer, now) or heard

    def _take(self, data: bytes, peer: tuple[str, int], now: float) -> bool:
        if len(data) < 8:
            return False
        magic, _, frame = struct.unpack_from("<HHI", data)
        count = _MAGICS.get(magic, 0)
        if count == 0 or len(data) < 8 + 2 * count:
            return False
        if self._peer is None or frame < self._frame:  # it starts, anew perhaps: its clock begins at zero
            self._boot = now
        self._peer, self._frame = peer, frame
        self._pwm[:count] = struct.unpack_from(f"<{count}H", data, 8)
        return True


def _thrust(spin: Array, expo: float) -> Array:
    return (1.0 - expo) * spin + expo * spin * spin


def _turned(vector: Array) -> str:
    """In ArduPilot's axes, as JSON: from x forward, y left, z up to x forward, y right, z down, in the body and in the world."""
    x, y, z = flu_to_frd(vector)
    return f"[{x:.6f},{y:.6f},{z:.6f}]"
