"""Contact of tip and leaf, gripping and pushing, against balances of force that do not use the engine's contact."""

from __future__ import annotations

import math

import numpy as np
import pytest
from paper_door import door_normal

from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation.simulator import Disturbance, Simulator

HOVER = 3.0 * 9.81
SLIDES = 0.4
"""Against 0.25 N m of friction and what the tip holds [N m]."""


def force_on_door(truth) -> np.ndarray:
    """What is left of thrust and weight of a vehicle in balance: f_t R e3 − m g e3."""
    lift = truth.rotor_thrusts.sum() * rotation_body_to_world(truth.attitude)[:, 2]
    return lift - np.array([0.0, 0.0, HOVER])


@pytest.mark.parametrize("kind", ["grip", "push"])
def test_tip_force_balances_thrust_and_weight(flight, kind):
    vehicle = flight(contact__kind=kind, simulation__door_friction=50.0)
    vehicle.lean(10.0)
    truths = vehicle.run(5.0, every=250)
    end = truths[-1]
    assert end.tip_normal_force == pytest.approx(10.0, abs=0.1)
    assert end.tip_force == pytest.approx(force_on_door(end), abs=0.1)
    assert end.tip_normal_force == pytest.approx(float(end.tip_force @ door_normal(end.door_angle)), abs=1e-3)
    assert end.touching and end.collisions == 0
    assert abs(end.door_angle - math.pi / 2) < 1e-4


def test_grip_holds_tip_and_leaf_together(flight):
    vehicle = flight(simulation__door_friction=50.0)
    vehicle.lean(10.0)
    gaps = []
    for _ in range(1000):
        vehicle.simulator.advance(4)
        gaps.append(vehicle.gap())
    assert max(gaps) < 3e-3
    assert gaps[-1] == pytest.approx(10.0 / 5000.0, rel=0.03)  # the grip's stiffness, and no drift


def test_grip_pulls(flight):
    vehicle = flight(start__door_angle=1.2)
    vehicle.lean(-6.0)
    truths = vehicle.run(1.5, every=10)
    assert truths[-1].door_angle > 1.25
    assert min(truth.tip_normal_force for truth in truths) < -2.0
    assert max(truth.max_pull for truth in truths) == pytest.approx(-min(t.tip_normal_force for t in truths), rel=0.05)
    assert all(truth.touching for truth in truths)
    assert vehicle.gap() < 3e-3


@pytest.mark.parametrize("start", ["contact", "hover"])
def test_a_gripper_that_does_not_close_only_pushes(flight, start):
    vehicle = flight(simulation__gripper_force=0.0, mission__start=start)
    vehicle.data.qpos[:7] = flight().data.qpos[:7]  # the tip on the leaf
    vehicle.simulator.set_grip(True)
    vehicle.lean(-5.0)
    truths = vehicle.run(1.0, every=10)
    assert max(truth.max_pull for truth in truths) < 1e-9 and not truths[-1].touching
    assert vehicle.gap() > 0.1


def test_pushing_tip_never_pulls_and_separates(flight):
    vehicle = flight(contact__kind="push")
    vehicle.lean(5.0)
    pushing = vehicle.run(1.0)
    assert pushing[-1].touching and pushing[-1].door_angle < math.pi / 2 - 0.05
    vehicle.lean(-5.0)
    leaving = vehicle.run(1.5)
    assert min(truth.tip_normal_force for truth in pushing + leaving) >= -1e-9
    assert max(truth.max_pull for truth in pushing + leaving) <= 1e-9
    assert not leaving[-1].touching and np.array_equal(leaving[-1].tip_force, np.zeros(3))
    tip = np.array(vehicle.data.site("tip").xpos) - vehicle.model.door.hinge_position
    assert tip @ door_normal(leaving[-1].door_angle) < -0.02
    assert leaving[-1].door_rate == pytest.approx(leaving[-200].door_rate, rel=1e-3)  # nothing pulls the door back


@pytest.mark.parametrize(("friction", "slides"), [(0.8, False), (0.05, True)])
def test_friction_stays_in_its_cone_and_only_a_smooth_tip_slides(flight, friction, slides):
    vehicle = flight(contact__kind="push", simulation__door_friction=50.0, simulation__tip_friction=friction)
    heights = []
    for force in np.linspace(0.0, 8.0, 60):
        vehicle.lean(force)
        heights.append(float(vehicle.data.site("tip").xpos[2]))
        for truth in vehicle.run(0.02, every=4):
            tangential = truth.tip_force - truth.tip_normal_force * door_normal(truth.door_angle)
            assert np.linalg.norm(tangential) <= friction * truth.tip_normal_force + 1e-3
    slid = abs(heights[-1] - heights[35])  # from when the touch is firm
    assert slid > 0.03 if slides else slid < 1e-3


