"""Serial port with deadlines: bytes out, bytes in, and a clear word when the device is gone.

The port is opened by dynamixel-sdk's `PortHandler`, which knows the baud rates. Its own reading is not used: it polls without
sleeping, which holds up every other thread of the process, and checks its time-out only while bytes are missing.
"""

from __future__ import annotations

import contextlib
import os
import select
from pathlib import Path
from typing import Any

from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError, how_to_install

CHUNK = 4096
"""Most bytes taken at once."""
LATENCY_TIMERS = Path("/sys/bus/usb-serial/devices")


class PortLost(BackendError):
    """The serial device is gone: unplugged, or closed under the adapter."""


class SerialPort:
    def __init__(self, path: str, baud_rate: int, clock: Clock = REAL_TIME) -> None:
        self._path, self._baud_rate, self._clock = path, baud_rate, clock
        self._handler: Any = None
        self._descriptor = -1

    def open(self) -> None:
        try:
            import dynamixel_sdk as sdk
        except ImportError as error:
            raise BackendError(
                f"the servos need dynamixel-sdk; {how_to_install('hardware')}", field="dynamixel_sdk"
            ) from error
        if not os.path.exists(self._path):
            raise BackendError("no such serial device", field="servos.port", given=self._path,
                               allowed="a device such as /dev/ttyUSB0, or better its link in /dev/serial/by-id")  # fmt: skip
        handler = sdk.PortHandler(self._path)
        try:
            opened = handler.setBaudRate(self._baud_rate)
            if opened:
                handler.ser.exclusive = True
        except Exception as error:  # pyserial lets through errors of termios, fcntl and its own
            with contextlib.suppress(Exception):
                handler.closePort()
            raise BackendError(f"the serial device cannot be opened: {error}", field="servos.port", given=self._path,
                               allowed="a device that may be read and written, used by no other program") from error  # fmt: skip
        if not opened:
            raise BackendError("no such baud rate", field="servos.baud_rate", given=self._baud_rate,
                               allowed="9600, 57600, 115200, 1000000, 2000000, 3000000 or 4000000")  # fmt: skip
        with contextlib.suppress(Exception):  # a pseudo-terminal has none; what the kernel made of it is checked below
            handler.ser.set_low_latency_mode(True)
        self._handler = handler
        self._descriptor = handler.ser.fileno()

    @property
    def latency_timer(self) -> int | None:
        """Of a USB adapter [ms]."""
        timer = LATENCY_TIMERS / Path(os.path.realpath(self._path)).name / "latency_timer"
        try:
            return int(timer.read_text(encoding="ascii"))
        except (OSError, ValueError):
            return None

    def send(self, data: bytes, deadline: float) -> bool:
        while data:
            try:
                data = data[os.write(self._descriptor, data) :]
            except BlockingIOError:
                left = deadline - self._clock.now()
                if left <= 0.0:
                    return False
                select.select([], [self._descriptor], [], left)  # in real time: it is the device that is awaited
            except OSError as error:
                raise self._lost(error) from error
        return True

    def receive(self, deadline: float) -> bytes:
        try:
            if not self._clock.readable([self._descriptor], max(deadline - self._clock.now(), 0.0)):
                return b""
            data = os.read(self._descriptor, CHUNK)
        except BlockingIOError:
            return b""
        except (OSError, ValueError) as error:
            raise self._lost(error) from error
        if not data:
            raise self._lost("end of file")
        return data

    def close(self) -> None:
        if self._handler is not None:
            with contextlib.suppress(Exception):  # the device may be gone
                self._handler.closePort()
        self._handler = None
        self._descriptor = -1

    def _lost(self, why: object) -> PortLost:
        return PortLost(f"the serial device is gone: {why}", field="servos.port", given=self._path)
