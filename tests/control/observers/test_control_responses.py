"""Responses in time: the observer against its transfer function, and feed-forward against the plan it comes from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from doorman import Model, Planner, Scenario
from doorman.control.observers.disturbance_observer import DisturbanceObserver
from doorman.control.state_converter import LookAheads, StateConverter

STEP = 0.002


@pytest.mark.parametrize("damping", [0.6, 1.4, 2.0, 3.0])
def test_vehicle_observer_has_the_poles_of_q(damping: float) -> None:
    """A mass held in place while F = −1 N acts: δ̂ is the step response of 1/((τs)² + a₁τs + 1), by its poles."""
    rate, held = 3.0, np.array([0.4, -1.0, 2.0])
    observer = DisturbanceObserver(2.0, rate, damping)
    found = [observer.update(held, np.array([-1.0, 0.0, 0.0]), STEP)[0] for _ in range(2500)]
    time = STEP * np.arange(1, 2501)
    poles = rate * np.roots([1.0, damping, 1.0]).astype(complex)
    if abs(poles[0] - poles[1]) < 1e-6:
        expected = 1.0 - (1.0 + rate * time) * np.exp(-rate * time)
    else:
        first, second = poles
        rising = (first * np.exp(second * time) - second * np.exp(first * time)) / (second - first)
        expected = 1.0 + rising.real
    np.testing.assert_allclose(found, expected, atol=0.01)
    assert np.abs(observer.estimate[1:]).max() == 0.0


def test_a_mass_that_flies_freely_shows_what_moves_it_as_one_that_is_held() -> None:
    """The force cancels the estimate: Q of the disturbance alone is left."""
    mass, rate, observer = 3.0, 5.0, DisturbanceObserver(3.0, 5.0)
    position, velocity, found = np.array([1.0, -2.0, 0.5]), np.zeros(3), [np.zeros(3)]
    for _ in range(1000):
        found.append(observer.update(position, -found[-1], STEP))
        velocity = velocity + STEP * (np.array([1.0, 0.0, -2.0]) - found[-1]) / mass
        position = position + STEP * velocity
    time = STEP * np.arange(1001)
    expected = 1.0 - (1.0 + rate * time) * np.exp(-rate * time)
    np.testing.assert_allclose(found, np.outer(expected, [1.0, 0.0, -2.0]), atol=0.03)


@pytest.mark.parametrize("step", [0.005, 0.1, 0.2])
def test_the_bound_is_left_as_it_was_reached_however_long_the_ticks(step: float) -> None:
    """What it gathered at the bound does not have to unwind."""
    load, observer = np.array([12.0, 0.0, 0.0]), DisturbanceObserver(3.0, 3.0, limit=10.0)
    fixed, found = np.zeros(3), []
    for _ in range(round(10.0 / step)):  # it hovers against the load
        found.append(observer.update(fixed, -load, step)[0])
    assert max(found) == 10.0 and found[-1] == 10.0
    for _ in range(round(3.0 / step)):
        found.append(observer.update(fixed, np.zeros(3), step)[0])
    assert min(found) > -1.0
    assert abs(found[-1]) < 0.1


@pytest.mark.parametrize("overrides", [{}, {"planner.time_step": 0.1, "planner.horizon_steps": 10}])
@pytest.mark.parametrize("time", [0.0, 0.05, 0.3])
def test_acceleration_fed_forward_is_that_of_the_planned_motion(overrides: dict, time: float) -> None:
    """Also at the plan's beginning, where there is nothing before, and on coarse plans."""
    planner = Planner(Scenario.load("paper", overrides))
    model, plan = planner.model, planner.plan(planner.model.start_state)
    at_once = replace(LookAheads.of(model.attitude_loop), acceleration=0.0)
    converter, dt, last = StateConverter(model, at_once), plan.time_step, len(plan.inputs)

    def velocity(at: float) -> np.ndarray:
        node = min(int(at / dt), last - 1)
        part = at / dt - node
        x = (1.0 - part) * plan.states[node] + part * plan.states[node + 1]
        return model.coupling.vehicle_motion(x, plan.inputs[node, 1:4], plan.inputs[node, 4:]).velocity

    before, after = max(time - 2.0 * dt, 0.0), time + 2.0 * dt
    expected = (velocity(after) - velocity(before)) / (after - before)
    found = converter.setpoint(plan, time, plan.states[0, 5:]).acceleration
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert np.abs(found).max() > 0.05


@pytest.mark.parametrize("kind", ["position", "attitude", "arm"])
def test_each_part_is_taken_as_much_later_as_its_loop_lags(model: Model, kind: str) -> None:
    planner = Planner(model)
    plan, ahead = planner.plan(model.start_state), LookAheads.of(model.attitude_loop)
    converter, now = StateConverter(model), 0.1
    found = converter.setpoint(plan, now, plan.states[5, 5:])
    node = round((now + getattr(ahead, kind)) / plan.time_step)
    state, inputs = plan.states[node], plan.inputs[node]
    if kind == "position":
        motion = model.coupling.vehicle_motion(state, inputs[1:4], inputs[4:])
        np.testing.assert_allclose(found.position, motion.position, atol=1e-9)
        np.testing.assert_allclose(found.velocity, motion.velocity, atol=1e-2)
    elif kind == "attitude":
        assert found.yaw == pytest.approx(state[2], abs=1e-9)
        np.testing.assert_allclose(found.force, converter.planned_force(state, inputs[0]), atol=0.2)
    else:
        rates = (state[5:] - plan.states[5, 5:]) / ahead.arm
        np.testing.assert_allclose(found.arm_rates, rates, atol=1e-9)
