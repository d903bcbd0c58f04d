"""State converter: measurements to states and plans to setpoints."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.state_converter import LookAheads, StateConverter
from doorman.model import Model
from doorman.planning.plan import Plan
from doorman.planning.planner import Planner

EXACT = LookAheads(acceleration=0.0, attitude=0.0, position=0.0)


@pytest.fixture(scope="module")
def planned() -> tuple[Model, Plan]:
    """A plan of the paper's task, and its model."""
    planner = Planner("paper")
    return planner.model, planner.plan(planner.start_state)


def test_setpoint_at_a_node_is_the_plan(planned) -> None:
    model, plan = planned
    converter = StateConverter(model, EXACT)
    for node in (0, 7, 30):
        state, inputs = plan.states[node], plan.inputs[node]
        setpoint = converter.setpoint(plan, node * plan.time_step + 1e-12, state[5:])
        motion = model.coupling.vehicle_motion(state, inputs[1:4], inputs[4:])
        np.testing.assert_allclose(setpoint.position, motion.position, atol=1e-9)
        np.testing.assert_allclose(setpoint.velocity, motion.velocity, atol=1e-9)
        assert setpoint.yaw == pytest.approx(state[2])
        seen = setpoint.position, setpoint.velocity, state[:3], inputs[1:4], state[5:], inputs[4:]
        np.testing.assert_allclose(model.coupling.door_state(*seen), state[3:5], atol=1e-9)


def test_planned_force_moves_the_door_as_planned(planned) -> None:
    model, plan = planned
    setpoint = StateConverter(model, EXACT).setpoint(plan, 0.1, plan.states[5, 5:])
    normal = setpoint.normal
    acceleration = -model.coupling.distance_from_hinge * float(normal @ setpoint.force) / model.door.inertia
    planned_acceleration = (plan.states[7, 4] - plan.states[3, 4]) / (4 * plan.time_step)
    assert acceleration == pytest.approx(planned_acceleration, abs=0.05)
    assert setpoint.force[2] == 0.0


def test_after_its_end_a_plan_rests(planned) -> None:
    model, plan = planned
    converter = StateConverter(model, EXACT)
    for late in (1.0, 1.5, 100.0):
        setpoint = converter.setpoint(plan, late, plan.states[50, 5:])
        np.testing.assert_allclose(setpoint.velocity, 0.0, atol=1e-12)
        np.testing.assert_allclose(setpoint.force, 0.0, atol=1e-12)
        np.testing.assert_allclose(setpoint.arm_rates, 0.0, atol=1e-12)
    assert np.abs(converter.setpoint(plan, 0.99, plan.states[50, 5:]).acceleration).max() < 3.0


def test_joint_rates_lead_to_the_plan_within_the_servos_limits(planned) -> None:
    model, plan = planned
    converter = StateConverter(model, EXACT)
    ahead = plan.states[5, 5:]  # LookAheads.arm is 0.1 s: five steps
    rates = converter.setpoint(plan, 0.0, ahead - 0.01).arm_rates
    np.testing.assert_allclose(rates, 0.1, atol=1e-6)
    assert converter.setpoint(plan, 0.0, ahead + 2.0).arm_rates == pytest.approx(-model.vehicle.rate_limits)
