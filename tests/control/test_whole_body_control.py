"""Starts of whole-body plans from what is known, and commands that follow them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from believed import geometry

from doorman.control.estimation.estimator import Estimate
from doorman.control.kernels.tilted import tilted
from doorman.control.whole_body_control import WholeBodyController
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.estimation.leaf.hinge_fit import HingeEstimate
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.planning.pace import Pace
from doorman.planning.plan import Plan
from doorman.planning.planner import Planner
from doorman.planning.whole_body.contact import contact_forces, tip_on_face
from doorman.scenario import Scenario
from doorman.signals import Command

Array = np.ndarray


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(Scenario.load("push", {"planner.model": "whole_body"}))


@pytest.fixture(scope="module")
def model(planner: Planner) -> Model:
    return planner.model


def known(model: Model, distance: float, touching: bool = False, angle: float = math.pi / 2) -> Estimate:
    """A level vehicle at rest with its tip this far before the contact point."""
    posture = model.on_the_way(angle)
    position = model.coupling.vehicle_position(posture[:3], angle, posture[5:]) - distance * model.door.normal(angle)
    none = np.zeros(3)
    force = 0.7 if touching else 0.0
    state = np.concatenate([posture[:3], (angle, 0.0), posture[5:]])
    hinge = HingeEstimate(0.0, 0.0, 0.0, model.door.inertia, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Estimate(
        time=0.0, position=position, velocity=none, arm_angles=posture[5:], state=state, attitude_rates=none, tip_angle=angle,
        tip_speed=0.0, wind=none, tip_force=force * model.door.normal(angle), friction_force=np.zeros(2), normal_force=force,
        near=touching, touching=touching, resistance=0.5, friction_share=1.0, face_offset=0.0, door_disturbance=-0.5,
        hinge=hinge, **geometry(model, position, state),
    )  # fmt: skip


def planned(planner: Planner, controller: WholeBodyController, now: Estimate) -> Plan:
    state, numbers = controller.start(now)
    planner.update_numbers(numbers)
    return planner.plan(state)


@pytest.mark.parametrize("yaw", [-2.0, 0.3])
def test_another_heading_keeps_the_direction_of_the_thrust(yaw: float) -> None:
    attitude = np.array([*tilted(0.1, -0.2, yaw), yaw])
    wanted = rotation_body_to_world(np.array([0.1, -0.2, 0.0]))[:, 2]
    np.testing.assert_allclose(rotation_body_to_world(attitude)[:, 2], wanted, atol=1e-12)


def test_before_the_leaf_it_carries_its_weight_and_goes_on(planner: Planner, model: Model) -> None:
    controller, now = WholeBodyController(model), known(model, 0.1)
    command = controller.follow(planned(planner, controller, now), 0.0, 0.0, float(now.attitude[2]), 0.0, 0.004)
    up = command.thrust * rotation_body_to_world(command.attitude)[:, 2]
    assert up[2] == pytest.approx(model.vehicle.mass * GRAVITY, rel=0.1)
    assert up @ model.door.normal(math.pi / 2) > 0.0
    assert not command.grip and np.abs(command.arm_rates).max() < 1.5


def test_a_plan_is_followed_where_it_is_by_now_and_its_end_after_it(planner: Planner, model: Model) -> None:
    controller, now = WholeBodyController(model), known(model, 0.1)
    controller.fly_by(AttitudeLoop(0.1, 0.0))
    plan = planned(planner, controller, now)
    for time, node in ((0.0, 0), (0.0199, 0), (0.02, 1), (0.5, 25), (7.0, len(plan.inputs) - 1)):
        command = controller.follow(plan, 0.0, time, 0.3, 0.0, 10.0)
        assert command.thrust == plan.inputs[node, 0]
        np.testing.assert_allclose(command.arm_rates, plan.inputs[node, 4:], rtol=1e-12)


def test_joint_rates_that_differ_from_plan_to_plan_do_not_rattle_the_tip(planner: Planner, model: Model) -> None:
    controller, now = WholeBodyController(model), known(model, 0.1)
    controller.fly_by(AttitudeLoop(0.1, 0.0))
    plan, asked = planned(planner, controller, now), []
    for k in range(500):
        inputs = plan.inputs.copy()
        inputs[:, 4:] = 0.1 + (0.2 if (k // 3) % 2 else -0.2)  # another plan every third tick
        asked.append(controller.follow(replace(plan, inputs=inputs), 0.0, 0.0, 0.3, 0.0, 0.004).arm_rates)
    later = np.array(asked[250:])
    np.testing.assert_allclose(later.mean(axis=0), 0.1, atol=0.01)
    assert later.std(axis=0).max() < 0.02
    controller.forget()
    assert np.abs(controller.follow(plan, 0.0, 0.0, 0.3, 0.0, 0.0).arm_rates).max() == 0.0


def test_the_rate_that_is_asked_for_grows_in_contact_and_falls_with_the_door(model: Model) -> None:
    controller, now = WholeBodyController(model), known(model, 0.0, touching=True)
    for _ in range(250):
        controller.aim(now, 0.0, 0.004)
    assert controller.opening_rate == pytest.approx(Pace.of(model).acceleration, abs=1e-6)
    controller.aim(known(model, 0.01), 0.0, 0.004)
    assert controller.opening_rate == 0.0


@pytest.mark.parametrize(("distance", "touching"), [(0.002, True), (-0.01, True), (0.3, False), (-0.02, False)])
def test_a_plan_begins_with_the_force_that_is_felt_wherever_the_tip_is_measured(
    model: Model, distance: float, touching: bool
) -> None:
    controller, now = WholeBodyController(model), known(model, distance, touching)
    state, numbers = controller.start(now)
    force = float(contact_forces(controller._numbers, model, state[None])[0])
    assert force == pytest.approx(0.7, abs=1e-6) if touching else force < 0.4
    moved = state[:3] - now.position
    np.testing.assert_allclose(np.cross(moved, model.door.normal(math.pi / 2)), 0.0, atol=1e-12)
    assert numbers["weights.force"] == (0.2 if touching else 0.0)


def test_a_tip_that_friction_drags_sticks_behind_where_it_is(model: Model) -> None:
    controller, now = WholeBodyController(model), known(model, 0.0, touching=True)
    dragged = replace(now, friction_force=np.array([0.2, 0.0]))
    place = tip_on_face(now.tip - now.contact_point, now.normal, now.along, model.door.up)[1]
    assert controller.start(dragged)[1]["contact.stick"][0] < place[0] - 5e-4
    np.testing.assert_allclose(controller.start(now)[1]["contact.stick"], place, atol=1e-9)


def test_tilts_under_way_are_those_of_the_last_dead_time(planner: Planner, model: Model) -> None:
    """One for each step of a plan, its mean, oldest first, in the heading of now; with another loop others."""
    controller = WholeBodyController(model)
    assert controller.under_way(0.0) == []
    for k in range(200):
        attitude = np.array([*tilted(0.0, 1e-3 * k, 0.7), 1.0])
        controller.note(0.004 * k, Command(30.0 + k, attitude, np.full(model.n_arm, 0.1)), 0.3)
    now = 0.004 * 199
    sent = controller.under_way(now)
    assert len(sent) == round(model.attitude_loop.dead_time / planner.settings.time_step) == 3
    for inputs, k in zip(sent, (184, 189, 194), strict=True):
        np.testing.assert_allclose(inputs[1:4], [0.0, 1e-3 * (k + 2), 0.0], atol=1e-9)
        np.testing.assert_allclose(inputs[0], 30.0 + 199)  # thrust has no dead time: what was sent last goes on
        np.testing.assert_allclose(inputs[4:], 0.1)
    controller.fly_by(AttitudeLoop(0.1, 0.0))
    assert controller.under_way(now) == []


def test_thrust_and_joints_wait_for_the_tilt_that_they_were_planned_with(planner: Planner, model: Model) -> None:
    controller, now = WholeBodyController(model), known(model, 0.1)
    plan, dead, tick = planned(planner, controller, now), model.attitude_loop.dead_time, 0.004
    controller.note(-tick, Command(31.0, np.array([0.0, 0.0, 0.3]), np.zeros(model.n_arm)), 0.3)
    thrusts = []
    for k in range(40):
        inputs = plan.inputs.copy()
        inputs[:, 0] = 20.0 + k
        command = controller.follow(replace(plan, inputs=inputs), 0.0, tick * k, 0.3, 0.0, tick)
        controller.note(tick * k, command, 0.3)
        thrusts.append(command.thrust)
    late = round(dead / tick)
    assert thrusts[:late] == [31.0] * late
    assert thrusts[late:] == [20.0 + k for k in range(40 - late)]
    waiting = [float(inputs[0]) for inputs in controller.under_way(tick * 39)]
    np.testing.assert_allclose(waiting, thrusts[-1] + np.array([2.0, 7.0, 12.0]))  # means over five ticks


def test_a_plan_begins_where_what_was_sent_leads(planner: Planner, model: Model) -> None:
    """A tilt under way moves the state by the loop; a level hover that is under way leaves it where it is."""
    controller, now = WholeBodyController(model), known(model, 0.3)
    state, numbers = controller.start(now)
    planner.update_numbers(numbers)
    hover = np.array([model.vehicle.mass * GRAVITY, 0.0, 0.0, 0.0, *np.zeros(model.n_arm)])
    np.testing.assert_allclose(planner.carried(state, [hover] * 3)[:12], state[:12], atol=2e-3)
    tilted_ahead = planner.carried(state, [hover + np.eye(len(hover))[2] * 0.1] * 3)
    assert 0.005 < tilted_ahead[4] < 0.1 and tilted_ahead[10] > 0.1
    np.testing.assert_array_equal(planner.carried(state, []), state)


def test_a_plan_is_carried_on_by_the_numbers_it_is_made_with(planner: Planner, model: Model) -> None:
    """In wind that is known the vehicle drifts; its heading, which a loop of its own holds, turns on as it does."""
    controller, now = WholeBodyController(model), known(model, 0.3)
    state, numbers = controller.start(
        replace(now, wind=np.array([0.0, 1.5, 0.0]), attitude_rates=np.array([0.0, 0.0, 0.2]))
    )
    planner.update_numbers(numbers)
    hover = np.array([model.vehicle.weight, 0.0, 0.0, 0.4, *np.zeros(model.n_arm)])
    later = planner.carried(state, [hover] * 3)
    time = 3 * planner.settings.time_step
    assert later[7] - state[7] == pytest.approx(1.5 / model.vehicle.mass * time, rel=0.05)
    assert later[11] == state[11] and later[5] == pytest.approx(state[5] + 0.2 * time)
