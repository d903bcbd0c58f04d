"""acados by its wheel: SQP and real-time iterations with partial condensing and HPIPM, generated C."""

from __future__ import annotations

import contextlib
import ctypes
import io
import os
import sys
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from suite.environment import ASIDE
from suite.peers.interface import Unsupported
from suite.standard.peers.interface import StandardPeer
from suite.standard.task import Array, Case, StandardTask
from suite.task import Answer

sys.path.append(str(Path(sys.prefix) / ASIDE))  # behind all others: the wheel brings a CasADi of its own
import acados  # noqa: E402

os.environ.setdefault("ACADOS_SOURCE_DIR", acados.DIR)
os.environ.setdefault("ACADOS_PYTHON_INTERFACE_PATH", acados.TEMPLATE_DIR)
os.environ.setdefault("TERA_PATH", acados.TERA_PATH)
for library in ("blasfeo", "hpipm", "qpOASES_e", "acados"):
    ctypes.CDLL(f"{acados.LIB_DIR}/lib{library}.so", mode=ctypes.RTLD_GLOBAL)
from acados.acados_template import AcadosModel, AcadosOcp, AcadosOcpSolver  # noqa: E402

FAR = 1e3
"""Stands for a missing bound: this version has no other way to leave one out."""


class AcadosSqp(StandardPeer):
    """Gauss-Newton Hessian, full steps, tolerance 1e-6; replans are one iteration of the kind SQP_RTI."""

    globalization = "FIXED_STEP"
    slack_price = 0.0
    """Of a row's violation, by its unit; 0 for hard rows."""

    def __init__(self, task: StandardTask) -> None:
        super().__init__(task)
        if task.function("rows").size1_out(0):
            raise Unsupported("constraints of inputs are not set up here")
        self._cold, self._one = self._solver("SQP"), self._solver("SQP_RTI")
        self._active, self._status = self._cold, 0

    def prepare_cold(self, case: Case) -> None:
        """The case's guess, multipliers zero."""
        self._active = self._cold
        self._cold.reset()
        self._guess(case)

    def prepare_replan(self, case: Case) -> None:
        """Shifted states and inputs."""
        following = self.follow(case)
        self._active = self._one
        self._guess(following)

    def solve(self) -> None:
        """One call of the solver."""
        self._status = self._active.solve()

    def answer(self) -> Answer:
        """Trajectory and acados' own verdict."""
        nodes = range(self.task.horizon)
        states = np.array([self._active.get(k, "x") for k in [*nodes, self.task.horizon]])
        inputs = np.array([self._active.get(k, "u") for k in nodes])
        iterations = int(np.ravel(self._active.get_stats("sqp_iter"))[0]) if self._active is self._cold else 1
        success = self._status == 0
        return Answer(states, inputs, iterations, f"status {self._status}", success, success)

    def _guess(self, case: Case) -> None:
        solver, n = self._active, self.task.horizon
        solver.set(0, "lbx", case.start)
        solver.set(0, "ubx", case.start)
        for k in range(n + 1):
            solver.set(k, "x", case.states[k])
            if k < n:
                solver.set(k, "u", case.inputs[k])
            if self.task.nq:
                solver.set(k, "p", case.node_parameters[k])

    def _solver(self, kind: str) -> Any:
        name = f"{self.task.name}_{kind.lower()}_{self.globalization.lower()}_{self.slack_price:.0f}"
        folder = Path("acados", name).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        ocp = self._program(name, kind)
        ocp.code_export_directory = str(folder)
        with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()):
            solver = AcadosOcpSolver(ocp, json_file=str(folder / "ocp.json"), verbose=False)
        for k in (0,) if self.task.function("state_rows").size1_out(0) else ():
            solver.constraints_set(k, "uh", FAR * np.ones(self.task.function("state_rows").size1_out(0)))
        return solver

    def _program(self, name: str, kind: str) -> Any:
        task, ocp = self.task, AcadosOcp()
        x, u, q = ca.SX.sym("x", task.nx), ca.SX.sym("u", task.nu), ca.SX.sym("q", task.nq)
        model = AcadosModel()
        model.name, model.x, model.u, model.xdot = name, x, u, ca.SX.sym("xdot", task.nx)
        model.f_expl_expr = task.function("rate")(x, u, q)
        model.f_impl_expr = model.xdot - model.f_expl_expr
        if task.nq:
            model.p, ocp.parameter_values = q, np.zeros(task.nq)
        stage = task.function("stage_residual")(x, u, q) / np.sqrt(task.time_step)
        end = task.function("end_residual")(x, q)
        for residual, suffix in ((stage, ""), (end, "_e")):
            setattr(ocp.cost, f"cost_type{suffix}", "NONLINEAR_LS")
            setattr(model, f"cost_y_expr{suffix}", residual)
            setattr(ocp.cost, f"W{suffix}", np.eye(residual.numel()))
            setattr(ocp.cost, f"yref{suffix}", np.zeros(residual.numel()))
        rows = task.function("state_rows")(x, q)
        end_rows = ca.vertcat(rows, task.function("end_rows")(x, q))
        for expression, suffix in ((rows, ""), (end_rows, "_e")):
            if expression.numel():
                setattr(model, f"con_h_expr{suffix}", expression)
                setattr(ocp.constraints, f"lh{suffix}", -FAR * np.ones(expression.numel()))
                setattr(ocp.constraints, f"uh{suffix}", np.zeros(expression.numel()))
                if self.slack_price:
                    self._soften(ocp, expression.numel(), suffix)
        ocp.model = model
        ocp.dims.N = task.horizon
        ocp.constraints.x0 = task.start_state.start
        _bound(ocp.constraints, "bu", task.input_bounds)
        for suffix in ("bx", "bx_e"):
            _bound(ocp.constraints, suffix, task.state_bounds)
        self._settings(ocp.solver_options, kind)
        return ocp

    def _soften(self, ocp: Any, count: int, suffix: str) -> None:
        setattr(ocp.constraints, f"idxsh{suffix}", np.arange(count))
        for name, price in (("zl", self.slack_price), ("zu", self.slack_price), ("Zl", 0.0), ("Zu", 0.0)):
            setattr(ocp.cost, f"{name}{suffix}", price * np.ones(count))

    def _settings(self, options: Any, kind: str) -> None:
        options.tf = self.task.horizon * self.task.time_step
        options.nlp_solver_type, options.qp_solver = kind, "PARTIAL_CONDENSING_HPIPM"
        options.hessian_approx, options.integrator_type = "GAUSS_NEWTON", "ERK"
        options.sim_method_num_stages, options.sim_method_num_steps = 4, self.task.integration_steps
        options.nlp_solver_max_iter, options.qp_solver_iter_max = 200, 100
        options.ext_fun_compile_flags = "-O3 -march=native"
        options.print_level = 0
        for name in ("stat", "eq", "ineq", "comp"):
            setattr(options, f"nlp_solver_tol_{name}", 1e-6)
        if kind == "SQP":
            options.globalization = self.globalization


class SlackAcadosSqp(AcadosSqp):
    """Merit line search, and slacks with an exact linear price, so that every quadratic program has a solution."""

    globalization = "MERIT_BACKTRACKING"
    slack_price = 1e2


def _bound(constraints: Any, suffix: str, bounds: Array) -> None:
    """Bounds of those entries that have one."""
    entries = np.flatnonzero(np.isfinite(bounds).any(axis=0))
    if len(entries):
        lower, upper = np.clip(bounds[:, entries], -FAR, FAR)
        setattr(constraints, f"idx{suffix}", entries)
        setattr(constraints, f"l{suffix}", lower)
        setattr(constraints, f"u{suffix}", upper)
