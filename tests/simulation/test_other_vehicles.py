"""Plants of other vehicles: an arm that slides, a stick, and the flying arms of example-robot-data with their own meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, VEHICLE, robot_data_vehicle, write_arm_of, write_scaled

from doorman.collision.shapes import read_shapes

LEVEL = (0.0, 0.0, 0.0)
ENDS = {"start__attitude": LEVEL, "goal__attitude": (0.0, 0.0, -1.22)}
"""With the arms given as well, no posture is searched."""


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
