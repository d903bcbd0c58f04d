"""The careful phase by itself, on the pendulum: what it leaves in the workspace, and when it stops."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pendulum import pendulum
from toy import Toy

from doorman.numba_types.handles import Handle, held
from doorman.ocp.solvers.iterations.augmented_lagrangian import CONVERGED, OUT_OF_ITERATIONS
from doorman.ocp.solvers.iterations.careful import FIRST_PENALTY, iterate_carefully, squared
from doorman.ocp.solvers.iterations.guess import roll_blindly
from doorman.ocp.solvers.iterations.nominal import linearize, measure_nominal, nominal_cost
from doorman.ocp.solvers.memory.result import RESULT
from doorman.ocp.solvers.memory.workspace import Workspace

FEASIBILITY = 1e-6

pytestmark = pytest.mark.slow


class Careful:
    """Workspace of a toy with a guess in it."""

    def __init__(self, toy: Toy) -> None:
        self.toy, self.work = toy, Workspace.of(toy.problem)
        self.memory, self.model = held(self.work), Handle(toy.problem.model)
        self.work.nominal.states[:] = toy.start
        self.work.nominal.inputs[:] = toy.problem.cost.input_goal
        roll_blindly(self.model, self.memory, 0)

    def iterate(self, iterations: int, penalty: float = FIRST_PENALTY, deadline: float = math.inf) -> int:
        code = iterate_carefully(self.model, self.memory, penalty, FEASIBILITY, iterations, deadline)
        linearize(self.model, self.memory)
        measure_nominal(self.memory)
        return int(code)

    @property
    def cost(self) -> float:
        return float(nominal_cost(self.model, self.memory))


def test_it_converges_from_rest() -> None:
    """Its end satisfies dynamics and constraints without any rollout after it, and costs what IPOPT's does."""
    careful = Careful(pendulum())
    result, reference = careful.work.result, careful.toy.reference()
    assert careful.iterate(100) == CONVERGED
    assert result[RESULT.ITERATIONS] <= 50
    assert result[RESULT.DEFECT] <= FEASIBILITY and result[RESULT.VIOLATION] <= FEASIBILITY
    nominal = careful.work.nominal
    assert careful.toy.violation(nominal.states, nominal.inputs) <= FEASIBILITY
    assert careful.cost == pytest.approx(reference.cost, rel=1e-6)


def test_from_its_own_end_it_has_nothing_left_to_do() -> None:
    careful = Careful(pendulum())
    careful.iterate(100)
    before, states = careful.cost, careful.work.nominal.states.copy()
    assert careful.iterate(100, penalty=1e3) == CONVERGED
    assert careful.work.result[RESULT.ITERATIONS] <= 3
    assert careful.cost == pytest.approx(before, rel=1e-7)
    np.testing.assert_allclose(careful.work.nominal.states, states, atol=1e-3)


def test_rolled_steps_leave_no_defects_on_the_way() -> None:
    """From a trajectory every iterate is one, so that it may end after any number of iterations."""
    for iterations in (1, 2, 5, 12):
        careful = Careful(pendulum())
        assert careful.iterate(iterations) == OUT_OF_ITERATIONS
        assert careful.work.result[RESULT.ITERATIONS] == iterations
        assert careful.work.result[RESULT.DEFECT] <= 1e-12


def test_a_guess_that_is_no_trajectory_will_do() -> None:
    careful = Careful(pendulum())
    angles = np.linspace(0.0, np.pi, len(careful.work.nominal.states))
    careful.work.nominal.states[:, 0], careful.work.nominal.states[:, 1] = angles, 0.5
    careful.work.nominal.states[0] = careful.toy.start
    assert careful.iterate(150) == CONVERGED
    assert careful.cost == pytest.approx(careful.toy.reference().cost, rel=1e-6)


def test_no_iteration_begins_after_the_deadline() -> None:
    careful = Careful(pendulum())
    assert careful.iterate(100, deadline=0.0) == OUT_OF_ITERATIONS
    assert careful.work.result[RESULT.ITERATIONS] == 1


def test_a_row_without_a_value_shows_in_the_merit() -> None:
    assert np.isnan(squared(0.0, np.nan, 10.0, 0.0)) and np.isnan(squared(1.0, np.nan, 10.0, 0.0))
    assert squared(1.0, -1.0, 10.0, 0.0) == -1.0
    assert squared(1.0, 0.1, 10.0, 0.0) == pytest.approx(3.0)
    assert squared(1.0, -1.0, 10.0, -np.inf) == pytest.approx(80.0)  # an equality's multiplier has either sign
