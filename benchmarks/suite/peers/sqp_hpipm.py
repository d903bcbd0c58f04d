"""CasADi's sqpmethod with HPIPM for its quadratic programs, generated C."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from suite.peers.interface import Unsupported
from suite.peers.program_peer import ProgramPeer
from suite.peers.shooting import COMPILED, ProgramSolver, Shooting
from suite.task import Array, Task, shifted


class SqpHpipm(ProgramPeer):
    """Gauss-Newton Hessian (constant for this cost), HPIPM as CasADi sets it up by default.

    Cold: to convergence with CasADi's line search. Replans: one full step, no line search.
    """

    gauss_newton = True
    qp_options: dict[str, Any] = {}

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self._shooting = Shooting(task)
        self.cold = self._solver({"tol_pr": 1e-6, "tol_du": 1e-6})
        self._one: ProgramSolver | None = None

    def prepare_replan(self, state: Array) -> None:
        """Shift states and inputs; multipliers play no part in a full Gauss-Newton step."""
        if not self.gauss_newton:
            raise Unsupported("single iterations are made with the Gauss-Newton Hessian")
        guess = shifted(*self._active.trajectory())
        self._one = self._one or self._solver({"max_iter": 1, "max_iter_ls": 0})  # compiled only where it is needed
        self._active = self._one
        self._active.guess(state, *guess)

    def _solver(self, settings: dict[str, Any]) -> ProgramSolver:
        quiet = {"print_header": False, "print_iteration": False, "print_status": False}
        program = {"qpsol": "hpipm", "qpsol_options": _stages(self.task) | self.qp_options}
        hessian = {"hess_lag": _gauss_newton_hessian(self._shooting)} if self.gauss_newton else {}
        return ProgramSolver(self._shooting, "sqpmethod", {**COMPILED, **quiet, **program, **hessian, **settings})


class TunedSqpHpipm(SqpHpipm):
    """The settings that were fastest here: HPIPM's mode `speed`, missing bounds at 1e3 in place of 1e8."""

    qp_options = {"hpipm": {"mode": "speed"}, "inf": 1e3}


class ExactSqpHpipm(SqpHpipm):
    """CasADi's exact Hessian of the Lagrangian; HPIPM's mode `balance` fails least often with it."""

    gauss_newton = False
    qp_options = {"hpipm": {"mode": "balance"}, "inf": 1e3}


def _stages(task: Task) -> dict[str, Any]:
    n = task.horizon
    sizes = {"N": n, "nx": [task.nx] * (n + 1), "nu": [task.nu] * n + [0], "ng": [0] + [task.nh] * n}
    return {**sizes, "print_time": False, "error_on_fail": False}


def _gauss_newton_hessian(shooting: Shooting) -> Any:
    """The cost's own Hessian, in the form that sqpmethod asks for."""
    task, program = shooting.task, shooting.program
    stage = [task.time_step * task.state_weights, task.time_step * task.input_weights]
    diagonal = np.concatenate([np.tile(np.concatenate(stage), task.horizon), task.terminal_weights])
    factor, multipliers = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", program["g"].shape[0])
    inputs = [program["x"], program["p"], factor, multipliers]
    outputs = [factor * ca.diag(ca.DM(diagonal))]
    return ca.Function("nlp_hess_l", inputs, outputs, ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"])
