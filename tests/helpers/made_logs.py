"""Logs of autopilots, written byte by byte, of a flight whose rates are known."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np

from doorman.recording import Recorder

Rates = Callable[[np.ndarray], np.ndarray]


def tumbling(seed: int) -> Rates:
    """Body rates of a vehicle that is blown about: a sum of sines below 3 Hz, x forward, z up [rad/s]."""
    draw = np.random.default_rng(seed)
    frequency, phase = draw.uniform(0.1, 3.0, (3, 12)), draw.uniform(0.0, 6.3, (3, 12))
    size = draw.uniform(0.02, 0.1, (3, 12))

    def rates(time: np.ndarray) -> np.ndarray:
        waves = np.sin(2.0 * np.pi * frequency * np.asarray(time)[:, None, None] + phase)
        return np.sum(size * waves, axis=2)

    return rates


def write_run(file: Path, rates: Rates, duration: float, topics: dict[str, dict[str, float]] | None = None) -> None:
    """A run at 100 ticks a second; `topics` are written once, at its end."""
    time = np.arange(0.0, duration, 0.01)
    with Recorder(file, {"name": "made"}) as recorder:
        for at, rate in zip(
            time, rates(time) + 0.003 * np.random.default_rng(1).normal(size=(len(time), 3)), strict=True
        ):
            recorder.write("measurement", at, {"body_rates": rate, "position": np.zeros(3)})
        for name, fields in (topics or {}).items():
            recorder.write(name, 0.0, fields)


# ---------------------------------------------------------------- ULog


def _message(kind: bytes, content: bytes) -> bytes:
    return struct.pack("<Hc", len(content), kind) + content


class ULog:
    """A PX4 log with the topics that are added."""

    def __init__(self) -> None:
        self._head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + _message(b"B", bytes(40))
        self._formats, self._data, self._ids = b"", b"", 0

    def topic(self, name: str, fields: str, layout: str, rows: list[tuple]) -> None:
        """Fields after the timestamp as in a format's text, their struct layout, and rows that begin with the time [s]."""
        self._formats += _message(b"F", f"{name}:uint64_t timestamp;{fields}".encode())
        self._data += _message(b"A", struct.pack("<BH", 0, self._ids) + name.encode())
        for time, *values in rows:
            self._data += _message(b"D", struct.pack(f"<HQ{layout}", self._ids, round(time * 1e6), *values))
        self._ids += 1

    def words(self, time: float, text: str) -> None:
        self._data += _message(b"L", struct.pack("<BQ", ord("6"), round(time * 1e6)) + text.encode())

    def write(self, file: Path) -> None:
        file.write_bytes(self._head + self._formats + self._data)


def write_ulog(file: Path, rates: Rates, start: float, end: float, offset: float, rate: float = 50.0) -> None:
    """A flight as PX4 logs it by default: run = log + offset; rates with noise, x forward, y right, z down."""
    log = ULog()
    time = np.arange(start, end, 1.0 / rate)
    seen = rates(time + offset) * (1.0, -1.0, -1.0) + 0.01 * np.random.default_rng(2).normal(size=(len(time), 3))
    log.topic("vehicle_angular_velocity", "float[3] xyz;uint64_t sample;", "3fQ",
              [(at, *row, 2**64 - 1) for at, row in zip(time, seen, strict=True)])  # fmt: skip
    log.topic("battery_status", "float voltage_v;bool connected;", "f?", [(at, 15.2, True) for at in time[::50]])
    log.words(float(time[0]) + 0.5 * (end - start), "landed")
    log.write(file)


# ---------------------------------------------------------------- DataFlash


def _format(kind: int, name: str, layout: str, columns: str, size: int) -> bytes:
    return b"\xa3\x95\x80" + struct.pack(
        "<BB4s16s64s", kind, size + 3, name.encode(), layout.encode(), columns.encode()
    )


def write_dataflash(
    file: Path, rates: Rates, start: float, end: float, offset: float, rate: float = 50.0, gyro: bool = True
) -> None:
    """A flight as ArduPilot logs it: run = log + offset; with the rates of two gyroscopes, or of the controller in degrees."""
    time = np.arange(start, end, 0.02)
    seen = rates(time + offset) * (1.0, -1.0, -1.0) + 0.01 * np.random.default_rng(3).normal(size=(len(time), 3))
    data = _format(0x80, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 86)
    data += _format(201, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds", 41)
    data += _format(202, "IMU", "QBfff", "TimeUS,I,GyrX,GyrY,GyrZ", 21)
    data += _format(203, "RATE", "Qfff", "TimeUS,R,P,Y", 20)
    data += _format(204, "MSG", "QZ", "TimeUS,Message", 72)
    data += _format(205, "BAT", "Qc", "TimeUS,Volt", 10)
    data += b"\xa3\x95\xc9" + struct.pack("<QB16s16s", 1, 202, b"s#EEE", b"F----")
    for at, row in zip(time, seen, strict=True):
        micros = round(at * 1e6)
        if gyro:
            for instance in range(2):
                data += b"\xa3\x95\xca" + struct.pack("<QB3f", micros, instance, *row)
        data += b"\xa3\x95\xcb" + struct.pack("<Q3f", micros, *np.degrees(row))
    data += b"\xa3\x95\xcc" + struct.pack("<Q64s", round(end * 1e6), b"landed")
    data += b"\xa3\x95\xcd" + struct.pack("<Qh", round(end * 1e6), 1520)
    file.write_bytes(data)
