"""Vehicles whose URDF says what cannot be flown: powerless rotors, joints that cannot move or hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE, write_edited

from doorman.exceptions import UrdfError
from doorman.kinematics.vehicles.vehicle import Vehicle

END = "</robot>"
ROTOR = '<origin xyz="0.238157 0.137500 0" rpy="0 0 0"/>'
AXIS = '<axis xyz="0 0 1"/>\n    <limit effort="8.0"'
THRUST = '<limit effort="8.0" velocity="900"/>'
FIRST = '<limit lower="{}" upper="{}" effort="{}" velocity="3.1"/>'


def vehicle(tmp_path: Path, *edits: tuple[str, str]) -> Path:
    return write_edited(tmp_path / "vehicle.urdf", VEHICLE, *edits)


def refused(path: Path, field: str, words: str) -> UrdfError:
    with pytest.raises(UrdfError, match=words) as caught:
        Vehicle(path)
    assert caught.value.file == str(path) and caught.value.field == field
    assert caught.value.given is not None and caught.value.allowed
    return caught.value


def joint_limit(lower: float, upper: float, effort: float) -> tuple[str, str]:
    """An edit of the first joint's limits."""
    text = VEHICLE.read_text(encoding="utf-8")
    start = text.index("<limit", text.index('<joint name="eta_1"'))
    return text[start : text.index("/>", start) + 2], FIRST.format(lower, upper, effort)


@pytest.mark.parametrize(
    "edit", [(ROTOR, ROTOR.replace("0 0 0", "0.01 0 2.0")), (AXIS, AXIS.replace("0 0 1", "0 0 7"))]
)
def test_a_rotor_turns_as_its_axis_says_whatever_its_yaw(tmp_path, edit):
    assert [rotor.direction for rotor in Vehicle(vehicle(tmp_path, edit)).rotors] == [1, -1, 1, -1, 1, -1]


def test_a_rotor_that_hangs_upside_down_turns_the_other_way(tmp_path):
    turned = Vehicle(vehicle(tmp_path, (ROTOR, ROTOR.replace('rpy="0 0 0"', 'rpy="3.14159265 0 0"'))))
    assert [rotor.direction for rotor in turned.rotors] == [-1, -1, 1, -1, 1, -1]


@pytest.mark.parametrize("instead", [THRUST.replace("8.0", "0"), THRUST.replace("8.0", "-0.0"), ""])
def test_a_rotor_without_thrust_among_others_is_refused(tmp_path, instead):
    refused(vehicle(tmp_path, (THRUST, instead)), "joint rotor_1/limit@effort", "no thrust")


def test_rotors_that_all_have_none_are_refused(tmp_path):
    path = tmp_path / "vehicle.urdf"
    path.write_text(VEHICLE.read_text(encoding="utf-8").replace('effort="8.0"', 'effort="0"'), encoding="utf-8")
    refused(path, "joint rotor_1/limit@effort", "no thrust")


def test_a_rotor_on_the_arm_is_refused(tmp_path):
    text = VEHICLE.read_text(encoding="utf-8")
    start = text.index('<joint name="rotor_2"')
    part = text[start : text.index("</joint>", start)]
    path = vehicle(tmp_path, (part, part.replace('<parent link="base_link"/>', '<parent link="servo_2"/>')))
    refused(path, "joint rotor_2", "moves with the arm")


@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_rotors_may_turn(tmp_path, kind):
    path = vehicle(tmp_path, ('<joint name="rotor_1" type="fixed">', f'<joint name="rotor_1" type="{kind}">'))
    made = Vehicle(path)
    assert len(made.rotors) == 6 and made.standing_joints == ()


def test_a_joint_that_cannot_hold_is_refused(tmp_path):
    refused(vehicle(tmp_path, joint_limit(-3.0, 3.0, 0.0)), "joint eta_1/limit@effort", "cannot hold")


def test_a_joint_without_a_range_is_refused(tmp_path):
    refused(vehicle(tmp_path, joint_limit(0.3, 0.3, 3.1)), "joint eta_1/limit@upper", "no range")


def test_what_follows_the_arm_is_refused_and_what_only_could_move_stands(tmp_path):
    finger = (
        '<link name="pad"/><joint name="finger" type="prismatic"><parent link="tip"/><child link="pad"/><axis xyz="0 1 0"/>'
        '<limit lower="0" upper="0.02" effort="5" velocity="1"/>{}</joint>'
    )
    refused(
        vehicle(tmp_path, (END, finger.format('<mimic joint="eta_4"/>') + END)), "joint finger/mimic", "follows the arm"
    )
    made = Vehicle(vehicle(tmp_path, (END, finger.format("") + END)))
    assert made.standing_joints == ("finger",)
    np.testing.assert_array_equal(made.tip_position(np.zeros(4)), Vehicle(VEHICLE).tip_position(np.zeros(4)))


def test_a_negative_mass_of_any_link_is_refused(tmp_path):
    weight = '<inertial><mass value="-0.01"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    path = vehicle(tmp_path, ('<link name="rotor_3">', '<link name="rotor_3">' + weight))
    refused(path, "link rotor_3/inertial/mass", "negative")
