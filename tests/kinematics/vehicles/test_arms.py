"""Arms of no joints to seven, that turn, turn for ever or slide, below or above the rotors, under any names."""

from __future__ import annotations

import re
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from finite_differences import central_difference
from urdf_variants import VEHICLE, robot_data_vehicle, write_arm_of, write_edited

from doorman.exceptions import UrdfError
from doorman.kinematics.symbols import arm_points
from doorman.kinematics.vehicles.arms.arm import ArmParameters, arm_kinematics, point_derivative
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.scenario import Scenario, VehicleSection
from doorman.simulation.simulator import Simulator

KINDS = [
    {0: "prismatic"},
    {0: "continuous", 1: "prismatic"},
    {1: "prismatic", 2: "continuous"},
    {0: "prismatic", 1: "continuous", 2: "prismatic", 3: "prismatic"},
    {2: "prismatic", 5: "prismatic", 6: "continuous"},
    *({joints - 1: "revolute"} for joints in range(1, 8)),
]
OTHERS = ["borinot_flying_arm_2", "hextilt_flying_arm_5"]


@pytest.fixture(params=["shipped", "stick", "long axes", *OTHERS, *range(len(KINDS))])
def vehicle(request: pytest.FixtureRequest, tmp_path: Path) -> Vehicle:
    if request.param == "stick":
        return Vehicle(write_arm_of(tmp_path / "stick.urdf", 0))
    if request.param in OTHERS:
        return Vehicle(*robot_data_vehicle(request.param))
    if request.param == "shipped":
        return Vehicle(VEHICLE)
    if request.param == "long axes":
        return Vehicle(write_edited(tmp_path / "v.urdf", VEHICLE, ('<axis xyz="0 -1 0"/>', '<axis xyz="0 -2 1"/>')))
    kinds = KINDS[request.param]
    joints = max(kinds) + 1
    return Vehicle(write_arm_of(tmp_path / "arm.urdf", joints, odd_axes_seed=20 + request.param, kinds=kinds))


def test_kernel_symbols_and_pinocchio_agree_on_every_kind(vehicle: Vehicle, rng: np.random.Generator) -> None:
    n, kernel = vehicle.n_arm, ArmParameters.of(vehicle.arm)
    np.testing.assert_allclose(np.linalg.norm(vehicle.arm.axes, axis=1), 1.0, atol=1e-15)
    pattern, numbers = ArmPattern.of(vehicle.arm)
    angles = ca.SX.sym("angles", n)
    symbols = ca.SX.sym("numbers", len(numbers))
    points = ca.Function("points", [symbols, angles], [ca.horzcat(*arm_points(pattern, symbols, angles))])
    for posture in rng.uniform(-2.5, 2.5, (6, n)):
        expected = vehicle.point_positions(posture)
        arm_kinematics(kernel, posture)
        np.testing.assert_allclose(kernel.points, expected, atol=4e-15)
        np.testing.assert_allclose(np.array(points(numbers, posture)).T, expected, atol=4e-15)
        jacobians = vehicle.point_jacobians(posture)
        assert jacobians.shape == (len(vehicle.point_names), 3, n)
        if n:
            np.testing.assert_allclose(jacobians, central_difference(vehicle.point_positions, posture), atol=1e-9)
        for point, jacobian in enumerate(jacobians):
            mine = np.array([point_derivative(kernel, point, joint) for joint in range(n)]).reshape(n, 3).T
            np.testing.assert_allclose(mine, jacobian, atol=4e-15)


def test_a_continuous_joint_has_one_angle_and_no_limits(tmp_path: Path) -> None:
    turning = Vehicle(write_arm_of(tmp_path / "arm.urdf", 3, kinds={0: "continuous"}))
    np.testing.assert_array_equal(turning.lower_limits, [-np.inf, -1.8, -1.8])
    np.testing.assert_array_equal(turning.upper_limits, [np.inf, 1.8, 1.8])
    np.testing.assert_array_equal(turning.rate_limits, [3.1] * 3)
    whole_turn = turning.tip_position([2 * np.pi + 0.3, 0.2, 0.1])
    np.testing.assert_allclose(whole_turn, turning.tip_position([0.3, 0.2, 0.1]), atol=1e-12)


