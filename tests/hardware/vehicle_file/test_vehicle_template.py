"""The template: a file that can be read, complete, with the docstrings of what takes the values."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE

from doorman.cli.vehicles.vehicle_file import new
from doorman.hardware.dynamixel import ServoConfig
from doorman.hardware.mocap import MocapConfig
from doorman.hardware.pixhawk import PixhawkConfig
from doorman.hardware.vehicle import VehicleLinks
from doorman.hardware.vehicle.config import GIVEN
from doorman.hardware.vehicle_file import VehicleFile, vehicle_template
from doorman.hardware.vehicle_file.template import TABLES
from doorman.model import Model
from doorman.scenario import Scenario

JOINTS = ("eta_1", "eta_2", "eta_3", "eta_4")


@pytest.fixture(scope="module")
def whole() -> str:
    return vehicle_template("my.toml", "hexarotor_arm", JOINTS, every_key=True)


def uncommented(text: str) -> str:
    """With every key that has a default set to it."""
    return re.sub(r"^# (\[[\w.]+\]|\w+ = .*)$", r"\1", text, flags=re.MULTILINE)


def test_the_template_can_be_read_and_flown_with(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(vehicle_template("my.toml", "hexarotor_arm", JOINTS), encoding="utf-8")
    file = VehicleFile.load(path)
    config = file.links(Model(file.scenario("paper")))
    assert (config.servos.ids, config.servos.zeros) == ((1, 2, 3, 4, 5), (2048,) * 5)
    assert config.mocap is not None and config.mocap.object_name == "vehicle"
    assert len(path.read_text(encoding="utf-8").splitlines()) < 60


def test_every_default_in_it_is_one_that_changes_nothing(whole, tmp_path):
    text = uncommented(whole.replace("# [pixhawk.thrust_curve]", "#").replace("# shape", "#").replace("# voltage_exponent", "#")
                       .replace("# min_thrust = 0.02", "#").replace("# max_thrust = 1.0", "#"))  # fmt: skip
    path = tmp_path / "my.toml"
    path.write_text(text, encoding="utf-8")
    (tmp_path / "short.toml").write_text(vehicle_template("", "hexarotor_arm", JOINTS), encoding="utf-8")
    file, short = VehicleFile.load(path), VehicleFile.load(tmp_path / "short.toml")
    assert len(file.values) > 3 * len(short.values)
    scenario = file.scenario("paper")
    assert scenario == Scenario.load("paper")
    assert repr(file.links(Model(scenario))) == repr(short.links(Model(scenario)))


def test_every_key_stands_in_it(whole):
    tables = {"pixhawk": PixhawkConfig, "servos": ServoConfig, "mocap": MocapConfig}
    for name, config in tables.items():
        part = whole.split(f"\n[{name}]\n")[1].split("\n[")[0]
        for field in dataclasses.fields(config):
            if field.init and f"{name}.{field.name}" not in GIVEN and not dataclasses.is_dataclass(field.default):
                nested = field.name == "thrust_curve"
                assert nested or re.search(rf"^(# )?{field.name}( =|:)", part, re.MULTILINE), f"{name}.{field.name}"
    for section in TABLES.model_fields:
        assert re.search(rf"^(# )?(\[{section}\]|{section} =)", whole, re.MULTILINE), section
    assert "# [pixhawk.thrust_curve]" in whole


def test_names_and_joints_are_those_of_the_urdf():
    text = vehicle_template("a.toml", "../my.urdf", ("shoulder", "elbow"), {"base_link": "body", "tip": "finger"})
    tables = tomllib.loads(text)
    assert tables["vehicle"] == {"urdf": "../my.urdf", "base_link": "body", "tip": "finger"}
    assert tables["servos"]["ids"] == [1, 2, 3] and "shoulder, elbow, gripper" in text


@pytest.fixture
def stick(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> VehicleFile:
    """The shipped vehicle with its arm fixed, and the vehicle file that `doorman vehicle new` writes for it."""
    monkeypatch.chdir(tmp_path)
    text = VEHICLE.read_text()
    for joint in range(1, 5):
        text = text.replace(f'<joint name="eta_{joint}" type="revolute">', f'<joint name="eta_{joint}" type="fixed">')
    Path("stick.urdf").write_text(text)
    new(Path("stick.toml"), "stick.urdf")
    return VehicleFile.load("./stick.toml")


def test_a_new_file_of_a_stick_has_no_servos_and_flies(stick: VehicleFile) -> None:
    assert stick.path is not None and "[servos]" not in stick.path.read_text()
    model = Model(stick.scenario("push"))
    config = stick.links(model)
    assert (model.n_arm, config.n_arm, config.gripper) == (0, 0, False)
    links = VehicleLinks(config)
    links.move_arm(np.zeros(0), closed=False)
    links.let_go()
    sample = links.servos.read()
    assert sample.fresh and not sample.fault and sample.angles.shape == (0,)
