"""Plants of other vehicles: arms that slide or have mass, blunt tips, a stick, and flying arms with their own meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, VEHICLE, robot_data_vehicle, write_arm_of, write_massive, write_scaled
from vehicles_with_blunt_tips import TIP_AT, write_with_end

from doorman.collision.shapes import read_shapes
from doorman.feasibility.lift import weight_on_joints

LEVEL = (0.0, 0.0, 0.0)
ENDS = {"start__attitude": LEVEL, "goal__attitude": (0.0, 0.0, -1.22)}
"""With the arms given as well, no posture is searched."""
BLUNT = ENDS | {"start__arm": (0.0, 1.0, -0.6, -0.4), "goal__arm": (0.0, 1.5708, -1.5708, 0.0)}
MASSES = {"servo_1": 0.1, "servo_2": 0.15, "servo_3": 0.15, "servo_4": 0.2}


@pytest.fixture
def telescope(flight, tmp_path: Path):
    """The last joint slides along the rod by 0.1 m either way."""
    text = VEHICLE.read_text(encoding="utf-8")
    start = text.index('<joint name="eta_4"')
    end = text.index("</joint>", start)
    joint = text[start:end].replace("revolute", "prismatic").replace("0 -1 0", "1 0 0").replace("1.80", "0.1")
    path = tmp_path / "telescope.urdf"
    path.write_text(text[:start] + joint.replace('effort="3.1"', 'effort="40"') + text[end:], encoding="utf-8")
    arm = (0.0, 1.0, -0.6, 0.0)
    return flight(vehicle__urdf=str(path), contact__kind="push", away=True, start__arm=arm, goal__arm=arm, **ENDS)


def test_a_sliding_joint_is_tracked_and_stops_at_its_end(telescope) -> None:
    telescope.command(arm_rates=[0.0, 0.0, 0.0, 0.1])
    ways = np.array([truth.arm_angles[3] for truth in telescope.run(0.5, every=100)])
    assert ways[-1] - ways[0] == pytest.approx(0.04, abs=1e-3)
    end = telescope.run(1.5, every=500)[-1]
    assert end.arm_angles[3] == pytest.approx(0.1, abs=2e-3)
    assert end.arm_rates[3] == pytest.approx(0.0, abs=1e-3)


def test_a_sliding_joint_holds_a_load_up_to_its_force(telescope) -> None:
    telescope.command()
    telescope.data.qfrc_applied[telescope.plant.arm_velocities[3]] = -20.0
    held = telescope.run(0.6, every=100)
    assert max(abs(truth.arm_angles[3]) for truth in held) < 5e-3
    assert abs(held[-1].arm_rates[3]) < 1e-3
    telescope.data.qfrc_applied[telescope.plant.arm_velocities[3]] = -60.0
    assert telescope.run(0.3, every=300)[-1].arm_angles[3] < -0.02


def test_a_stick_pushes_a_door_that_stands_firm(flight, tmp_path: Path) -> None:
    path = write_arm_of(tmp_path / "stick.urdf", 0)
    stick = flight(
        vehicle__urdf=str(path),
        contact__kind="push",
        simulation__door_friction=50.0,
        start__arm=(),
        goal__arm=(),
        **ENDS,
    )
    assert stick.model.n_arm == 0 and stick.plant.arm_positions.shape == (0,)
    assert stick.gap() < 2e-3
    stick.lean(5.0)
    truth = stick.run(3.0, every=3000)[-1]
    assert truth.tip_normal_force == pytest.approx(5.0, abs=0.7)  # it tilts with its body
    assert truth.arm_angles.shape == (0,)


@pytest.mark.parametrize(
    ("name", "arm"),
    [("borinot_flying_arm_2", (1.4101, -0.0582)), ("hextilt_flying_arm_5", (1.5475, 0.0618, -0.0534, -0.0495, 0.0))],
)
def test_flying_arms_fly_with_their_own_meshes(flight, name: str, arm: tuple[float, ...]) -> None:
    path, names = robot_data_vehicle(name)
    given = {f"vehicle__{key}": value for key, value in names.model_dump(exclude_none=True, exclude={"rotors"}).items()}
    vehicle = flight(**given, start__arm=arm, goal__arm=arm, away=True, **ENDS)
    engine, meshes = vehicle.plant.engine_model, [shape for shape in read_shapes(path)]
    assert engine.nmesh == len(meshes) > 2
    hulls = [
        np.ptp(engine.mesh_vert[at : at + n], axis=0)
        for at, n in zip(engine.mesh_vertadr, engine.mesh_vertnum, strict=True)
    ]
    diagonals = sorted(float(np.linalg.norm(2.0 * shape.half_extents)) for shape in meshes)
    assert max(map(np.linalg.norm, hulls)) == pytest.approx(diagonals[-1], rel=0.25)  # the engine turns them
    vehicle.command(vehicle.model.vehicle.mass * 9.81)
    truths = vehicle.run(0.2, every=50)
    assert all(np.isfinite(truth.position).all() for truth in truths)
    assert abs(truths[-1].position[2] - truths[0].position[2]) < 0.2


@pytest.mark.parametrize("size", [0.5, 1.5, 2.0])
def test_servos_hold_a_gripping_arm_of_another_size_alike(flight, size: float, tmp_path: Path) -> None:
    """The grip's spring and damper grow with the vehicle: servos that did not let a large arm whip round."""
    vehicle = flight(
        vehicle__urdf=str(write_scaled(tmp_path / "vehicle.urdf", VEHICLE, size)),
        door__urdf=str(write_scaled(tmp_path / "door.urdf", DOOR, size)),
        contact__distance_from_hinge=0.7 * size, contact__height=0.8 * size, simulation__door_friction=50.0 * size**4,
    )  # fmt: skip
    weight, push = vehicle.model.vehicle.mass * 9.81, 6.0 * size**3
    before = vehicle.simulator.truth().arm_angles
    vehicle.command(np.hypot(weight, push), (0.0, float(np.arctan2(push, weight)), 0.0))
    truths = vehicle.run(4.0, every=20)
    assert max(np.abs(truth.arm_angles - before).max() for truth in truths) < 0.15
    assert truths[-1].tip_normal_force == pytest.approx(push, rel=0.1) and vehicle.gap() < 3e-3 * size


