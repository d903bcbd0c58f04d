"""Rotors at any tilt: body force and torque against MuJoCo, and which vehicles are fully actuated."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE, write_edited

from doorman.exceptions import BackendError
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.actuation import actuation_of
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import Scenario
from doorman.simulation.plant.engine import engine
from doorman.simulation.plant.onboard.rotors import MixerParameters, add_side, mix
from doorman.simulation.plant.plant import build_plant

TILTED = Vehicle(urdf_directory() / "tilted_hexarotor.urdf")
LAYOUT = rotor_layout(TILTED, 0.016)


def canted(folder: Path, *cants: tuple[float, float]) -> Vehicle:
    """The shipped vehicle with its rotors turned about the body's x and y axes [rad]."""
    text, edits = VEHICLE.read_text(encoding="utf-8"), []
    for k, (roll, pitch) in enumerate(cants):
        start = text.index("<origin", text.index(f'<joint name="rotor_{k + 1}"'))
        origin = text[start : text.index("/>", start)]
        edits.append((origin, origin.replace('rpy="0 0 0"', f'rpy="{roll} {pitch} 0"')))
    return Vehicle(write_edited(folder / "vehicle.urdf", VEHICLE, *edits))


def alternating(tilt: float) -> list[tuple[float, float]]:
    """Six rotors every 60° from 30°, canted about their arms to either side in turn."""
    around = [math.pi / 6 + k * math.pi / 3 for k in range(6)]
    return [((-1) ** k * tilt * math.cos(a), (-1) ** k * tilt * math.sin(a)) for k, a in enumerate(around)]


def test_rotors_make_in_mujoco_what_the_layout_says() -> None:
    model = Model(Scenario.load("push_tilted"))
    mujoco, thrusts = engine(), np.array([3.0, 5.0, 2.0, 4.0, 6.0, 1.0])
    plant = build_plant(mujoco, model, LAYOUT, 0.001)
    plant.data.ctrl[:6] = plant.data.act[:] = thrusts
    mujoco.mj_forward(plant.engine_model, plant.data)
    force, torque = plant.data.qfrc_actuator[:3], plant.data.qfrc_actuator[3:6]
    rotation = rotation_body_to_world(model.start_state[:3])
    made = LAYOUT.wrench @ thrusts
    np.testing.assert_allclose(rotation.T @ force, made[:3], atol=1e-9)
    np.testing.assert_allclose(torque, made[3:], atol=1e-9)
    assert LAYOUT.rank == 6 and LAYOUT.fully_actuated


@pytest.mark.parametrize(("tilt", "fully"), [(0.0, False), (0.01, False), (0.2, True), (0.5, True)])
def test_rotors_that_push_to_every_side_make_a_fully_actuated_vehicle(tmp_path: Path, tilt: float, fully: bool) -> None:
    vehicle = canted(tmp_path, *alternating(tilt))
    layout = rotor_layout(vehicle, 0.016)
    assert layout.fully_actuated is fully
    assert actuation_of(vehicle, 0.016).fully is fully
    level = np.array([vehicle.mass * GRAVITY, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(layout.allocation @ layout.inverse @ level, level, atol=1e-9)
    assert abs(vehicle.max_thrust - 48.0 * math.cos(tilt)) < 0.1


def test_rotors_that_all_lean_one_way_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BackendError, match="beside the body's z axis"):
        rotor_layout(canted(tmp_path, *[(0.0, 0.1)] * 6), 0.016)


@pytest.mark.parametrize("side", [(0.8, -1.1), (-1.4, 0.0), (9.0, 7.0)])
def test_the_mixer_adds_force_to_the_side_and_nothing_else(side: tuple[float, float]) -> None:
    mixer, torque = MixerParameters.of(LAYOUT), np.array([0.3, -0.2, 0.1])
    mix(mixer, 24.0, torque)
    add_side(mixer, *side)
    made = LAYOUT.wrench @ mixer.thrusts
    np.testing.assert_allclose(made[2:], [24.0, *torque], atol=1e-9)
    assert (mixer.thrusts >= 0.0).all() and (mixer.thrusts <= LAYOUT.max_thrusts).all()
    share = np.hypot(*made[:2]) / np.hypot(*side)
    np.testing.assert_allclose(made[:2], share * np.array(side), atol=1e-9)
    assert share == pytest.approx(1.0) if max(np.abs(side)) < 2.0 else 0.0 < share < 0.7


def test_a_level_body_makes_what_the_rotors_can() -> None:
    actuation = actuation_of(TILTED, 0.016)
    weight = TILTED.mass * GRAVITY
    for yaw in (0.0, 0.7, -2.0):
        for wanted in ([1.0, -0.5, weight], [30.0, 10.0, weight], [2.0, 2.0, 200.0], [0.0, -3.0, -5.0]):
            force = actuation.within_limits(np.array(wanted), yaw, 0.1)
            body = actuation.body_force(force, actuation.attitude(force, yaw))
            thrusts = LAYOUT.inverse @ [body[2], 0.0, 0.0, 0.0] + LAYOUT.side_inverse @ body[:2]
            assert (thrusts > 0.0).all() and (thrusts < LAYOUT.max_thrusts).all()
            assert abs(force[0] * wanted[1] - force[1] * wanted[0]) < 1e-9
    np.testing.assert_allclose(actuation.within_limits(np.array([1.0, -0.5, weight]), 0.3, 0.1), [1.0, -0.5, weight])
    np.testing.assert_array_equal(actuation.attitude(np.array([3.0, 2.0, 9.0]), 0.4), [0.0, 0.0, 0.4])


@pytest.mark.parametrize("heading", range(0, 360, 20))
def test_what_a_plan_may_ask_is_the_polytope(heading: int) -> None:
    """A force on its border passes the controller uncut, and a larger one is cut to it."""
    actuation, turn = actuation_of(TILTED, 0.016), math.radians(heading)
    rotors, lift = actuation.rotors, TILTED.mass * GRAVITY
    assert rotors is not None and len(rotors.lifts) == 3, "of six, those opposite each other make the same"
    ahead = np.array([math.cos(turn), math.sin(turn)])
    shares = rotors.sides @ ahead
    room = np.where(shares > 0.0, rotors.most - lift * rotors.lifts, lift * rotors.lifts - rotors.least)
    most = float((room / np.maximum(np.abs(shares), 1e-9)).min())
    assert most > 3.0
    for share in (1.0, 1.5):
        found = actuation.within_limits(np.array([*(share * most * ahead), lift]), 0.0, 0.1)
        np.testing.assert_allclose(found, [*(most * ahead), lift], atol=1e-4)