def test_a_continuous_joint_of_unknown_speed_is_refused(tmp_path: Path) -> None:
    text = write_arm_of(tmp_path / "arm.urdf", 2, kinds={0: "continuous"}).read_text(encoding="utf-8")
    path = tmp_path / "bare.urdf"
    path.write_text(re.sub(r'(<joint name="eta_1".*?)<limit[^>]*/>', r"\1", text, flags=re.DOTALL), encoding="utf-8")
    with pytest.raises(UrdfError, match="cannot move") as caught:
        Vehicle(path)
    assert caught.value.field == "joint eta_1/limit@velocity"


def test_more_joints_than_seven_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match="too many joints") as caught:
        Vehicle(write_arm_of(tmp_path / "arm.urdf", 8))
    assert caught.value.given == 8


def test_an_arm_whose_joints_are_not_on_the_way_to_the_tip_stands(tmp_path: Path) -> None:
    stick = '<link name="stick"/><joint name="mount" type="fixed"><parent link="base_link"/><child link="stick"/></joint></robot>'
    vehicle = Vehicle(write_edited(tmp_path / "v.urdf", VEHICLE, ("</robot>", stick)), VehicleSection(tip="stick"))
    assert vehicle.n_arm == 0 and vehicle.standing_joints == tuple(f"eta_{k}" for k in range(1, 5))


def test_root_and_frames_have_any_names(tmp_path: Path) -> None:
    """A world above the vehicle, on which it floats, and no name of the shipped vehicle."""
    text = VEHICLE.read_text(encoding="utf-8")
    for old, new in (("base_link", "hull"), ("servo_", "part"), ("eta_", "motor"), ('"tip"', '"claw"')):
        text = text.replace(old, new)
    above = '<joint name="j" type="{}"><parent link="{}"/><child link="hull"/></joint><link name="{}"/></robot>'
    path, shipped, posture = tmp_path / "v.urdf", Vehicle(VEHICLE), [0.3, 0.2, -0.5, 0.4]
    for kind, root in (("floating", "world"), ("fixed", "map"), ("floating", "odom frame")):
        path.write_text(text.replace("</robot>", above.format(kind, root, root)), encoding="utf-8")
        vehicle = Vehicle(path, VehicleSection(base_link="hull", tip="claw"))
        assert vehicle.joint_names == tuple(f"motor{k}" for k in range(1, 5))
        assert vehicle.point_names == ("motor3", "motor4", "claw")
        assert vehicle.standing_joints == ()
        np.testing.assert_array_equal(vehicle.point_positions(posture), shipped.point_positions(posture))
        assert (vehicle.mass, vehicle.radius, len(vehicle.rotors)) == (shipped.mass, shipped.radius, 6)


def test_a_tip_that_the_base_link_does_not_carry_is_refused(tmp_path: Path) -> None:
    """A post beside a vehicle that floats in the same world."""
    heavy = '<inertial><mass value="9"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    post = f'<link name="post">{heavy}</link><joint name="stands" type="fixed"><parent link="world"/><child link="post"/></joint>'
    world = (
        '<link name="world"/><joint name="j" type="floating"><parent link="world"/><child link="base_link"/></joint>'
    )
    path = write_edited(tmp_path / "v.urdf", VEHICLE, ("</robot>", world + post + "</robot>"))
    with pytest.raises(UrdfError, match="no chain of joints"):
        Vehicle(path, VehicleSection(tip="post"))


VIRTUAL = [
    ("prismatic", "1 0 0"),
    ("prismatic", "0 1 0"),
    ("prismatic", "0 0 1"),
    ("revolute", "0 0 1"),
    ("revolute", "0 1 0"),
]


