"""`doorman doctor --vehicle`: the devices that a vehicle file names."""

from __future__ import annotations

import json

from command_line import run

from doorman.hardware.computer.host import Host
from doorman.hardware.vehicle_file import VehicleFile
from doorman.hardware.vehicle_file.devices import devices


def test_devices_that_are_there_and_those_that_are_not(tmp_path):
    (tmp_path / "arm").touch()
    path = tmp_path / "my.toml"
    path.write_text(
        f'[pixhawk]\nconnection = "serial:/dev/no-such-pixhawk:57600"\nsigning_key = "key"\n[servos]\nport = "{tmp_path}/arm"\n'
    )
    rows = {row.name: row.complaint.value for row in devices(Host(), VehicleFile.load(path))}
    assert rows == {"pixhawk: /dev/no-such-pixhawk": "no", f"servos: {tmp_path}/arm": "ok", "signing key": "no"}
    ran = run("doctor", "--vehicle", str(path), "--json")
    assert {"pixhawk: /dev/no-such-pixhawk", "signing key"} <= {row["name"] for row in json.loads(ran.stdout)}
    assert ran.exit_code == 1


def test_a_link_by_network_has_no_device(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text('[pixhawk]\nconnection = "udp:14540"\n')
    assert devices(Host(), VehicleFile.load(path)) == []
