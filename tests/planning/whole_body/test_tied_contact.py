"""A tip that grips: the contact is a spring in all directions, by a number of the same problem."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from task_in_numbers import TaskInNumbers

from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.planning.whole_body.contact import contact_forces
from doorman.planning.whole_body.numbers import whole_body_numbers, yaw_inertia
from doorman.scenario import Scenario

Array = np.ndarray


@pytest.fixture(scope="module")
def tied() -> TaskInNumbers:
    model = Model("push")
    quiet = {"contact.friction": 0.0, "contact.slip_damping": 0.0, "contact.damping": 0.0, "door.friction": 0.0}
    return TaskInNumbers(model, whole_body_numbers(model, replace(model.contact, tied=1.0)).replaced(quiet))


def test_a_grip_is_a_spring_on_vehicle_heading_and_leaf(tied: TaskInNumbers) -> None:
    """One potential, three equations of motion, whichever way the tip is off: pulled back, beside and below."""
    task, numbers, model = tied.task, tied.numbers, tied.model
    x = tied.at_the_leaf(0.0, off=np.array([-0.004, 0.002, -0.003]))

    def energy(state: Array) -> float:
        off = tied.function(task.off_place)(state)
        return 0.5 * numbers.one("contact.stiffness") * float(off @ off)

    change = tied.function(task.rates_of_change)(x)
    free = tied.function(task.rates_of_change)(x, numbers.replaced({"contact.stiffness": 0.0}))
    masses = {
        0: model.vehicle.mass,
        1: model.vehicle.mass,
        2: model.vehicle.mass,
        5: yaw_inertia(model),
        12: model.door.inertia,
    }
    for index, mass in masses.items():
        step = np.zeros(len(x))
        step[index] = 1e-6
        slope = (energy(x + step) - energy(x - step)) / 2e-6
        row = {5: 5, 12: 6}.get(index, index)
        assert mass * (change - free)[row] == pytest.approx(-slope, abs=2e-3), index


@pytest.mark.parametrize("off", [0.003, -0.003])
def test_the_share_of_the_grip_joins_both_contacts(tied: TaskInNumbers, off: float) -> None:
    x = tied.at_the_leaf(off)
    forces = [
        float(tied.function(tied.task.normal_force)(x, tied.numbers.replaced({"contact.tied": g}))) for g in (0, 0.5, 1)
    ]
    assert forces[1] == pytest.approx(0.5 * (forces[0] + forces[2]))
    assert forces[0] > 0.0 and math.copysign(1.0, forces[2]) == math.copysign(1.0, off)
    for share, force in zip((0.0, 1.0), (forces[0], forces[2]), strict=True):
        numbers = tied.numbers.replaced({"contact.tied": share})
        assert contact_forces(numbers, tied.model, x[None])[0] == pytest.approx(force)


@pytest.mark.parametrize(
    "scenario", ["pull", *(pytest.param(name, marks=pytest.mark.slow) for name in ("hatch", "drawer"))]
)
def test_a_stiff_gripper_is_as_stiff_as_a_step_resolves(scenario: str) -> None:
    """A free tip that is off its place comes back to it in the plan's own steps."""
    planner = Planner(Scenario.load(scenario))
    motion, x = planner.planning.swing(0.0), planner.start_state.copy()
    x[:3] += [0.002, 0.002, 0.002]
    inputs, at = planner.planning.hover_input, planner.start_state[:3]
    for _ in range(100):
        x = motion(x, inputs)
    assert np.isfinite(x).all() and np.abs(x[6:9]).max() < 0.2 and np.linalg.norm(x[:3] - at) < 0.1


@pytest.mark.parametrize("begins", [-20.0, 6.0])
def test_a_held_leaf_comes_to_the_goal_from_both_sides(begins: float) -> None:
    """On the plan's own model, and pulled as well as pushed: a tip that only pushes never brings a leaf back."""
    planner = Planner(Scenario.load("pull"))
    model, x = planner.model, planner.start_state.copy()
    reduced = np.array(model.on_the_way(model.goal_angle + math.radians(min(begins, 0.0))))
    reduced[3] = model.goal_angle + math.radians(begins)
    x, forces = planner.planning.state(reduced, np.zeros(3)), []
    motion = planner.planning.swing(0.0)
    plan = planner.plan(x)
    for _ in range(350):
        x = motion(x, plan.inputs[0])
        plan = planner.replan(x, 0.02, max_iterations=1)
        assert plan.flyable
        forces.append(float(planner.normal_forces(plan)[0]))
    assert x[12] == pytest.approx(model.goal_angle, abs=math.radians(0.5)) and abs(x[13]) < 0.02
    assert min(forces) < -0.3 and max(forces) > 0.3