@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_it_pushes_as_the_tip_and_collides_with_nothing(flight, tmp_path: Path, kind: str) -> None:
    path = write_with_end(tmp_path / "vehicle.urdf", kind, {"size": "0.06 0.03 0.02"}, TIP_AT - 0.025)
    blunt = flight(vehicle__urdf=str(path), contact__kind="push", simulation__door_friction=50.0, **BLUNT)
    engine, data = blunt.plant.engine_model, blunt.data
    (end,) = [k for k in blunt.plant.tip_shapes if blunt.plant.shape_name(k) == "end"]
    link = data.body("vehicle/servo_4")
    np.testing.assert_allclose(
        link.xmat.reshape(3, 3).T @ (data.geom_xpos[end] - link.xpos), [TIP_AT - 0.025, 0, 0], atol=1e-9
    )
    assert engine.body(engine.geom_bodyid[end]).name == "vehicle/tip"
    blunt.lean(5.0)
    truths = blunt.run(3.0, every=1000)
    assert truths[-1].tip_normal_force == pytest.approx(5.0, abs=0.7)
    assert not any(truth.collisions for truth in truths), [truth.collision_pairs for truth in truths]


def test_it_still_collides_with_the_frame(flight, tmp_path: Path) -> None:
    path = write_with_end(tmp_path / "vehicle.urdf", "box", {"size": "0.06 0.03 0.02"}, TIP_AT - 0.025)
    blunt = flight(vehicle__urdf=str(path), contact__kind="push", **BLUNT)
    tip = blunt.data.site("tip").xpos
    lintel = blunt.data.body("door/frame").xpos + np.array([-0.06, 0.6, 2.04])
    blunt.data.qpos[:3] += lintel - tip
    seen = blunt.run(0.002)[-1].collision_pairs
    assert any("end" in pair and "leaf" not in pair for pair in seen), seen


@pytest.fixture
def massive(flight, tmp_path: Path):
    """0.6 kg on the arm, in free flight."""
    path = write_massive(tmp_path / "arm.urdf", MASSES)
    return flight(vehicle__urdf=str(path), contact__kind="push", away=True)


def test_servos_hold_the_arms_weight(massive) -> None:
    massive.command(massive.model.vehicle.mass * 9.81)
    truth = massive.run(1.0, every=1000)[-1]
    np.testing.assert_allclose(truth.arm_angles, massive.model.start_arm, atol=5e-3)
    state = np.concatenate([truth.attitude, [0.0, 0.0], truth.arm_angles])
    expected = weight_on_joints(massive.model, state)
    torques = massive.data.qfrc_actuator[massive.plant.arm_velocities]
    assert np.abs(expected).max() > 0.5
    np.testing.assert_allclose(torques, expected, atol=0.02)


def test_a_servo_that_is_too_weak_slips(flight, tmp_path: Path) -> None:
    strong = write_massive(tmp_path / "arm.urdf", MASSES)
    text = strong.read_text(encoding="utf-8").replace('effort="3.1"', 'effort="0.3"')
    weak = tmp_path / "weak.urdf"
    weak.write_text(text, encoding="utf-8")
    vehicle = flight(vehicle__urdf=str(weak), contact__kind="push", away=True)
    vehicle.command(vehicle.model.vehicle.mass * 9.81)
    fallen = vehicle.run(0.4, every=400)[-1].arm_angles - vehicle.model.start_arm
    assert np.abs(fallen).max() > 0.1
    assert np.abs(vehicle.data.qfrc_actuator[vehicle.plant.arm_velocities]).max() < 0.31
