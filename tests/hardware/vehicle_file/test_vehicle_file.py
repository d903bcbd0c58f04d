"""A vehicle file over a task and into the links, and what a wrong one says."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from command_line import run

from doorman.exceptions import DoormanError, ScenarioError
from doorman.hardware.computer.doctor import Host
from doorman.hardware.pixhawk import ThrustCurve
from doorman.hardware.vehicle_file import VehicleFile
from doorman.hardware.vehicle_file.file import devices
from doorman.model import Model
from doorman.resources import shipped, urdf_directory, vehicle_directory
from doorman.scenario import Scenario

LINKS = '[pixhawk]\nconnection = "udp:14600"\n[servos]\nport = "/dev/arm"\n'


@pytest.fixture(scope="module")
def pushing() -> Model:
    return Model(Scenario.load("push"))


@pytest.fixture
def written(tmp_path):
    def write(text: str) -> VehicleFile:
        (tmp_path / "my.toml").write_text(text, encoding="utf-8")
        return VehicleFile.load(tmp_path / "my.toml")

    return write


# ---------------------------------------------------------------- the task


def test_the_vehicle_takes_the_place_of_the_task_s_and_gains_win_over_it(written, tmp_path):
    urdf = (urdf_directory() / "hexarotor_arm.urdf").read_text(encoding="utf-8")
    (tmp_path / "mine.urdf").write_text(urdf)
    (tmp_path / "task.toml").write_text(
        "[vehicle]\nradius = 0.33\nmax_thrust = 50\n[control]\nmax_tilt = 0.2\nobserver_rate = 3.0\n[contact]\nheight = 0.9\n"
    )
    file = written('[vehicle]\nurdf = "mine.urdf"\nmax_thrust = 70\n[control]\nmax_tilt = 0.3\n[safety]\nforce = 9\n')
    scenario = file.scenario(tmp_path / "task.toml", {"vehicle.attitude_lag": 0.08})
    assert scenario.vehicle_urdf == (tmp_path / "mine.urdf").resolve(), "relative to the vehicle file"
    assert (scenario.vehicle.radius, scenario.vehicle.max_thrust) == (None, 70.0), (
        "nothing is left of the task's vehicle"
    )
    assert scenario.vehicle.attitude_lag == 0.08, "overrides win"
    assert (scenario.control.max_tilt, scenario.control.observer_rate) == (0.3, 3.0)
    assert (scenario.safety.force, scenario.contact.height) == (9.0, 0.9)
    saved = Scenario.load(scenario.save(tmp_path / "elsewhere" / "saved.toml"))
    assert saved == scenario


def test_a_file_of_links_alone_leaves_the_task_s_vehicle(written, tmp_path):
    (tmp_path / "task.toml").write_text("[vehicle]\nradius = 0.33\n")
    assert written(LINKS).scenario(tmp_path / "task.toml").vehicle.radius == 0.33
    learned = written("[vehicle]\nattitude_lag = 0.08\n").scenario(tmp_path / "task.toml").vehicle
    assert (learned.radius, learned.attitude_lag) == (0.33, 0.08), "a table without a URDF changes only what it has"
    assert VehicleFile().scenario("push") == Scenario.load("push")


# ---------------------------------------------------------------- the links


def test_every_value_of_the_links_goes_where_it_belongs(written, pushing, tmp_path):
    file = written(
        f"""rate = 250.0
{LINKS}ids = [5, 6, 7, 8, 9]
directions = [1, -1, 1, 1, 1]
zero_positions = [2000, 2001, 2002, 2003, 2004]
homing_offsets = [0, 10, -20, 0, 30]
[pixhawk.local_frame]
origin = [1, 2, 0]
yaw = 0.5
[pixhawk.rates]
attitude = 50
[pixhawk.thrust_curve]
hover_thrust = 0.4
hover_force = 29.0
[mocap]
connection = "udp:51002"
object_name = "hexa"
object_position = [0.01, 0, 0.05]
"""
    )
    config = file.links(pushing)
    assert config.servos.port == "/dev/arm" and config.pixhawk.connection == "udp:14600" and config.rate == 250.0
    assert config.servos.ids == (5, 6, 7, 8), "a push leaves the gripper's servo alone"
    assert (config.servos.directions, config.servos.zero_positions) == ((1, -1, 1, 1), (2000, 2001, 2002, 2003))
    assert config.servos.homing_offsets == (0, 10, -20, 0)
    assert (config.pixhawk.local_frame.origin, config.pixhawk.local_frame.yaw) == ((1.0, 2.0, 0.0), 0.5)
    assert (config.pixhawk.rates.attitude, config.pixhawk.rates.heartbeat) == (50.0, 2.0)
    assert config.pixhawk.thrust_curve == ThrustCurve(0.4, 29.0)
    assert config.mocap is not None and config.pixhawk.mocap
    assert (config.mocap.connection, config.mocap.object_name) == ("udp:51002", "hexa")
    gripping = file.links(Model(Scenario()))
    assert gripping.servos.ids == (5, 6, 7, 8, 9) and gripping.servos.gripper
    assert gripping.servos.homing_offsets == (0, 10, -20, 0, 30)


def test_the_command_line_wins_over_the_file(written, pushing):
    file = written(
        f'{LINKS}baud_rate = 57600\n[pixhawk.rates]\nattitude = 50\nposition = 20\n[mocap]\nconnection = "udp:51002"\n'
    )
    config = file.links(
        pushing, {"pixhawk.rates": {"attitude": 60}, "servos.port": "/dev/other", "mocap.connection": "none"}
    )
    assert (config.pixhawk.rates.attitude, config.pixhawk.rates.position) == (60.0, 100.0)
    assert (config.servos.port, config.servos.baud_rate, config.mocap) == ("/dev/other", 57600, None)
    alone = VehicleFile().links(pushing, {"pixhawk.connection": "udp:1", "servos.port": "x"})
    assert (alone.pixhawk.connection, alone.servos.ids, alone.mocap) == ("udp:1", (1, 2, 3, 4), None)


def test_slow_cameras_need_a_longer_time_until_a_pose_is_stale(written, pushing):
    config = written(
        f"{LINKS}[mocap]\nconnection = 'udp:51001'\nrate = 25\nstale_after = 0.1\nvelocity_window = 0.1\n"
    ).links(pushing)
    assert config.mocap is not None and (config.mocap.rate, config.mocap.stale_after) == (25.0, 0.1)


def test_a_signing_key_is_relative_to_the_file(written, pushing, tmp_path, monkeypatch):
    file = written('[pixhawk]\nconnection = "udp:14600"\nsigning_key = "secret.key"\n[servos]\nport = "arm"\n')
    monkeypatch.chdir("/")
    assert file.links(pushing).pixhawk.signing_key == tmp_path / "secret.key"


@pytest.mark.parametrize("name", shipped(vehicle_directory(), ".toml"))
def test_shipped_files_fit_the_tasks_that_ship(name, pushing):
    file = VehicleFile.load(name)
    assert file.links(pushing).servos.n == 4
    assert file.links(Model(file.scenario("paper"))).servos.n == 5


# ---------------------------------------------------------------- errors


@pytest.mark.parametrize(
    ("text", "field", "words"),
    [
        ("[servos]\nidz = [1]", "servos.idz", "nearest is 'ids'"),
        ("[pixhawk]\nvehicel_system = 3", "pixhawk.vehicel_system", "nearest is 'vehicle_system'"),
        ("[pixhawk.rates]\natitude = 3", "pixhawk.rates.atitude", "nearest is 'attitude'"),
        ("[pixhawk.thrust_curve]\nhover_thrst = 0.4\nhover_force = 9", "pixhawk.thrust_curve.hover_thrst", "'hover_thrust'"),
        ("[pixhawk.thrust_curve]\nhover_thrust = 0.4", "pixhawk.thrust_curve.hover_force", "missing"),
        ("[vehicle]\nurdff = 'x'", "vehicle.urdff", "nearest is 'urdf'"),
        ("[vehicle]\nurdf = 'not_there.urdf'", "vehicle.urdf", "not_there.urdf"),
        ("[vehicle]\nattitude_lag = 0", "vehicle.attitude_lag", "greater than 0"),
        ("[contorl]\nmax_tilt = 1", "contorl", "nearest is 'control'"),
        ("[door]\nwidth = 0.9", "door", "allowed: rate"),
        ("[control]\nposition_gains = 1", "control.position_gains", "'position_gain'"),
        ("[servos]\nids = [1, 2.5]", "servos.ids.1", "an integer"),
        ("[servos]\nids = ['1']", "servos.ids.0", "an integer"),
        ("[servos]\nwrite_eeprom = 1", "servos.write_eeprom", "bool"),
        ("[mocap]\nobject_position = [0, 0, 'up']", "mocap.object_position.2", "a number"),
        ("[mocap]\nrate = nan", "mocap.rate", "finite"),
        ("[pixhawk]\nsetpoints = 'rates'", "pixhawk.setpoints", "'attitude' or 'position'"),
        ("[servos]\nlower_limits = [0]", "servos.lower_limits", "unknown key"),
        ("servos = 3", "servos", "a table"),
    ],
)  # fmt: skip
def test_a_key_that_cannot_be_is_named_with_file_and_what_is_allowed(text, field, words, written, tmp_path):
    with pytest.raises(ScenarioError) as caught:
        written(text)
    assert (caught.value.file, caught.value.field) == (str(tmp_path / "my.toml"), field)
    assert caught.value.allowed and words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("ids = [1, 2]", "servos.ids"),
        ("ids = [1, 2, 2, 3]", "servos.ids"),
        ("directions = [1, 2, 1, 1]", "servos.directions"),
        ("[pixhawk.thrust_curve]\nhover_thrust = 1.4\nhover_force = 29", "pixhawk.thrust_curve.hover_thrust"),
        ("[pixhawk.timeouts]\nlink = -1", "pixhawk.timeouts.link"),
        ("[mocap]\nobject_name = 'x'", "mocap.connection"),
        ("[mocap]\nconnection = 'pigeon:1'", "mocap.connection"),
        ("[mocap]\nconnection = 'udp:51001'\nobject_position = [0, 0]", "mocap.object_position"),
        ("[mocap]\nconnection = 'udp:51001'\nrate = 25", "mocap.rate"),
        ("[mocap]\nconnection = 'udp:51001'\nrate = 5\nstale_after = 0.5", "mocap.rate"),
    ],
)
def test_a_value_out_of_range_is_named_with_file_and_key(text, field, written, pushing, tmp_path):
    file = written(f"{LINKS}{text}")
    for ask in (file.links, file.links_anywhere):
        with pytest.raises(DoormanError) as caught:
            ask(pushing)
        assert (caught.value.file, caught.value.field) == (str(tmp_path / "my.toml"), field)
        assert caught.value.allowed


def test_the_file_is_not_blamed_for_the_command_line(written, pushing):
    for key, value in (("servos.baud_rate", 5), ("mocap.connection", "pigeon:1"), ("pixhawk.connection", "pigeon")):
        with pytest.raises(DoormanError) as caught:
            written(LINKS).links(pushing, {key: value})
        assert (caught.value.file, caught.value.field) == (None, key)


@pytest.mark.parametrize(
    ("text", "field"),
    [('[servos]\nport = "x"', "pixhawk.connection"), ('[pixhawk]\nconnection = "udp:1"', "servos.port")],
)
def test_a_link_that_nobody_names_is_an_error_only_where_it_is_opened(text, field, written, pushing):
    file = written(text)
    with pytest.raises(DoormanError) as caught:
        file.links(pushing)
    assert caught.value.field == field and "--" in caught.value.allowed
    file.links_anywhere(pushing)


def test_what_is_no_file_or_no_toml(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for source in ("rigg", "./rig.toml", 3, None):
        with pytest.raises(ScenarioError):
            VehicleFile.load(source)  # type: ignore[arg-type]
    Path("broken.toml").write_text("a = ")
    with pytest.raises(ScenarioError, match="not valid TOML"):
        VehicleFile.load("broken.toml")
    Path("rig.toml").write_text("")
    with pytest.raises(ScenarioError, match="two vehicle files"):
        VehicleFile.load("rig")
    assert VehicleFile.load(os.path.join(".", "rig.toml")).values == {}


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
