"""Ways to ask emulated servos without the adapter: dynamixel-sdk, and raw bytes."""

from __future__ import annotations

import os
from typing import Any

import dynamixel_sdk as sdk
from virtual_time import CLOCK

from doorman.rig.emulators.servos import ServoEmulator


class PatientPort(sdk.PortHandler):
    """A port of the SDK that waits longer than 34 ms, and in virtual time: the SDK looks at the clock without end."""

    def setPacketTimeout(self, packet_length: int) -> None:
        self.setPacketTimeoutMillis(150.0)

    def getCurrentTime(self) -> float:
        return 1e3 * CLOCK.now()

    def readPort(self, length: int) -> Any:
        CLOCK.readable([self.ser], 0.001)
        return super().readPort(length)


class Client:
    """A port of the SDK with short ways to read and write."""

    def __init__(self, emulator: ServoEmulator) -> None:
        self.port = PatientPort(emulator.port)
        assert self.port.setBaudRate(1_000_000)
        self.packets = sdk.PacketHandler(2.0)

    def write(self, address: int, size: int, value: int, servo_id: int = 1) -> int:
        """Error byte of a write."""
        data = list(value.to_bytes(size, "little", signed=value < 0))
        result, error = self.packets.writeTxRx(self.port, servo_id, address, size, data)
        assert result == sdk.COMM_SUCCESS
        return error

    def read(self, address: int, size: int, servo_id: int = 1) -> int:
        data, result, error = self.packets.readTxRx(self.port, servo_id, address, size)
        assert (result, error & 0x7F) == (sdk.COMM_SUCCESS, 0)
        return int.from_bytes(bytes(data), "little", signed=True)


def exchange(emulator: ServoEmulator, packet: str, wait: float = 0.05) -> bytes:
    """Send raw bytes and collect what comes back until the line falls silent."""
    descriptor = os.open(emulator.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        os.write(descriptor, bytes.fromhex(packet))
        answer = b""
        while CLOCK.readable([descriptor], wait):
            answer += os.read(descriptor, 4096)
        return answer
    finally:
        os.close(descriptor)
