"""Devices and files that a vehicle file names: whether they are there, and ours."""

from __future__ import annotations

from pathlib import Path

from doorman.hardware.computer.doctor import Complaint, Host, Row, device_row, judged
from doorman.hardware.pixhawk.wire.connection import Transport, parse_connection
from doorman.hardware.vehicle_file.file import PIXHAWK, SERVOS, VehicleFile

_DEVICES = "doorman system udev | sudo tee /etc/udev/rules.d/99-doorman.rules"


def devices(host: Host, file: VehicleFile) -> list[Row]:
    rows = []
    for key, device in (("pixhawk", _serial(file.values.get(PIXHAWK))), ("servos", file.values.get(SERVOS))):
        if device is not None and Path(device).exists():
            rows.append(device_row(host, f"{key}: {device}", Path(device), "found; "))
        elif device is not None:
            words = "not found; plug it in, or give it this name by a udev rule"
            rows.append(Row(f"{key}: {device}", Complaint.MISSING, words, _DEVICES))
    if (key_file := file.values.get("pixhawk.signing_key")) is not None:
        command = f"head -c 32 /dev/urandom > {key_file}"
        rows.append(judged("signing key", key_file.is_file(), "there", "not there", command, Complaint.MISSING))
    return rows


def _serial(connection: str | None) -> str | None:
    if connection is None:
        return None
    endpoint = parse_connection(connection)
    return endpoint.device if endpoint.transport is Transport.SERIAL else None
