"""The whole-body problem on leaves that do not turn about a vertical: weight, friction, and what stands beside them."""

from __future__ import annotations

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest
from task_in_numbers import TaskInNumbers

from doorman.gravity import GRAVITY
from doorman.model import Model
from doorman.planning.limits import largest_push
from doorman.planning.whole_body.contact import tip_on_face
from doorman.planning.whole_body.rows import constraints
from doorman.scenario import Scenario

FLAP = {"contact.kind": "push", "contact.frame": None, "contact.side": "pull", "contact.distance_from_hinge": 0.5,
        "start.opening": 0.5, "goal.opening": 0.0}  # fmt: skip
GATE = {"contact.kind": "push", "start.opening": 0.0}
WIDE = {"goal.opening": 1.9}
TASKS: dict[str, tuple[str, dict[str, Any]]] = {
    "drawer": ("drawer_close", {}), "flap": ("hatch", FLAP), "gate": ("sliding", GATE), "wide door": ("push", WIDE),
}  # fmt: skip


def on_leaf(name: str) -> TaskInNumbers:
    source, keys = TASKS[name]
    return TaskInNumbers(Model(Scenario.load(f"shipped:{source}", keys)))


@pytest.fixture(scope="module", params=list(TASKS))
def leaf(request: pytest.FixtureRequest) -> TaskInNumbers:
    return on_leaf(request.param)


def test_a_push_lowers_the_leafs_angle(leaf: TaskInNumbers) -> None:
    """Whatever the joint: the tip's force is the spring's along the normal, and makes its lever's torque."""
    model, angle = leaf.model, leaf.model.travel.start
    quiet = leaf.numbers.replaced({"contact.friction": 0.0, "contact.slip_damping": 0.0, "door.friction": 0.0})
    change = leaf.function(ca.vertcat(leaf.task.rates_of_change, leaf.task.normal_force))
    pressed, free = change(leaf.at_the_leaf(0.002, angle), quiet), change(leaf.at_the_leaf(-50.0, angle), quiet)
    force = pressed[7]
    np.testing.assert_allclose(
        model.vehicle.mass * (free[:3] - pressed[:3]), force * model.door.normal(angle), atol=1e-3
    )
    lever = model.coupling.lever_length
    assert force > 2.0
    assert model.door.inertia * (pressed[6] - free[6]) == pytest.approx(-force * lever, rel=1e-3)


def test_a_leaf_that_nobody_touches_moves_by_its_weight(leaf: TaskInNumbers) -> None:
    model, change = leaf.model, leaf.function(leaf.task.rates_of_change[6])
    quiet = leaf.numbers.replaced({"door.friction": 0.0})
    for angle in np.linspace(model.travel.start, model.travel.goal, 3):
        found = float(change(leaf.at_the_leaf(-50.0, float(angle)), quiet))
        assert found == pytest.approx(-model.door.weight_torque(float(angle)) / model.door.inertia, abs=2e-4)


def test_rows_beside_the_leaf_are_the_models_own(leaf: TaskInNumbers) -> None:
    """For a level disc, whose tip is on the contact point."""
    model, points = leaf.model, len(leaf.model.vehicle.point_names)
    margin, rows = leaf.numbers.one("limits.margin"), constraints(leaf.task, leaf.model.kinds)
    value = leaf.function(ca.vertcat(*(row.expression for row in rows)))
    assert len(rows) == model.n_constraints + 1
    generator = np.random.default_rng(3)
    for share in (0.0, 0.4, 1.0):
        angle = model.travel.start + share * (model.travel.goal - model.travel.start)
        attitude = np.array([0.0, 0.0, model.on_the_way(angle)[2] + generator.uniform(-0.2, 0.2)])
        x = leaf.at_the_leaf(0.0, angle, attitude)
        own = model.constraints(np.concatenate([attitude, [angle, 0.0], x[14:]]))
        own[:points] += margin
        np.testing.assert_allclose(value(x, leaf.numbers)[:-1], own, atol=1e-5)


def test_the_place_of_the_tip_is_on_two_directions_of_the_face(leaf: TaskInNumbers) -> None:
    model, angle = leaf.model, leaf.model.travel.start
    place, x = leaf.function(leaf.task.place), leaf.at_the_leaf(0.001, leaf.model.travel.start)
    along, up, normal = model.door.leaf_direction(angle), model.door.up, model.door.normal(angle)
    x[:3] += 0.02 * along - 0.03 * up + 0.01 * normal
    np.testing.assert_allclose(place(x, leaf.numbers), [0.02, -0.03], atol=1e-9)
    tip = x[:3] + model.coupling.tips(x[None, 3:6], x[None, 14:])[0]
    depth, found = tip_on_face(tip - model.coupling.contact_point(angle), normal, along, up)
    assert depth == pytest.approx(0.011, abs=1e-9)
    np.testing.assert_allclose(found, [0.02, -0.03], atol=1e-9)


def test_a_light_leaf_stays_where_its_friction_holds_it() -> None:
    """A flap of 0.2 kg m²: friction by the rate at the beginning of a step would throw it to and fro."""
    flap = on_leaf("flap")
    angle, step = flap.model.travel.start, flap.function(flap.task.next_state)
    weight = abs(flap.model.door.weight_torque(angle))
    assert weight > 1.5
    held = flap.numbers.replaced({"door.friction": 1.1 * weight, "door.sticks": 1.0})
    x = flap.at_the_leaf(-50.0, angle)
    for _ in range(50):
        x = step(x, held)
    assert abs(x[12] - angle) < 2e-3
    loose = held.replaced({"door.friction": 0.6 * weight})
    fallen = step(flap.at_the_leaf(-50.0, angle), loose)
    time_step, inertia = flap.numbers.one("plan.time_step"), flap.model.door.inertia
    assert abs(fallen[13]) == pytest.approx(0.4 * weight * time_step / inertia, rel=0.02)
    slow, rates = flap.at_the_leaf(-50.0, angle, rate=-0.3), []
    for _ in range(10):
        slow = step(slow, held)
        rates.append(slow[13])
    assert max(rates) <= 1e-6, "friction stops the leaf, and does not drive it back"


@pytest.mark.parametrize("tilt", [0.15, 0.3, 0.6])
def test_the_largest_push_is_that_of_every_tilt_and_thrust(tilt: float) -> None:
    """Against a search over all of them, for a flap whose normal looks down, and the same one lifted."""
    for keys in (FLAP, {"goal.opening": 1.0}):
        model = Model(Scenario.load("shipped:hatch", keys | {"control.max_push": 100.0}))
        weight, most = model.vehicle.mass * GRAVITY, model.vehicle.max_thrust
        for angle in (model.travel.start, model.travel.goal):
            way = -model.travel.sense * model.door.normal(angle)
            forces = np.linspace(0.0, 60.0, 60001)
            thrust = forces[:, None] * way + np.array([0.0, 0.0, weight])
            size = np.linalg.norm(thrust, axis=1)
            allowed = (size <= most) & (thrust[:, 2] >= math.cos(tilt) * size)
            largest = forces[int(np.argmin(allowed)) - 1]
            assert largest_push(model, tilt, angle) == pytest.approx(largest, abs=2e-3)
