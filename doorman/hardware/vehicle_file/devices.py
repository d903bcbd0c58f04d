"""Devices and files that a vehicle file names: whether they are there, and ours."""

from __future__ import annotations

from pathlib import Path

from doorman.hardware.computer.doctor import Complaint, Host, Row
from doorman.hardware.pixhawk.wire.connection import Transport, parse_connection
from doorman.hardware.vehicle_file.file import PIXHAWK, SERVOS, VehicleFile

_DEVICES = "doorman system udev | sudo tee /etc/udev/rules.d/99-doorman.rules"


def devices(host: Host, file: VehicleFile) -> list[Row]:
    rows = []
    for key, device in (("pixhawk", _serial(file.values.get(PIXHAWK))), ("servos", file.values.get(SERVOS))):
        if device is not None:
            rows.append(_row(host, f"{key}: {device}", Path(device)))
    if (signing_key := file.values.get("pixhawk.signing_key")) is not None:
        there = signing_key.is_file()
        found = "there" if there else "not there"
        command = "" if there else f"head -c 32 /dev/urandom > {signing_key}"
        rows.append(Row("signing key", Complaint.NONE if there else Complaint.MISSING, found, command))
    return rows


def _serial(connection: str | None) -> str | None:
    if connection is None:
        return None
    endpoint = parse_connection(connection)
    return endpoint.device if endpoint.transport is Transport.SERIAL else None


def _row(host: Host, name: str, device: Path) -> Row:
    if not device.exists():
        return Row(name, Complaint.MISSING, "not found; plug it in, or give it this name by a udev rule", _DEVICES)
    if not host.may(device):
        found = "this user may not read and write it; log in again after this"
        return Row(name, Complaint.MISSING, found, "sudo usermod -aG dialout $USER")
    return Row(name, Complaint.NONE, "found; this user may read and write it")
