"""The standard problems themselves, without doorman's solvers: equations, starts and guesses."""

from __future__ import annotations

import sys
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from standard_problems import NAMES, cases_of, example, ipopt_of, task

FILES = Path(__file__).parents[3] / "examples" / "ocp"


def test_every_file_is_a_problem_that_the_benchmarks_know() -> None:
    assert sorted(path.stem for path in FILES.glob("*.py")) == sorted([*NAMES, "example"])


@pytest.mark.parametrize("name", NAMES)
def test_starts_are_seeded_and_guesses_begin_there(name: str) -> None:
    this = example(name)
    assert np.array_equal(this.starts(5), this.starts(5))
    assert not np.array_equal(this.starts(5, seed=1), this.starts(5, seed=2))
    for case in cases_of(name, 3):
        assert case.states.shape == (this.horizon + 1, len(this.start)) and np.array_equal(case.states[0], case.start)
        assert case.inputs.shape == (this.horizon, task(name).nu)
        assert case.node_parameters.shape == (this.horizon + 1, task(name).nq)


@pytest.mark.parametrize("name", ["cart_pole", "two_link_arm", "race_car"])
def test_ipopt_solves_them(name: str) -> None:
    verdict, success = ipopt_of(name)(cases_of(name, 1)[0])
    assert success and verdict.holds


def power(name: str, energy: ca.SX, given: ca.SX) -> ca.SX:
    """Rate of an energy less the power that is given; zero where the dynamics are right."""
    this = example(name)
    return ca.jacobian(energy, this.model.x) @ this.rate - given


@pytest.mark.parametrize("name", ["cart_pole", "two_link_arm", "chain", "quadrotor"])
def test_energy_changes_by_the_power_of_the_inputs(name: str) -> None:
    this = example(name)
    x, u = this.model.x, this.model.u
    module = sys.modules[f"standard_{name}"]
    if name == "cart_pole":
        speed = [x[2] - module.LENGTH * ca.cos(x[1]) * x[3], -module.LENGTH * ca.sin(x[1]) * x[3]]
        energy = 0.5 * module.CART * x[2] ** 2 + 0.5 * module.BOB * ca.sumsqr(ca.vertcat(*speed))
        energy += module.BOB * module.GRAVITY * module.LENGTH * ca.cos(x[1])
        given = u * x[2]
    elif name == "two_link_arm":
        energy = 0.5 * ca.dot(x[2:], module.inertia @ x[2:])
        given = ca.dot(u - module.FRICTION @ x[2:], x[2:])
    elif name == "chain":
        stretched = [ca.norm_2(spring) - module.LENGTH for spring in module.springs]
        energy = 0.5 * module.MASS * ca.sumsqr(module.velocities) + 0.5 * module.SPRING * ca.sumsqr(
            ca.vertcat(*stretched)
        )
        energy += module.MASS * 9.81 * sum(place[2] for place in module.places[:-1])
        given = ca.dot(module.forces[-1], u)
    else:
        energy = 0.5 * module.MASS * ca.sumsqr(x[3:6]) + module.MASS * 9.81 * x[2]
        energy += 0.5 * ca.dot(ca.DM(module.INERTIA), x[9:] ** 2)
        given = ca.sum1(u) * ca.dot(module.thrust_axis, x[3:6]) + ca.dot(module.torque, x[9:])
    residual = ca.Function("residual", [x, u], [power(name, energy, given)])
    random = np.random.default_rng(3)
    for _ in range(5):
        state, inputs = (
            np.array(this.start) + random.uniform(-0.5, 0.5, x.numel()),
            random.uniform(-1.0, 1.0, u.numel()),
        )
        assert abs(float(residual(state, inputs))) < 1e-9


def test_the_track_closes() -> None:
    example("race_car")
    car = sys.modules["standard_race_car"]
    s = (np.arange(20_000) + 0.5) * car.LENGTH / 20_000
    direction = np.cumsum(car.curvature(s, np.cos)) * car.LENGTH / 20_000
    assert direction[-1] == pytest.approx(2 * np.pi)
    assert abs(np.exp(1j * direction).sum()) * car.LENGTH / 20_000 < 1e-3
    assert 0.12 * np.abs(car.curvature(s, np.cos)).max() < 1.0  # the Frenet frame is regular on the track
