"""CasADi's solvers of nonlinear programs: IPOPT, fatrop, and sqpmethod with HPIPM; functions interpreted or generated as C."""

from __future__ import annotations

from typing import Any

import casadi as ca

from suite.peers.shooting import COMPILED
from suite.standard.peers.interface import StandardPeer
from suite.standard.shooting import ProgramSolver, Shooting
from suite.standard.task import Case, StandardTask
from suite.task import Answer

EXPANDED = {"expand": True}
"""CasADi options: one expression of scalars, interpreted."""

IPOPT = {"ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 500, "ipopt.tol": 1e-7}


class ProgramPeer(StandardPeer):
    """A peer with `cold`, the solver that runs to convergence."""

    cold: ProgramSolver

    def prepare_cold(self, case: Case) -> None:
        """The case's guess, multipliers zero."""
        self._active = self.cold
        self._active.guess(case)

    def solve(self) -> None:
        """One call of CasADi's compiled interface."""
        self._active.run()

    def answer(self) -> Answer:
        """Trajectory and CasADi's own verdict."""
        states, inputs = self._active.trajectory()
        stats = self._active.stats
        claim = str(stats.get("unified_return_status") or stats["return_status"])
        success = bool(stats["success"])
        return Answer(
            states, inputs, int(stats["iter_count"]), claim, success or self._active is not self.cold, success
        )  # fmt: skip


class Ipopt(ProgramPeer):
    """IPOPT with exact Hessians and MUMPS, functions interpreted."""

    functions: dict[str, Any] = EXPANDED

    def __init__(self, task: StandardTask) -> None:
        super().__init__(task)
        self.cold = ProgramSolver(Shooting(task), "ipopt", {**IPOPT, **self.functions})


class CompiledIpopt(Ipopt):
    """The same with generated C."""

    functions = COMPILED


class Fatrop(ProgramPeer):
    """fatrop with exact Hessians, structure found by CasADi, functions interpreted."""

    functions: dict[str, Any] = EXPANDED

    def __init__(self, task: StandardTask) -> None:
        super().__init__(task)
        shooting = Shooting(task, initial_rows=True)
        structure = {"structure_detection": "auto", "equality": shooting.equal.tolist()}
        settings = {"print_level": 0, "tol": 1e-7, "max_iter": 500}
        self.cold = ProgramSolver(shooting, "fatrop", {**self.functions, **structure, "fatrop": settings})


class CompiledFatrop(Fatrop):
    """The same with generated C."""

    functions = COMPILED


class SqpHpipm(ProgramPeer):
    """CasADi's sqpmethod with HPIPM in its mode `speed`, missing bounds at 1e3, Gauss-Newton Hessian, generated C.

    Cold: to convergence with CasADi's line search. Replans: one full step.
    """

    def __init__(self, task: StandardTask) -> None:
        super().__init__(task)
        self._shooting = Shooting(task)
        self._hessian = _gauss_newton_hessian(self._shooting)
        self.cold = self._solver({"tol_pr": 1e-6, "tol_du": 1e-6, "max_iter": 200})
        self._one: ProgramSolver | None = None

    def prepare_replan(self, case: Case) -> None:
        """Shift states and inputs; multipliers play no part in a full Gauss-Newton step."""
        following = self.follow(case)
        self._one = self._one or self._solver({"max_iter": 1, "max_iter_ls": 0})
        self._active = self._one
        self._active.guess(following)

    def _solver(self, settings: dict[str, Any]) -> ProgramSolver:
        task, rows = self.task, self._shooting.rows_of_nodes
        stages = {"N": task.horizon, "nx": [task.nx] * (task.horizon + 1), "nu": [task.nu] * task.horizon + [0]}
        quadratic = {**stages, "ng": rows, "print_time": False, "error_on_fail": False, "hpipm": {"mode": "speed"}}
        quiet = {"print_header": False, "print_iteration": False, "print_status": False}
        options = {"qpsol": "hpipm", "qpsol_options": {**quadratic, "inf": 1e3}, "hess_lag": self._hessian}
        return ProgramSolver(self._shooting, "sqpmethod", {**COMPILED, **quiet, **options, **settings})


def _gauss_newton_hessian(shooting: Shooting) -> Any:
    """Of the half squares of the residuals, in the form that sqpmethod asks for."""
    program = shooting.program
    slopes = ca.jacobian(shooting.residuals, program["x"])
    factor, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", program["g"].shape[0])
    inputs = [program["x"], program["p"], factor, multipliers]
    outputs = [factor * (slopes.T @ slopes)]
    return ca.Function("nlp_hess_l", inputs, outputs, ["x", "p", "lam_f", "lam_g"], ["hess_gamma_x_x"])
