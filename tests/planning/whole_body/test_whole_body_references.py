"""References of one problem, from hover to hover: the same compiled plan approaches, touches, swings, holds and leaves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman import Model, Planner, Scenario
from doorman.control.way_out import in_the_doorway, way_out
from doorman.kinematics.numbers import Numbers
from doorman.planning.hinge import Hinge
from doorman.planning.pace import Pace, rate_to_goal
from doorman.planning.whole_body.contact import depth_of
from doorman.planning.whole_body.numbers import whole_body_numbers
from doorman.planning.whole_body.references import Leaf, references
from doorman.stages import stages

RESISTANCE = 0.6


def at_a_place(place: np.ndarray, posture: np.ndarray) -> dict[str, object]:
    """References and weights of a vehicle that leaves the leaf for a place."""
    nothing = ("place", "approach", "opening", "force", "least_force", "near")
    return {
        "reference.position": place, "reference.heading": [float(posture[2]), 0.0],
        "reference.arm": posture[5:], "reference.arm_slope": np.zeros(4),
        "weights.position": 30.0, "weights.velocity_in_world": 20.0, **{f"weights.{name}": 0.0 for name in nothing},
    }  # fmt: skip


class Flight:
    """Closed loop of one planner on its own model."""

    def __init__(self) -> None:
        self.planner = Planner(Scenario.load("push"))
        self.planner.update_door(friction=RESISTANCE)
        self.model, self.planning = self.planner.model, self.planner.planning
        self.first = self.planning.fitted(self.planner._hinge, self.planner.margin, self.planning.start_state)
        self.x = self.planning.start_state.copy()
        self.plan = None
        self.rows: list[float] = []
        self.anew = 0

    def before_the_leaf(self, away: float, angle: float) -> np.ndarray:
        model = self.model
        place = model.coupling.vehicle_position(
            [0.0, 0.0, model.on_the_way(angle)[2]], angle, model.on_the_way(angle)[5:]
        )
        return np.asarray(place - away * model.door.normal(angle))

    @property
    def force(self) -> float:
        return float(self.planning.normal_forces(self.first, self.x[None], np.zeros((1, 8)))[0])

    def step(self, numbers: dict[str, object]) -> None:
        self.planner.update_numbers(numbers)
        cold = self.plan is None
        self.plan = self.planner.plan(self.x) if cold else self.planner.replan(self.x, 0.02, max_iterations=1)
        if not self.plan.flyable:  # as in flight
            self.anew, self.plan = self.anew + 1, self.planner.plan(self.x)
        assert self.plan.flyable, self.plan.status
        self.x = self.plan.states[1].copy()
        rows = self.model.constraints(self.planning.reduced(self.x, self.plan.inputs[0])[0])[-3:]
        self.rows.append(float(rows.max() if self.between_jambs else rows[0]))

    @property
    def between_jambs(self) -> bool:
        return in_the_doorway(self.model, self.x[:3])

    def go(self, place: np.ndarray, posture: np.ndarray, most: int) -> int:
        for k in range(most):
            self.step(at_a_place(place, posture))
            if np.linalg.norm(self.x[:3] - place) < 0.04 and np.linalg.norm(self.x[6:9]) < 0.05:
                return k
        raise AssertionError(f"still {np.linalg.norm(self.x[:3] - place):.2f} m away")

    def open(self, seconds: float) -> None:
        """Touch, swing and hold: nothing says which."""
        rate, pace, inertia = 0.0, Pace.of(self.model), self.first.one("door.inertia")
        hinge = Hinge(0.0, -RESISTANCE, inertia, 0.0, 0.0)
        for _ in range(round(seconds / 0.02)):
            touching = self.force > 0.25
            rate = (
                min(max(rate, -self.x[13]) + pace.acceleration * 0.02, pace.rate) if touching else max(-self.x[13], 0.0)
            )
            leaf = Leaf(float(self.x[12]), float(self.x[13]), touching, hinge, RESISTANCE)
            self.step(references(self.model, self.first, leaf, rate))


@pytest.fixture(scope="module")
def flight() -> Flight:
    return Flight()


def test_one_problem_flies_from_hover_to_hover(flight: Flight) -> None:
    start, goal = flight.model.start_angle, flight.model.goal_angle
    hover = flight.before_the_leaf(0.6, start)
    flight.x[:3], flight.x[6:12] = hover + [-0.2, 0.15, 0.1], 0.0
    assert flight.go(hover, flight.model.start_state, 500) > 20
    assert flight.x[12] == pytest.approx(start, abs=1e-2) and flight.force < 0.05
    flight.go(flight.before_the_leaf(0.08, start), flight.model.start_state, 500)
    flight.open(25.0)
    assert flight.x[12] == pytest.approx(goal, abs=math.radians(2.0)) and abs(flight.x[13]) < 0.01
    assert flight.force > 0.2, "it holds the door"
    pressed = float(flight.x[12])
    for place in way_out(flight.model, flight.x[:3], goal):
        flight.go(place, flight.model.goal_state, 700)
    assert flight.force < 0.05 and not flight.between_jambs
    assert flight.anew < 20
    assert max(flight.rows) < 0.0, "no rotor touches leaf or jamb on the way"
    assert flight.x[12] > pressed - 0.05, "the leaf is not thrown"


INERTIA, SPEED = 12.0, 0.11
"""Of a heavy leaf, whose hinge stops it within a third of a radian [kg m²], and the rate that it is to have [rad/s]."""


@pytest.fixture(scope="module")
def shipped() -> tuple[Model, Numbers]:
    model = Model("push")
    return model, whole_body_numbers(model)


def swinging(shipped: tuple[Model, Numbers], off: float, rate: float, resistance: float = 0.3) -> dict[str, float]:
    """References of a tip on a heavy leaf, so far before the goal and so fast [rad], [rad/s]."""
    model, numbers = shipped
    hinge = Hinge(resistance, 0.0, INERTIA, 0.0, 0.0)
    return references(model, numbers, Leaf(model.goal_angle + off, -rate, True, hinge, resistance), SPEED)


def wanted(shipped: tuple[Model, Numbers], off: float) -> float:
    """Rate of the reference [rad/s]."""
    slowing = float(swinging(shipped, off, 0.0)["reference.deceleration"])
    return float(rate_to_goal(off, SPEED, slowing, shipped[1].one("reference.settling")))


@pytest.mark.parametrize("off", [0.15, 0.3, 0.5])
def test_the_force_of_a_swing_slows_the_leaf_down_as_the_reference_does(
    shipped: tuple[Model, Numbers], off: float
) -> None:
    rate, later = (wanted(shipped, off - 1e-6 * k) for k in (0, 1))
    force = swinging(shipped, off, rate)["reference.force"]
    gains = (force * shipped[0].coupling.lever_length - 0.3) / INERTIA
    assert gains == pytest.approx((later - rate) / (1e-6 / rate), rel=1e-3)


def test_a_leaf_that_is_too_fast_is_pushed_less_and_one_that_is_slow_is_not(shipped: tuple[Model, Numbers]) -> None:
    goes = wanted(shipped, 0.2)
    slow, right, fast = (swinging(shipped, 0.2, rate) for rate in (0.0, goes, goes + 0.01))
    carries = 0.3 / shipped[0].coupling.lever_length
    assert slow["reference.force"] == pytest.approx(carries)
    assert fast["reference.force"] < right["reference.force"] < carries
    assert 0.0 < fast["reference.least_force"] < right["reference.least_force"] < slow["reference.least_force"]


def test_a_tip_that_pushes_as_wanted_is_not_drawn_deeper_into_the_leaf(shipped: tuple[Model, Numbers]) -> None:
    found = swinging(shipped, 0.5, 0.05)
    assert found["reference.depth"] == pytest.approx(depth_of(found["reference.force"], shipped[1]))


@pytest.mark.parametrize("name", ["pull", "cabinet", "lever_pull"])
def test_what_is_held_is_steered_no_faster_than_the_attitude_follows(name: str) -> None:
    """From an error of the rate, whose weight is W, to the thrust, whose weight is R: sqrt(W/R) times what a newton gains."""
    model = stages(Scenario.load(name))[0]
    numbers, leaf = whole_body_numbers(model), Leaf(model.start_angle, 0.0, True, Hinge.of(model.door), 0.0)
    aims = references(model, numbers, leaf, Pace.of(model).rate)
    lever = model.coupling.lever_length
    gained = lever / (model.door.inertia + model.vehicle.mass * lever**2)
    speed = math.sqrt(aims["weights.opening"] / numbers.one("weights.thrust")) * gained
    assert speed < model.attitude_loop.gain
