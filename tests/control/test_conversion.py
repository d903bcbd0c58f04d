"""State converter: measurements to states and plans to setpoints."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.state_converter import LookAheads, StateConverter
from doorman.model import Model
from doorman.planning.plan import Plan
from doorman.planning.planner import Planner
from doorman.planning.planning_model import planning_model
from doorman.scenario import Scenario

EXACT = LookAheads(acceleration=0.0, attitude=0.0, position=0.0)


@pytest.fixture(scope="module", params=["quasi_static", pytest.param("lagrangian", marks=pytest.mark.slow)])
def planned(request: pytest.FixtureRequest) -> tuple[Model, Plan]:
    """A plan of the paper's task with each of the planner's models, and the scenario's model, without look-ahead."""
    planner = Planner(Scenario.load("paper", {"planner.model": request.param}))
    return planner.model, planner.plan(planning_model(planner.model).start_state)


def reduced(model: Model, plan: Plan, node: int) -> tuple[np.ndarray, np.ndarray]:
    """[Φ, α, α̇, H] and [f_t, Ω, Ḣ_d] of a node."""
    return planning_model(model).reduced(plan.states[node], plan.inputs[min(node, len(plan.inputs) - 1)])


def test_setpoint_at_a_node_is_the_plan(planned) -> None:
    model, plan = planned
    converter = StateConverter(model, EXACT)
    for node in (0, 7, 30):
        state, inputs = reduced(model, plan, node)
        setpoint = converter.setpoint(plan, node * plan.time_step + 1e-12, state[5:])
        motion = model.coupling.vehicle_motion(state, inputs[1:4], inputs[4:])
        np.testing.assert_allclose(setpoint.position, motion.position, atol=1e-9)
        np.testing.assert_allclose(setpoint.velocity, motion.velocity, atol=1e-9)
        assert setpoint.yaw == pytest.approx(state[2])
        seen = setpoint.position, setpoint.velocity, state[:3], inputs[1:4], state[5:], inputs[4:]
        np.testing.assert_allclose(model.coupling.door_state(*seen), state[3:5], atol=1e-9)


def test_planned_force_moves_the_door_as_planned(planned) -> None:
    model, plan = planned
    setpoint = StateConverter(model, EXACT).setpoint(plan, 0.1, reduced(model, plan, 5)[0][5:])
    normal = setpoint.normal
    acceleration = -model.coupling.distance_from_hinge * float(normal @ setpoint.force) / model.door.inertia
    after, before = (reduced(model, plan, node)[0][4] for node in (7, 3))
    planned_acceleration = (after - before) / (4 * plan.time_step)
    assert acceleration == pytest.approx(planned_acceleration, abs=0.05)
    assert setpoint.force[2] == 0.0


def test_after_its_end_a_plan_rests(planned) -> None:
    model, plan = planned
    converter = StateConverter(model, EXACT)
    for late in (1.0, 1.5, 100.0):
        setpoint = converter.setpoint(plan, late, reduced(model, plan, 50)[0][5:])
        np.testing.assert_allclose(setpoint.velocity, 0.0, atol=1e-12)
        np.testing.assert_allclose(setpoint.force, 0.0, atol=1e-12)
        np.testing.assert_allclose(setpoint.arm_rates, 0.0, atol=1e-12)
    assert np.abs(converter.setpoint(plan, 0.99, reduced(model, plan, 50)[0][5:]).acceleration).max() < 3.0


def test_joint_rates_lead_to_the_plan_within_the_servos_limits(planned) -> None:
    model, plan = planned
    converter = StateConverter(model, EXACT)
    ahead = reduced(model, plan, 5)[0][5:]  # LookAheads.arm is 0.1 s: five steps
    rates = converter.setpoint(plan, 0.0, ahead - 0.01).arm_rates
    np.testing.assert_allclose(rates, 0.1, atol=1e-6)
    assert converter.setpoint(plan, 0.0, ahead + 2.0).arm_rates == pytest.approx(-model.vehicle.rate_limits)