def write_on_joints(path: Path, mass: float) -> Path:
    """The shipped vehicle at the end of five joints, whose links have a mass each."""
    links, above = '<link name="world"/>', "world"
    for k, (kind, axis) in enumerate([*VIRTUAL, ("continuous", "1 0 0")]):
        child = "base_link" if k == len(VIRTUAL) else f"virtual_{k}"
        links += (
            f'<joint name="virtual_joint_{k}" type="{kind}"><parent link="{above}"/><child link="{child}"/><axis xyz="{axis}"/>'
            '<limit lower="-50" upper="50" effort="0" velocity="-1"/></joint>'
        )
        if child != "base_link":
            links += (
                f'<link name="{child}"><inertial><mass value="{mass}"/>'
                '<inertia ixx="1e-9" iyy="1e-9" izz="1e-9" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            )
        above = child
    return write_edited(path, VEHICLE, ("</robot>", links + "</robot>"))


def test_a_floating_base_may_be_written_as_joints(tmp_path: Path) -> None:
    """As whole-body models of aerial manipulators have it: three slides and three hinges between links of no mass."""
    file = write_on_joints(tmp_path / "vehicle.urdf", 1e-6)
    vehicle, shipped = Vehicle(file), Vehicle(VEHICLE)
    posture = [0.3, 0.2, -0.5, 0.4]
    np.testing.assert_allclose(vehicle.point_positions(posture), shipped.point_positions(posture), atol=1e-12)
    np.testing.assert_allclose(vehicle.inertia(posture), shipped.inertia(posture), atol=1e-7)
    assert vehicle.joint_names == shipped.joint_names and vehicle.standing_joints == ()
    assert len(vehicle.rotors) == 6 and vehicle.mass == pytest.approx(shipped.mass, abs=1e-5)
    plant = Simulator(Model(Scenario(vehicle={"urdf": str(file)})), 0.001)
    assert float(plant.plant.engine_model.body_mass.sum()) == pytest.approx(
        float(Simulator(Model(Scenario()), 0.001).plant.engine_model.body_mass.sum()), abs=1e-4
    )


def test_an_arm_that_a_cart_carries_does_not_fly(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match="no chain of joints"):
        Vehicle(write_on_joints(tmp_path / "vehicle.urdf", 1.0))


def test_a_stick_has_a_model(tmp_path: Path) -> None:
    model = Model(Scenario(vehicle={"urdf": str(write_arm_of(tmp_path / "stick.urdf", 0))}))
    assert (model.n_arm, model.nx, model.nu) == (0, 5, 4)
    assert model.start_arm.shape == (0,) and "start.arm" in model.proposed
    assert model.derivative(model.start_state, model.hover_input).shape == (5,)
    a, b = model.step_jacobian(model.start_state, model.hover_input)
    assert (a.shape, b.shape) == ((5, 5), (5, 4))


XACRO = '<robot name="r" xmlns:xacro="{}"><xacro:include filename="a.xacro"/><link name="b"/></robot>'


@pytest.mark.parametrize(
    "text",
    [
        XACRO.format("http://www.ros.org/wiki/xacro"),
        XACRO.format("http://ros.org/wiki/xacro"),
        XACRO.replace(' xmlns:xacro="{}"', ""),
    ],
)
@pytest.mark.parametrize(
    ("name", "out"),
    [("uav.urdf.xacro", "uav.urdf"), ("uav.xacro", "uav.urdf"), ("uav.urdf", "expanded_uav.urdf")],
)
def test_xacro_is_refused_with_the_command_that_expands_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, name: str, out: str
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(UrdfError, match="xacro") as caught:
        Vehicle(tmp_path / name)
    assert f"xacro {name} -o {out}" in str(caught.value.allowed)


def test_xacro_is_expanded_where_it_is_installed(tmp_path: Path) -> None:
    edits = (' name="hexarotor_arm"', ' name="hexarotor_arm" xmlns:xacro="http://www.ros.org/wiki/xacro"'), (
        '<mass value="3.0"/>', '<xacro:property name="mass" value="${1 + 2.5}"/><mass value="${mass}"/>',
    )  # fmt: skip
    assert Vehicle(write_edited(tmp_path / "v.urdf.xacro", VEHICLE, *edits)).mass == pytest.approx(
        Vehicle(VEHICLE).mass + 0.5
    )


def test_a_fault_in_xacro_is_told_in_its_words(tmp_path: Path) -> None:
    path = tmp_path / "v.xacro"
    path.write_text('<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="${lost}"/></robot>')
    with pytest.raises(UrdfError, match="cannot expand") as caught:
        Vehicle(path)
    assert "lost" in str(caught.value.given)


def test_what_xacro_has_written_is_a_urdf(tmp_path: Path) -> None:
    head = '<!-- autogenerated by xacro: <xacro:include> -->\n<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name='
    assert Vehicle(write_edited(tmp_path / "v.urdf", VEHICLE, ("<robot name=", head))).n_arm == 4
