"""The rig with a vehicle file: servos, object and autopilot are mounted as the file says, at the links that it names."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import run
from flight_rig import free_port

from doorman.cli.vehicles.served_links import other_links, served_device, served_port
from doorman.hardware.dynamixel import ServoBus
from doorman.hardware.mocap import MocapReceiver
from doorman.hardware.scheduling import real_time
from doorman.hardware.vehicle_file import VehicleFile
from doorman.hardware.vehicle_file.file import MOCAP, PIXHAWK
from doorman.model import Model
from doorman.rig import Rig, RigSetup

MOUNTED = """
[pixhawk]
connection = "udp:{pixhawk}"
vehicle_system = 7
[servos]
port = "{folder}/arm"
ids = [21, 22, 23, 24, 30]
directions = [-1, 1, -1, 1, 1]
zero_positions = [1000, 2100, 3000, 2048, 1500]
homing_offsets = [0, 10, -20, 0, 0]
baud_rate = 57600
[mocap]
connection = "udp:{mocap}"
object_name = "hexa"
rate = 120.0
object_position = [0.05, -0.02, 0.1]
object_attitude = [0.0, 0.02, 0.5]
origin_position = [3.0, -1.0, 0.2]
origin_attitude = [0.0, 0.0, -0.8]
"""


def test_a_vehicle_that_is_mounted_otherwise_is_seen_as_it_is(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(MOUNTED.format(folder=tmp_path, pixhawk=free_port(), mocap=free_port()))
    file = VehicleFile.load(path)
    model = Model(file.scenario("paper"))
    config = file.links(model)
    setup = RigSetup(
        pixhawk_port=served_port(file, PIXHAWK, None, 14540), mocap_port=served_port(file, MOCAP, None, 51001),
        folder=tmp_path, vehicle=config, servos=served_device(file),
    )  # fmt: skip
    with real_time(), Rig(model, setup) as rig:
        with MocapReceiver(config.mocap) as cameras:
            pose = cameras.wait(cameras.read(), 2.0)
        truth = rig.plant.snapshot.truth
        np.testing.assert_allclose(pose.position, truth.position, atol=2e-3)
        np.testing.assert_allclose(pose.attitude, truth.attitude, atol=5e-3)
        with ServoBus(config.servos) as bus:
            angles = bus.wait(bus.read(), 2.0).angles
        np.testing.assert_allclose(angles[:4], rig.plant.snapshot.truth.arm_angles, atol=2e-3)
        result = run("fly", "paper", "--vehicle", str(path), "--dry-run", "--json")
        assert result.exit_code == 0, result.output
        found = {one["name"]: one for one in json.loads(result.stdout)["checklist"]}
        assert "120" in found["mocap"]["found"] and found["autopilot"]["verdict"] == "ok"


@pytest.mark.parametrize(
    ("link", "port"),
    [("udp:51009", 51009), ("udp:0.0.0.0:51009", 51009), ("udp:192.168.1.5:51009", 51001), ("optitrack:10.0.0.1", 51001),
     ("none", 0)],
)  # fmt: skip
def test_the_rig_serves_what_listens_on_loopback(link, port):
    file = VehicleFile(values={MOCAP: link})
    assert served_port(file, MOCAP, None, 51001) == port
    assert served_port(file, MOCAP, 7, 51001) == 7, "the command line wins"


@pytest.mark.parametrize(
    ("pixhawk", "servos", "mocap", "without"),
    [
        ("udp:14540", "arm", "udp:51001", []),
        ("udp:127.0.0.1:14540", "arm", "udp:0.0.0.0:51001", []),
        ("serial:/dev/pixhawk", "/dev/servos", "vicon:10.0.0.1",
         ["--pixhawk", "udp:14540", "--servos", "arm", "--mocap", "udp:51001"]),
        ("udp:14541", "arm", "udp:51001", ["--pixhawk", "udp:14540"]),
    ],
)  # fmt: skip
def test_links_that_are_elsewhere_on_the_rig_are_options(pixhawk, servos, mocap, without):
    file = VehicleFile(values={"pixhawk.connection": pixhawk, "servos.port": servos, "mocap.connection": mocap})
    links = {"--pixhawk": "udp:14540", "--servos": "arm", "--mocap": "udp:51001"}
    assert other_links(file, links) == without
    del links["--mocap"]
    assert other_links(file, links)[-2:] == ["--mocap", "none"], "cameras that the rig does not have"


def test_a_file_in_place_of_the_servos_link_is_left_alone(tmp_path):
    (tmp_path / "notes").write_text("mine")
    path = tmp_path / "my.toml"
    path.write_text(f'[servos]\nport = "{tmp_path}/notes"\n')
    result = run("rig", "paper", "--vehicle", str(path))
    assert result.exit_code == 2 and "servos.port" in result.stderr and "notes" in result.stderr
    assert (tmp_path / "notes").read_text() == "mine"
