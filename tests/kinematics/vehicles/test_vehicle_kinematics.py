"""Vehicle: positions and Jacobians of the arm, and what else the URDF says."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE, robot_data_vehicle, write_arm, write_arm_of, write_edited

from doorman.exceptions import DimensionError
from doorman.kinematics.vehicles.vehicle import Vehicle


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return Vehicle(VEHICLE)


@pytest.mark.parametrize(
    ("angles", "servo_3", "servo_4", "tip"),
    [
        ([0, 0, 0, 0], (0.024, 0, -0.218), (0.148, 0, -0.218), (0.398, 0, -0.218)),
        ([0, math.pi / 2, -math.pi / 2, 0], (0.128, 0, -0.066), (0.252, 0, -0.066), (0.502, 0, -0.066)),
        ([math.pi / 2, 0, 0, 0], (0, -0.024, -0.218), (0, -0.148, -0.218), (0, -0.398, -0.218)),
        ([0, 0, 0, math.pi / 2], (0.024, 0, -0.218), (0.148, 0, -0.218), (0.148, 0, 0.032)),
    ],
    ids=["zero", "goal of the paper", "turned right", "rod upright"],
)
def test_positions_by_hand(vehicle: Vehicle, angles: list[float], servo_3: tuple, servo_4: tuple, tip: tuple) -> None:
    np.testing.assert_allclose(vehicle.point_positions(angles), [servo_3, servo_4, tip], atol=1e-15)
    np.testing.assert_allclose(vehicle.tip_position(angles), tip, atol=1e-15)


def test_numbers_come_from_the_urdf(tmp_path: Path) -> None:
    path = write_edited(
        tmp_path / "vehicle.urdf",
        write_arm(tmp_path / "arm.urdf", rod=0.31),
        ('<mass value="3.0" />', '<mass value="2.5" />'),
        ('radius="0.40"', 'radius="0.37"'),
        ('effort="8.0"', 'effort="6.5"'),
        ('ixx="0.045"', 'ixx="0.031"'),
    )
    changed = Vehicle(path)
    assert changed.mass == pytest.approx(2.5)
    assert changed.radius == pytest.approx(0.37)
    assert changed.max_thrust == pytest.approx(46.5)
    assert changed.inertia(np.zeros(4))[0, 0] == pytest.approx(0.031)
    np.testing.assert_allclose(changed.tip_position(np.zeros(4)), [0.458, 0, -0.218], atol=1e-15)


def test_a_vehicle_without_rotors_lifts_twice_its_weight(tmp_path: Path) -> None:
    text = VEHICLE.read_text(encoding="utf-8").replace('<limit effort="8.0" velocity="900"/>', "")
    (tmp_path / "v.urdf").write_text(text, encoding="utf-8")
    vehicle = Vehicle(tmp_path / "v.urdf")
    assert vehicle.rotors == ()
    assert vehicle.max_thrust == pytest.approx(2.0 * 3.0 * 9.81)


DISC = '<origin xyz="0 0 0.0002" rpy="0 0 0"/>\n      <geometry><cylinder radius="0.40" length="0.0004"/></geometry>'


@pytest.mark.parametrize(
    ("place", "shape", "least", "most"),
    [
        ('xyz="0.1 0 0.3"', '<sphere radius="0.2"/>', 0.3, 0.3),
        ('xyz="0 0.1 0"', '<box size="0.6 0.2 0.1"/>', math.hypot(0.3, 0.2), math.hypot(0.3, 0.2)),
        ('rpy="0 0 0.7853981633974483"', '<box size="0.6 0.6 0.1"/>', 0.3 * math.sqrt(2), 0.3 * math.sqrt(2)),
        ('rpy="1.5707963267948966 0 0"', '<cylinder radius="0.1" length="0.8"/>', math.hypot(0.4, 0.1), 0.5),
    ],
    ids=["sphere", "box", "box turned", "lying cylinder"],
)
def test_radius_holds_every_shape_of_the_base(
    place: str, shape: str, least: float, most: float, tmp_path: Path
) -> None:
    other = f"<origin {place}/><geometry>{shape}</geometry>"
    radius = Vehicle(write_edited(tmp_path / "v.urdf", VEHICLE, (DISC, other))).radius
    assert least - 1e-9 <= radius <= most + 1e-9


def test_radius_holds_meshes_and_what_is_fixed_to_the_base(tmp_path: Path) -> None:
    corners = ((0.0, 0.0, 0.0), (0.3, 0.4, 0.1), (-0.1, 0.2, 0.0))
    mesh = "solid a\nfacet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners)
    (tmp_path / "plate.stl").write_text(mesh + "endloop\nendfacet\nendsolid a\n", encoding="utf-8")
    shape = '<collision><geometry><mesh filename="package://plate.stl"/></geometry></collision>'
    path = write_edited(tmp_path / "v.urdf", VEHICLE, ('<link name="rotor_1">', f'<link name="rotor_1">{shape}'))
    assert Vehicle(path).radius == pytest.approx(math.hypot(0.238157 + 0.3, 0.1375 + 0.4), abs=1e-6)


def test_points_beyond_servo_4_may_be_the_joints_themselves(tmp_path: Path) -> None:
    text = write_arm_of(tmp_path / "arm.urdf", 6).read_text(encoding="utf-8")
    renamed = tmp_path / "renamed.urdf"
    renamed.write_text(text.replace('"servo_5"', '"wrist"').replace('"servo_6"', '"hand"'), encoding="utf-8")
    vehicle = Vehicle(renamed)
    assert vehicle.point_names == ("servo_3", "servo_4", "eta_5", "eta_6", "tip")
    angles = np.linspace(-0.5, 0.5, 6)
    expected = Vehicle(tmp_path / "arm.urdf").point_positions(angles)
    np.testing.assert_allclose(vehicle.point_positions(angles), expected, atol=1e-15)


@pytest.mark.parametrize(
    ("name", "n_arm", "points", "mass"),
    [("borinot_flying_arm_2", 2, 1, 2.910538), ("hextilt_flying_arm_5", 5, 4, 1.686413)],
)
def test_flying_arms_of_example_robot_data(name: str, n_arm: int, points: int, mass: float) -> None:
    vehicle = Vehicle(*robot_data_vehicle(name))
    assert vehicle.n_arm == n_arm
    assert len(vehicle.point_names) == points
    assert vehicle.mass == pytest.approx(mass, abs=1e-6)
    assert 0.15 < vehicle.radius < 0.6
    assert vehicle.tip_position(np.zeros(n_arm))[2] < -0.3
    angles = np.random.default_rng(1).uniform(-1.5, 1.5, n_arm)
    np.testing.assert_array_equal(vehicle.tip_jacobian(angles), vehicle.point_jacobians(angles)[-1])


def test_links_are_placed_in_the_body(vehicle: Vehicle) -> None:
    placements = vehicle.link_placements([0.3, 0.2, -0.5, 0.4])
    np.testing.assert_array_equal(placements["base_link"], np.eye(4))
    np.testing.assert_allclose(placements["tip"][:3, 3], vehicle.tip_position([0.3, 0.2, -0.5, 0.4]), atol=1e-15)
    assert {"servo_1", "servo_4", "rotor_6", "tip"} <= placements.keys()


@pytest.mark.parametrize("angles", [[0, 0, 0], [0, 0, math.nan, 0], [[0, 0, 0, 0]], "four"])
@pytest.mark.parametrize("method", ["point_positions", "point_jacobians", "tip_position", "inertia", "link_placements"])
def test_what_is_not_a_posture_is_an_error(vehicle: Vehicle, method: str, angles: object) -> None:
    with pytest.raises(DimensionError, match="arm_angles"):
        getattr(vehicle, method)(angles)
