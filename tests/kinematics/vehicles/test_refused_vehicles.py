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
SHIPPED = VEHICLE.read_text(encoding="utf-8")
WEIGHT = '<inertial><mass value="-0.01"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
FINGER = (
    '<link name="pad"/><joint name="finger" type="prismatic"><parent link="tip"/><child link="pad"/><axis xyz="0 1 0"/>'
    '<limit lower="0" upper="0.02" effort="5" velocity="1"/>{}</joint></robot>'
)


def part(begin: str, end: str, name: str) -> str:
    """Text of the shipped URDF from a beginning behind the name of a joint up to an end."""
    start = SHIPPED.index(begin, SHIPPED.index(f'<joint name="{name}"'))
    return SHIPPED[start : SHIPPED.index(end, start) + len(end)]


def limit(lower: float, upper: float, effort: float) -> tuple[str, str]:
    return part("<limit", "/>", "eta_1"), FIRST.format(lower, upper, effort)


SECOND = part("<joint", "</joint>", "rotor_2")
REFUSED = [
    ((THRUST, THRUST.replace("8.0", "0")), "joint rotor_1/limit@effort", "no thrust"),
    ((THRUST, THRUST.replace("8.0", "-0.0")), "joint rotor_1/limit@effort", "no thrust"),
    ((THRUST, ""), "joint rotor_1/limit@effort", "no thrust"),
    ((SHIPPED, SHIPPED.replace('effort="8.0"', 'effort="0"')), "joint rotor_1/limit@effort", "no thrust"),
    ((SECOND, SECOND.replace("base_link", "servo_2")), "joint rotor_2", "moves with the arm"),
    (limit(-3.0, 3.0, 0.0), "joint eta_1/limit@effort", "cannot hold"),
    (limit(0.3, 0.3, 3.1), "joint eta_1/limit@upper", "no range"),
    ((END, FINGER.format('<mimic joint="eta_4"/>')), "joint finger/mimic", "follows the arm"),
    (('<link name="rotor_3">', '<link name="rotor_3">' + WEIGHT),
     "/robot[hexarotor_arm]/link[rotor_3]/inertial/mass@value", "negative"),
]  # fmt: skip


def vehicle(tmp_path: Path, edit: tuple[str, str]) -> Path:
    return write_edited(tmp_path / "vehicle.urdf", VEHICLE, edit)


@pytest.mark.parametrize(("edit", "field", "words"), REFUSED, ids=[row[2] for row in REFUSED])
def test_what_cannot_be_flown_is_refused(tmp_path, edit, field, words):
    path = vehicle(tmp_path, edit)
    with pytest.raises(UrdfError, match=words) as caught:
        Vehicle(path)
    assert caught.value.file == str(path) and caught.value.field == field
    assert caught.value.given is not None and caught.value.allowed


@pytest.mark.parametrize(
    "edit", [(ROTOR, ROTOR.replace("0 0 0", "0.01 0 2.0")), (AXIS, AXIS.replace("0 0 1", "0 0 7"))]
)
def test_a_rotor_turns_as_its_axis_says_whatever_its_yaw(tmp_path, edit):
    assert [rotor.direction for rotor in Vehicle(vehicle(tmp_path, edit)).rotors] == [1, -1, 1, -1, 1, -1]


def test_a_rotor_that_hangs_upside_down_turns_the_other_way(tmp_path):
    turned = Vehicle(vehicle(tmp_path, (ROTOR, ROTOR.replace('rpy="0 0 0"', 'rpy="3.14159265 0 0"'))))
    assert [rotor.direction for rotor in turned.rotors] == [-1, -1, 1, -1, 1, -1]


@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_rotors_may_turn(tmp_path, kind):
    path = vehicle(tmp_path, ('<joint name="rotor_1" type="fixed">', f'<joint name="rotor_1" type="{kind}">'))
    made = Vehicle(path)
    assert len(made.rotors) == 6 and made.standing_joints == ()


def test_what_only_could_move_stands(tmp_path):
    made = Vehicle(vehicle(tmp_path, (END, FINGER.format(""))))
    assert made.standing_joints == ("finger",)
    np.testing.assert_array_equal(made.tip_position(np.zeros(4)), Vehicle(VEHICLE).tip_position(np.zeros(4)))
