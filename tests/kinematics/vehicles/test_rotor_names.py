"""Rotors are known by the last part of their joints' names, whatever a namespace or a simulator has put before it."""

from __future__ import annotations

import importlib.metadata
import re
from pathlib import Path

import numpy as np
import pytest

from doorman.exceptions import UrdfError
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.kinematics.vehicles.rotors import is_rotor
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.resources import urdf_directory
from doorman.scenario import VehicleSection

TILTED = urdf_directory() / "tilted_hexarotor.urdf"
FORMS = ["uav1/{}", "/uav1/{}", "iris__{}_joint", "x500::{}", "a.b.{}", "uav-1/frame_2/{}_link", "uav1__body/{}"]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_prefixed_rotors_are_the_same_rotors(form: str, kind: str, tmp_path: Path) -> None:
    text = re.sub(r"\brotor_(\d)", lambda found: form.format(found[0]), TILTED.read_text(encoding="utf-8"))
    text = re.sub(rf'({re.escape(form.format("rotor_")[:4])}[^"]*" type=")fixed', rf"\1{kind}", text)
    path = tmp_path / "vehicle.urdf"
    path.write_text(text, encoding="utf-8")
    vehicle, shipped = Vehicle(path), Vehicle(TILTED)
    assert vehicle.joint_names == shipped.joint_names and vehicle.standing_joints == ()
    assert vehicle.radius == shipped.radius
    layout, expected = rotor_layout(vehicle, 0.016), rotor_layout(shipped, 0.016)
    np.testing.assert_allclose(layout.wrench, expected.wrench, atol=1e-12)
    np.testing.assert_allclose(layout.max_thrusts, expected.max_thrusts)
    assert layout.fully_actuated


@pytest.mark.parametrize("name", ["rotor", "rotor_1", "Rotor1", "rotor/1", "rotor__2", "ROTOR_0_JOINT", "rotor_left"])
def test_names_of_rotors(name: str) -> None:
    assert is_rotor(name) and all(is_rotor(form.format(name)) for form in FORMS)


@pytest.mark.parametrize(
    "name", ["motor_1", "rotor_1/imu", "rotor_1__guard", "rotors/arm_1", "tail", "1", "", "rot/or_1"]
)
def test_names_of_others(name: str) -> None:
    assert not is_rotor(name)


def iris(folder: Path, effort: float) -> Path:
    """The Iris of example-robot-data with a tip, and a thrust for its rotors."""
    files = importlib.metadata.distribution("example-robot-data").files or []
    text = Path(str(next(file for file in files if file.name == "iris.urdf").locate())).read_text(encoding="utf-8")
    text = text.replace('effort="0.0" lower="-1e+16" upper="1e+16"', f'effort="{effort}" lower="-3" upper="3"')
    tip = '<link name="tip"/><joint name="mount" type="fixed"><parent link="iris__base_link"/><child link="tip"/></joint></robot>'
    path = folder / "iris.urdf"
    path.write_text(text.replace("</robot>", tip), encoding="utf-8")
    return path


def test_the_rotors_of_iris_are_read_where_they_are(tmp_path: Path) -> None:
    vehicle = Vehicle(iris(tmp_path, 9.0), VehicleSection(base_link="iris__base_link", radius=0.4))
    places = [rotor.position[:2].tolist() for rotor in vehicle.rotors]
    assert places == [[0.13, -0.22], [-0.13, 0.2], [0.13, 0.22], [-0.13, -0.2]]
    assert vehicle.max_thrust == pytest.approx(36.0)


def test_rotors_without_thrust_are_an_error_unless_others_are_assumed(tmp_path: Path) -> None:
    path, names = iris(tmp_path, 0.0), {"base_link": "iris__base_link", "radius": 0.4}
    with pytest.raises(UrdfError) as caught:
        Vehicle(path, VehicleSection(**names))
    assert caught.value.field == "joint iris__rotor_0_joint/limit@effort"
    assumed = Vehicle(path, VehicleSection(**names, rotors={"assume": True}))
    assert assumed.rotors == () and rotor_layout(assumed, 0.016).count == 6
