"""Vehicle and leaf of the estimate: the force that keeps tip and face together, by momentum and by differences."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from doorman.estimation.leaf.motion import LeafMotion
from doorman.estimation.leaf.numbers import PLACES, SIZE, leaf_numbers
from doorman.gravity import GRAVITY
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.model import Model
from doorman.scenario import Scenario

H = 1e-5


@pytest.mark.parametrize("task", ["push", "push_left", "drawer", "hatch"])
def test_under_the_force_the_gap_does_not_bend_and_momentum_is_kept(task):
    """The gap bends by nothing over two small steps of the motion, and what the tip loses the leaf gains."""
    model = Model(task)
    numbers = leaf_numbers(model, 1e-3)
    motion = LeafMotion(ArmPattern.of(model.vehicle.arm)[0], model.vehicle.point_names, numbers)
    rng = np.random.default_rng(4)
    x = 0.1 * rng.normal(size=SIZE)
    x[PLACES["joint"]], x[PLACES["log_inertia"]] = model.start_state[3] + 0.2, np.log(model.door.inertia)
    n = len(model.goal_arm)
    u = np.concatenate([[0.5, -0.3, 40.0], 0.1 * rng.normal(size=6), np.zeros(3), model.goal_arm, np.zeros(n)])
    u[6:9] = 0.0  # attitude is held: then the gap depends on the state alone
    force, gap = motion.force_on_moving, motion.gap
    rate = motion.dynamics(force, motion.pushed(force), 1e9)
    arguments = [motion.state, motion.inputs, motion.parameters]
    moved, gap_of, rate_of, force_of = (
        ca.Function(name, arguments, [each])
        for name, each in (("f", rate), ("g", gap), ("r", motion.gap_rate), ("l", force))
    )

    def after(h):
        middle = x + 0.5 * h * moved(x, u, numbers.vector).full()[:, 0]
        return x + h * moved(middle, u, numbers.vector).full()[:, 0]

    def of(function, state):
        return float(function(state, u, numbers.vector))

    ahead, behind = after(H), after(-H)
    assert of(rate_of, x) == pytest.approx((of(gap_of, ahead) - of(gap_of, behind)) / (2 * H), abs=1e-6)
    assert (of(rate_of, ahead) - of(rate_of, behind)) / (2 * H) == pytest.approx(0.0, abs=1e-5)
    found, pressed = moved(x, u, numbers.vector).full()[:, 0], of(force_of, x)
    alone = ca.Function("a", arguments, [motion.acceleration_without, motion.outward])(x, u, numbers.vector)
    without, normal = (each.full()[:, 0] for each in alone)
    assert model.vehicle.mass * (found[3:6] - without) == pytest.approx(pressed * normal, abs=1e-9)


def test_a_leaf_that_hangs_is_pulled_by_its_weight():
    """Without a tip it accelerates as `Door.weight_torque` says."""
    model = Model("hatch")
    numbers = leaf_numbers(model, 1e-3)
    motion = LeafMotion(ArmPattern.of(model.vehicle.arm)[0], model.vehicle.point_names, numbers)
    x, angle = np.zeros(SIZE), model.start_state[3] + 0.3
    x[PLACES["joint"]], x[PLACES["log_inertia"]] = angle, np.log(model.door.inertia)
    u = np.zeros(motion.inputs.numel())
    falls = ca.Function("q", [motion.state, motion.inputs, motion.parameters], [motion.pushed(0)])(x, u, numbers.vector)
    assert abs(model.door.weight_torque(angle)) > 1.0
    assert float(falls) == pytest.approx(-model.door.weight_torque(angle) / model.door.inertia)


def test_an_arm_with_mass_turns_about_its_centre():
    """The body frame's acceleration follows from that of the centre of mass, which only forces change."""
    model = Model(Scenario.load("paper", {"vehicle.urdf": "hexarotor_arm_with_mass"}))
    numbers = leaf_numbers(model, 1e-3)
    motion = LeafMotion(ArmPattern.of(model.vehicle.arm)[0], model.vehicle.point_names, numbers)
    rng, n = np.random.default_rng(5), len(model.goal_arm)
    rates, turning = rng.normal(size=3), rng.normal(size=3)
    u = np.concatenate([[0.0, 0.0, 30.0], np.zeros(3), rates, turning, model.goal_arm, np.zeros(n)])
    arguments = [motion.state, motion.inputs, motion.parameters]
    found = ca.Function("a", arguments, [motion.acceleration_without, motion.center_of_mass])
    base, center = (each.full()[:, 0] for each in found(np.zeros(SIZE), u, numbers.vector))
    of_center = base + np.cross(turning, center) + np.cross(rates, np.cross(rates, center))
    assert np.linalg.norm(center) > 0.01
    assert of_center == pytest.approx([0.0, 0.0, 30.0 / model.vehicle.mass - GRAVITY], abs=1e-9)
