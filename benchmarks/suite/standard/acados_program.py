"""A standard problem as acados takes it, with acados built by `build_native.py`."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from build_native import ACADOS

from suite.standard.task import Array, StandardTask
from suite.tera import renderer

os.environ["ACADOS_SOURCE_DIR"] = str(ACADOS.folder)
os.environ["TERA_PATH"] = str(renderer(Path.cwd()))
sys.path.insert(0, str(ACADOS.folder / "interfaces" / "acados_template"))
from acados_template import ACADOS_INFTY, AcadosModel, AcadosOcp, AcadosOcpSolver  # noqa: E402


@dataclass(frozen=True)
class Settings:
    """What can be chosen about acados; the rest is as a user of it would have it for speed."""

    kind: str = "SQP"
    """Of a cold solve; replans are SQP_RTI."""
    globalization: str = "FIXED_STEP"
    slack_price: float = 0.0
    """Of a row's violation, by its unit; 0 for hard rows."""
    blocks: int = 0
    """Of the condensed quadratic program; 0 for one per step of the horizon, -1 for all in one."""


def solver_of(task: StandardTask, settings: Settings, one: bool) -> Any:
    """A compiled solver; code that was generated before for the same program is used again.

    Args:
        task: The problem.
        settings: Of acados.
        one: Whether it makes a single iteration.

    Returns:
        acados' own object.
    """
    kind = "SQP_RTI" if one else settings.kind
    chosen = [task.name, kind, *vars(settings).values()]
    name = re.sub(r"\W+|_+", "_", "_".join(map(str, chosen)).lower()).strip("_")
    folder = Path("acados", name).absolute()
    folder.mkdir(parents=True, exist_ok=True)
    with contextlib.redirect_stdout(io.StringIO()):
        ocp = _program(task, name, settings)
        ocp.code_gen_options.code_export_directory = str(folder)
        ocp.code_gen_options.json_file = "ocp.json"
        ocp.code_gen_options.ext_fun_compile_flags = "-O3 -march=native"
        _options(ocp.solver_options, task, kind, settings)
        with contextlib.chdir(folder):
            return AcadosOcpSolver(ocp, generate=False, build=False, verbose=False)


def _program(task: StandardTask, name: str, settings: Settings) -> Any:
    ocp, model = AcadosOcp(), AcadosModel()
    x, u, q = ca.SX.sym("x", task.nx), ca.SX.sym("u", task.nu), ca.SX.sym("q", task.nq)
    model.name, model.x, model.u = name, x, u
    model.disc_dyn_expr = task.function("step")(x, u, q)
    if task.nq:
        model.p, ocp.parameter_values = q, task.start_state.node_parameters[0]
    ocp.model, ocp.solver_options.N_horizon = model, task.horizon
    _cost(ocp, "", task.function("stage_residual")(x, u, q) / np.sqrt(task.time_step), x, u, q)
    _cost(ocp, "_e", task.function("end_residual")(x, q), x, ca.SX(0, 1), q)
    at_inputs, at_states = task.function("rows")(x, u, q), task.function("state_rows")(x, q)
    at_end = task.function("end_rows")(x, q)
    _rows(ocp, "_0", at_inputs, settings.slack_price)
    _rows(ocp, "", ca.vertcat(at_inputs, at_states), settings.slack_price)
    _rows(ocp, "_e", ca.vertcat(at_states, at_end), settings.slack_price)
    ocp.constraints.x0 = task.start_state.start
    _bound(ocp.constraints, "bu", task.input_bounds)
    for suffix in ("bx", "bx_e"):
        _bound(ocp.constraints, suffix, task.state_bounds)
    return ocp


def _cost(ocp: Any, suffix: str, residual: Any, x: Any, u: Any, q: Any) -> None:
    """Half squares; linear ones are declared so, as nothing has to be evaluated for them then."""
    count, slopes = residual.numel(), ca.jacobian(residual, ca.vertcat(x, u))
    setattr(ocp.cost, f"W{suffix}", np.eye(count))
    if slopes.is_constant() and not ca.depends_on(residual, q):
        at_zero = ca.Function("r", [x, u], [residual])(0, 0)
        setattr(ocp.cost, f"cost_type{suffix}", "LINEAR_LS")
        setattr(ocp.cost, f"Vx{suffix}", np.array(ca.DM(slopes[:, : x.numel()])))
        if u.numel():
            ocp.cost.Vu = np.array(ca.DM(slopes[:, x.numel() :]))
        setattr(ocp.cost, f"yref{suffix}", -np.array(at_zero).ravel())
        return
    setattr(ocp.cost, f"cost_type{suffix}", "NONLINEAR_LS")
    setattr(ocp.model, f"cost_y_expr{suffix}", residual)
    setattr(ocp.cost, f"yref{suffix}", np.zeros(count))


def _rows(ocp: Any, suffix: str, rows: Any, slack_price: float) -> None:
    """Rows that must not be positive, where there are any."""
    count = rows.numel()
    if not count:
        return
    setattr(ocp.model, f"con_h_expr{suffix}", rows)
    setattr(ocp.constraints, f"lh{suffix}", np.full(count, -ACADOS_INFTY))
    setattr(ocp.constraints, f"uh{suffix}", np.zeros(count))
    if slack_price:
        setattr(ocp.constraints, f"idxsh{suffix}", np.arange(count))
        for name, price in (("zl", slack_price), ("zu", slack_price), ("Zl", 0.0), ("Zu", 0.0)):
            setattr(ocp.cost, f"{name}{suffix}", np.full(count, price))


def _bound(constraints: Any, suffix: str, bounds: Array) -> None:
    """Bounds of those entries that have one; acados leaves out a missing end."""
    entries = np.flatnonzero(np.isfinite(bounds).any(axis=0))
    if len(entries):
        lower, upper = np.clip(bounds[:, entries], -ACADOS_INFTY, ACADOS_INFTY)
        setattr(constraints, f"idx{suffix}", entries)
        setattr(constraints, f"l{suffix}", lower)
        setattr(constraints, f"u{suffix}", upper)


def _options(options: Any, task: StandardTask, kind: str, settings: Settings) -> None:
    options.tf = task.horizon * task.time_step
    options.nlp_solver_type = kind
    options.qp_solver, options.qp_solver_cond_N = "PARTIAL_CONDENSING_HPIPM", settings.blocks
    options.hpipm_mode = "SPEED"
    options.hessian_approx, options.integrator_type = "GAUSS_NEWTON", "DISCRETE"
    options.nlp_solver_max_iter, options.qp_solver_iter_max = 200, 100
    options.print_level = 0
    for name in ("stat", "eq", "ineq", "comp"):
        setattr(options, f"nlp_solver_tol_{name}", 1e-6)
    if kind != "SQP_RTI":
        options.globalization = settings.globalization