def test_start_touches_without_force(flight):
    for pose in ((0.0, 1.0, -0.6, -0.4), (0.2, 0.9, -0.9, 0.3)):
        vehicle = flight(contact__kind="push", start__arm=pose)
        start = vehicle.simulator.truth()
        assert start.collisions == 0 and abs(start.tip_normal_force) < 0.05
        assert vehicle.run(0.1, every=100)[-1].door_rate == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("kind", ["grip", "push"])
@pytest.mark.parametrize("seed", [0, 1])
def test_rough_handling_stays_stable(flight, kind, seed):
    """Commands that fight the tie and saturate the servos must not make the integration diverge."""
    generator = np.random.default_rng(seed)
    vehicle = flight(contact__kind=kind)
    largest = 0.0
    for _ in range(60):
        vehicle.command(generator.uniform(15, 45), generator.uniform(-0.3, 0.3, 3), generator.uniform(-1, 1, 4))
        for truth in vehicle.run(0.05, every=10):
            assert np.abs(truth.tip_force).max() < 300.0
            assert np.abs(truth.body_rates).max() < 60.0
            largest = max(largest, vehicle.gap())
    assert kind == "push" or largest < 0.05


@pytest.mark.parametrize("time_step", [0.5e-3, 2e-3])
def test_contact_is_stable_at_other_physics_rates(flight, time_step):
    vehicle = flight(simulation__door_friction=50.0, time_step=time_step)
    vehicle.lean(10.0)
    forces = [truth.tip_normal_force for truth in vehicle.run(5.0, every=5)]
    assert np.mean(forces[-50:]) == pytest.approx(10.0, abs=0.15)
    assert np.abs(np.diff(forces[-50:])).max() < 0.01


def test_collision_with_the_jamb_is_reported(flight):
    vehicle = flight(contact__kind="push")
    vehicle.data.qpos[1] -= 0.35
    vehicle.data.qpos[0] -= 0.3
    vehicle.command(arm_rates=[3.0, 0.0, 0.0, 0.0])
    vehicle.run(0.5, every=500)
    vehicle.command(HOVER * 1.01, (0.0, 0.15, 0.0), [0.0] * 4)
    truths = vehicle.run(2.5, every=4)
    hits = [truth for truth in truths if truth.collisions]
    assert hits
    assert any("jamb_hinge" in pair for truth in hits for pair in truth.collision_pairs)
    assert all(truth.collision_pairs for truth in hits)
    assert all(not truth.collision_pairs for truth in truths if not truth.collisions)


@pytest.mark.parametrize("forward, only", [(0.0, True), (0.05, False)])
def test_a_tip_on_the_wall_is_told_from_an_arm_in_it(flight, forward, only):
    vehicle = flight(contact__kind="push")
    vehicle.data.qpos[1] -= 0.7 + 0.48
    vehicle.data.qpos[0] -= 0.1 - forward  # the wall's face is 10 cm before the leaf's
    vehicle.lean(1.0)
    hits = [truth for truth in vehicle.run(0.3) if truth.collisions]
    assert hits and all("wall_hinge" in " ".join(truth.collision_pairs) for truth in hits)
    assert all(truth.only_tip_on_frame for truth in hits) is only
    assert not any(truth.touching for truth in hits)


@pytest.mark.parametrize("mass", [None, 0.05])
def test_a_light_handle_is_not_thrown(mass: float | None) -> None:
    """A torque moves the handle against the hovering vehicle's tip: no force is far above what it takes to hold that."""
    keys = {"mission.start": "contact", "simulation.door_mass": mass}
    model = Model(Scenario.load("knob_valve", {key: value for key, value in keys.items() if value is not None}))
    simulator = Simulator(model, 0.001, lambda _: Disturbance(hinge_torque=model.travel.sense * SLIDES))
    simulator.set_grip(True)
    simulator.set_command(model.vehicle.weight, (0.0, 0.0, model.start_yaw), np.zeros(model.n_arm))
    forces, rates = [], []
    for _ in range(100):
        simulator.advance(3)
        truth = simulator.truth()
        forces.append(float(np.linalg.norm(truth.tip_force)))
        rates.append(abs(truth.door_rate))
    assert max(forces) < 10.0 * SLIDES / model.coupling.lever_length
    assert max(rates) < 2.0
