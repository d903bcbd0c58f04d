"""The plant built from the URDFs: masses against Pinocchio, placement, names, and what MuJoCo cannot take."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pinocchio
import pytest
from urdf_variants import write_edited

from doorman.exceptions import BackendError, UrdfError
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.resources import urdf_directory
from doorman.simulation.plant.hulls import read_spec

VEHICLE = (urdf_directory() / "hexarotor_arm.urdf").read_text()
DOOR_FILE = urdf_directory() / "hinged_door.urdf"
DOOR = DOOR_FILE.read_text()
FLAT = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
SHAPE = '<collision><geometry><mesh filename="{}"/></geometry></collision>'
INERTIAL = '<inertial><origin xyz="0.03 0.01 -0.02" rpy="0 0 0"/><mass value="0.12"/><inertia ixx="2e-4" ixy="1e-5" ixz="0" iyy="3e-4" iyz="-1e-5" izz="2.5e-4"/></inertial>'  # noqa: E501  # fmt: skip


def written(folder, name: str, text: str) -> str:
    path = folder / name
    path.write_text(text)
    return str(path)


def heavy_arm() -> str:
    text = VEHICLE
    for k in range(1, 5):
        text = text.replace(f'<link name="servo_{k}">', f'<link name="servo_{k}">{INERTIAL}')
    return text


def mass_matrix(plant) -> np.ndarray:
    full = np.zeros((plant.engine_model.nv, plant.engine_model.nv))
    mujoco.mj_fullM(plant.engine_model, plant.data, full)
    return full


@pytest.mark.parametrize("massive", [False, True])
def test_mass_matrix_is_pinocchios(flight, tmp_path, massive):
    path = written(tmp_path, "arm.urdf", heavy_arm()) if massive else str(urdf_directory() / "hexarotor_arm.urdf")
    vehicle = flight(vehicle__urdf=path)
    plant, arm = vehicle.plant, vehicle.plant.arm_velocities
    attitude, angles = np.array([0.3, -0.4, 1.1]), np.array([0.5, 1.0, -0.7, 0.4])
    rotation = rotation_body_to_world(attitude)
    mujoco.mju_mat2Quat(plant.data.qpos[3:7], rotation.ravel())
    plant.data.qpos[plant.arm_positions] = angles
    mujoco.mj_forward(plant.engine_model, plant.data)

    reference = pinocchio.buildModelFromUrdf(path, pinocchio.JointModelFreeFlyer())
    x, y, z, w = pinocchio.Quaternion(rotation).coeffs()
    expected = pinocchio.crba(reference, reference.createData(), np.array([0, 0, 0, x, y, z, w, *angles]))
    expected = np.triu(expected) + np.triu(expected, 1).T
    to_local = np.eye(10)
    to_local[:3, :3] = rotation.T  # Pinocchio's free flyer moves along its own axes, MuJoCo's along the world's
    expected = to_local.T @ expected @ to_local
    expected[6:, 6:] += 0.01 * vehicle.model.vehicle.mass / 3.0 * np.eye(4)  # the servos' armature

    rows = np.ix_([*range(6), *arm], [*range(6), *arm])
    actual = mass_matrix(plant)
    assert np.abs(actual[rows] - expected).max() < 1e-3 * 0.045
    assert actual[plant.hinge_velocity, plant.hinge_velocity] == pytest.approx(5.28, rel=1e-6)
    assert np.abs(np.delete(actual[plant.hinge_velocity], plant.hinge_velocity)).max() == 0.0


@pytest.mark.parametrize("kind", ["grip", "push"])
def test_start_pose_is_the_scenarios(flight, kind):
    vehicle = flight(contact__kind=kind, start__door_angle=1.3)
    truth, model = vehicle.simulator.truth(), vehicle.model
    expected = model.coupling.vehicle_motion(model.start_state, np.zeros(3), np.zeros(4)).position
    assert np.abs(truth.position - expected).max() < (1e-12 if kind == "grip" else 1e-3)
    assert truth.attitude == pytest.approx(model.start_state[:3], abs=1e-12)
    assert (truth.door_angle, truth.door_rate) == (1.3, 0.0)
    assert np.array_equal(truth.arm_angles, model.start_arm)
    assert np.abs([*truth.velocity, *truth.body_rates, *truth.arm_rates]).max() == 0.0
    assert truth.rotor_thrusts == pytest.approx(np.full(6, 29.43 / 6))
    contact = model.door.contact_point(1.3, 0.7, 0.8)
    assert vehicle.data.site("contact").xpos == pytest.approx(contact, abs=1e-12)
    assert vehicle.data.site("tip").xpos == pytest.approx(contact, abs=1e-12 if kind == "grip" else 1e-3)


def test_limits_are_the_urdfs_in_radians(flight):
    engine_model = flight().plant.engine_model
    assert engine_model.joint("vehicle/eta_2").range == pytest.approx([-1.65, 1.65])
    assert engine_model.joint("door/hinge").range == pytest.approx([-1.5, 1.5708])


def test_renamed_links_and_a_base_link_away_from_the_root(flight, tmp_path):
    root = """<link name="footprint"/><joint name="up" type="fixed"><origin xyz="0.1 0.2 -0.3" rpy="0.1 0 0.5"/>
      <parent link="footprint"/><child link="chassis"/></joint>"""
    text = VEHICLE.replace('base_link"', 'chassis"').replace('"tip"', '"finger"')
    vehicle_urdf = written(
        tmp_path, "v.urdf", text.replace('<robot name="hexarotor_arm">', f'<robot name="other">{root}')
    )
    door_urdf = written(tmp_path, "d.urdf", DOOR.replace('"leaf"', '"wing"').replace('"hinge"', '"pivot"'))
    names = {
        "vehicle__urdf": vehicle_urdf, "vehicle__base_link": "chassis", "vehicle__tip": "finger",
        "door__urdf": door_urdf, "door__leaf": "wing", "door__hinge": "pivot", "contact__kind": "push",
    }  # fmt: skip
    renamed, plain = flight(**names), flight(contact__kind="push")
    for vehicle in (renamed, plain):
        vehicle.command(32.0, (0.05, 0.1, 0.2), [0.1, 0.0, 0.2, 0.0])
    for ours, theirs in zip(renamed.run(0.5, every=100), plain.run(0.5, every=100), strict=True):
        # not closer: the free joint sits at another point, so the integration's error is another
        assert ours.position == pytest.approx(theirs.position, abs=1e-3)
        assert ours.velocity == pytest.approx(theirs.velocity, abs=5e-3)
        assert ours.attitude == pytest.approx(theirs.attitude, abs=1e-3)
        assert ours.body_rates == pytest.approx(theirs.body_rates, abs=5e-3)
        assert ours.door_angle == pytest.approx(theirs.door_angle, abs=1e-3)


def test_vehicle_with_a_heavy_arm_starts_trimmed(flight, tmp_path):
    vehicle = flight(vehicle__urdf=written(tmp_path, "arm.urdf", heavy_arm()), contact__kind="push", away=True)
    assert np.abs(vehicle.model.vehicle.center_of_mass(vehicle.model.start_arm)[:2]).max() > 0.01
    vehicle.command(vehicle.model.vehicle.mass * 9.81)
    truths = vehicle.run(1.0, every=50)
    assert max(np.abs(truth.attitude).max() for truth in truths) < math.radians(0.1)


def test_tip_without_a_shape_gets_one(flight, tmp_path):
    start = VEHICLE.rindex("<collision>")
    text = VEHICLE[:start] + VEHICLE[VEHICLE.rindex("</collision>") + len("</collision>") :]
    vehicle = flight(
        vehicle__urdf=written(tmp_path, "bare.urdf", text), contact__kind="push", simulation__door_friction=50.0
    )
    vehicle.lean(5.0)
    assert vehicle.run(3.0, every=3000)[-1].tip_normal_force == pytest.approx(5.0, abs=0.3)


def test_impossible_inertia_names_its_link(flight, tmp_path):
    path = written(tmp_path, "thin.urdf", DOOR.replace('iyy="3.66666667"', 'iyy="5.0"'))
    with pytest.raises(BackendError, match="rigid body") as caught:
        flight(door__urdf=path)
    assert caught.value.field == "link leaf/inertial/inertia" and caught.value.file == path


def test_a_link_called_world_keeps_its_place(tmp_path):
    path = write_edited(
        tmp_path / "door.urdf", DOOR_FILE, ('<link name="frame">', '<link name="world">'),
        ('<parent link="frame"/>', '<parent link="world"/>'),
        ("</robot>", '<link name="map"/><joint name="place" type="fixed"><origin xyz="2 -1 0.3" rpy="0 0 1.2"/>'
         '<parent link="map"/><child link="world"/></joint></robot>'),
    )  # fmt: skip
    places = []
    for urdf in (path, DOOR_FILE):
        spec = read_spec(mujoco, urdf)
        spec.compiler.balanceinertia = True  # the shipped leaf's inertia is rounded
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        places.append(data.geom_xpos[np.argsort(model.geom_size.prod(axis=1))])
    turn = np.array([[np.cos(1.2), -np.sin(1.2), 0.0], [np.sin(1.2), np.cos(1.2), 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(places[0], places[1] @ turn.T + [2.0, -1.0, 0.3], atol=1e-9)


@pytest.mark.parametrize(("mesh", "content"), [("flat.obj", FLAT), ("lost.stl", None), ("odd.xyz", "1 2 3")])
def test_a_mesh_of_the_door(flight, tmp_path, mesh, content):
    if content is not None:
        (tmp_path / mesh).write_text(content, encoding="utf-8")
    path = tmp_path / "door.urdf"
    path.write_text(
        DOOR.replace('<link name="frame">', f'<link name="frame">{SHAPE.format(mesh)}', 1), encoding="utf-8"
    )
    with pytest.raises(UrdfError, match="mesh") as caught:
        flight(door__urdf=str(path))
    assert (caught.value.file, caught.value.field) == (str(path), "link frame/collision frame/0")
    assert mesh in str(caught.value.given)
