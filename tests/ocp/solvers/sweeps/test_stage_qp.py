"""ProxQP behind one node's program: solutions, contradictions, numbers that are none, warm starts."""

from __future__ import annotations

import numpy as np
import pytest
from double_integrator import Variant

from doorman.ocp.solvers.memory.parts import Program
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.stage_qp import StageQpSolver


@pytest.fixture
def program(rng: np.random.Generator) -> Program:
    """A program of a cart's node with random rows that leave room."""
    program = Workspace.plain(Variant(force=(-1.0, 1.0)).problem()).program
    factor = rng.normal(size=program.hessian.shape)
    program.hessian[:] = factor @ factor.T + np.eye(len(factor))
    program.gradient[:] = rng.normal(size=program.gradient.shape)
    program.jacobian[:] = rng.normal(size=program.jacobian.shape)
    program.constraints[:] = -0.1
    return program


def solver_of(program: Program) -> StageQpSolver:
    return StageQpSolver(len(program.gradient), len(program.constraints))


def test_the_solution_satisfies_the_conditions(program: Program) -> None:
    solver = solver_of(program)
    for scale in (1.0, 3.0, 0.3):  # the second and third start from the solution before
        program.gradient[:] *= scale
        assert solver.solve(program)
        rows = program.constraints + program.jacobian @ program.step
        assert rows.max() <= 1e-8 and program.multipliers.min() >= 0.0
        assert np.abs(program.multipliers * rows).max() < 1e-7
        stationarity = program.hessian @ program.step + program.gradient + program.jacobian.T @ program.multipliers
        assert np.abs(stationarity).max() < 1e-8


def test_every_solver_finds_the_same_bits(program: Program, rng: np.random.Generator) -> None:
    """ProxQP's own last bits depend on where its memory lies."""
    n, rows, memory = 8, 30, []
    factor, jacobian = rng.normal(size=(n, n)), rng.normal(size=(rows, n))
    found = set()
    for _ in range(12):
        larger = program._replace(
            hessian=factor @ factor.T + np.eye(n), gradient=10.0 * np.arange(n) - 30.0, jacobian=jacobian.copy(),
            constraints=np.full(rows, -0.3), step=np.zeros(n), multipliers=np.zeros(rows),
        )  # fmt: skip
        memory.append(np.zeros(rng.integers(1, 200)))
        solver = solver_of(larger)
        assert solver.solve(larger)
        assert np.count_nonzero(larger.multipliers) >= 3
        found.add(larger.step.tobytes() + larger.multipliers.tobytes())
    assert len(found) == 1


def test_a_row_without_end_does_not_bind(program: Program) -> None:
    program.constraints[0] = -1e300
    assert solver_of(program).solve(program)
    assert program.multipliers[0] == pytest.approx(0.0, abs=1e-8)


def test_contradictions_are_found_and_do_not_spoil_the_next_program(program: Program) -> None:
    solver = solver_of(program)
    row = program.jacobian[1].copy()
    program.jacobian[1], program.constraints[:2] = -program.jacobian[0], 1.0
    assert not solver.solve(program)
    program.jacobian[1], program.constraints[:2] = row, -0.1
    assert solver.solve(program)


@pytest.mark.parametrize("name", ["hessian", "gradient", "jacobian", "constraints"])
def test_numbers_that_are_none_are_refused_at_once(program: Program, name: str) -> None:
    getattr(program, name)[0] = np.nan
    assert not solver_of(program).solve(program)
