"""A client of the emulated autopilot that is not doorman's adapter."""

from __future__ import annotations

import socket
from collections.abc import Callable
from typing import Any

from pixhawk_rig import wait_until
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot import EmulatedAutopilot


class Client:
    """A ground station of a few lines, written with pymavlink alone."""

    def __init__(self, emulator: EmulatedAutopilot, port: int) -> None:
        self.mav = mavlink.MAVLink(None, 255, 190)
        self.mav.robust_parsing = True
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.emulator = emulator
        self.seen: list[Any] = []

    def send(self, message: Any) -> None:
        self.socket.sendto(message.pack(self.mav), self.emulator.address)

    def command(self, number: int, *values: float) -> int:
        padded = [*values, *[0.0] * (7 - len(values))]
        self.seen.clear()
        self.send(mavlink.MAVLink_command_long_message(1, 1, number, 0, *padded))
        return int(self.get("COMMAND_ACK", lambda message: message.command == number).result)

    def get(self, kind: str, accept: Callable[[Any], bool] = lambda message: True) -> Any:
        found: list[Any] = []

        def look() -> bool:
            try:
                while True:
                    self.seen += self.mav.parse_buffer(self.socket.recv(65536)) or []
            except BlockingIOError:
                pass
            found.extend(message for message in self.seen if message.get_type() == kind and accept(message))
            return bool(found)

        assert wait_until(look), f"no {kind}"
        return found[-1]
