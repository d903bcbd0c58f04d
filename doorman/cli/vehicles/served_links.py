"""Which links of a vehicle file the rig can serve, and which options of `doorman fly` the others need."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.wire.connection import Transport, parse_connection
from doorman.hardware.vehicle_file import VehicleFile
from doorman.hardware.vehicle_file.file import MOCAP, NO_CAMERAS, PIXHAWK, SERVOS

OPTIONS = {"--pixhawk": PIXHAWK, "--servos": SERVOS, "--mocap": MOCAP}
"""Key of the vehicle file by option of `doorman fly`."""


def served_port(file: VehicleFile, key: str, given: int | None, usual: int) -> int:
    """UDP port on loopback that an emulator sends to."""
    connection = file.values.get(key)
    if given is not None or connection is None:
        return usual if given is None else given
    return 0 if connection == NO_CAMERAS else _loopback_port(connection) or usual


def served_device(file: VehicleFile) -> Path | None:
    """Where the vehicle file has the servos, if a link to a pseudo-terminal can be made there."""
    device = file.values.get(SERVOS)
    return None if device is None or Path(device).is_relative_to("/dev") else Path(device)


def other_links(file: VehicleFile, links: Mapping[str, str]) -> list[str]:
    """Options of `doorman fly` for the links that are elsewhere than the vehicle file says."""
    options: list[str] = []
    for option, link in links.items():
        named = file.values.get(OPTIONS[option])
        same = named == link or (named is not None and f"udp:{_loopback_port(named)}" == link)
        options += [] if same else [option, link]
    without = "--mocap" not in links and file.values.get(MOCAP) not in (None, NO_CAMERAS)
    return [*options, "--mocap", NO_CAMERAS] if without else options


def _loopback_port(connection: str) -> int | None:
    """Port of a link that listens on loopback; None of any other, such as of cameras with a protocol of their own."""
    try:
        endpoint = parse_connection(connection)
    except BackendError:
        return None
    listens = endpoint.transport is Transport.UDP_LISTEN and endpoint.host in ("127.0.0.1", "0.0.0.0")
    return endpoint.port if listens else None
