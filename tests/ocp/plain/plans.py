"""Plans of all kinds, written to a file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from doorman import Plan, Planner, Scenario
from doorman.ocp import Cddp, Hybrid, Problem, PythonModel, Solution
from doorman.ocp.problem.terms import Constraint
from doorman.planning.grip.push import push_state

MODELS: dict[str, tuple[str, dict[str, Any]]] = {
    "paper": ("paper", {}),
    "rows of inputs": ("paper", {}),
    "lagrangian": ("paper", {"planner.model": "lagrangian"}),
}
REPLANS = 5


def doors() -> Iterator[tuple[str, Plan]]:
    """A cold plan, replans under noise and after a jump, and starts of which some are outside the constraints."""
    for name, (scenario, overrides) in MODELS.items():
        short = {"planner.horizon_steps": 20, **overrides}
        rows = [Constraint("little thrust", lambda task: task.thrust - 31.0, "N")] if name == "rows of inputs" else []
        planner, rng = Planner(Scenario.load(scenario, short), constraints=rows), np.random.default_rng(5)
        model = planner.model
        planner.update_door(friction=0.3, disturbance=-1.2)
        state = push_state(model, model.start_state, 1.2)
        if name == "lagrangian":
            state = planner.planning.state(state, np.zeros(3))
        plan = planner.plan(state)
        yield name, plan
        for k in range(REPLANS):
            noise = (0.003 if k < REPLANS - 1 else 0.1) * rng.normal(size=state.size)
            plan = planner.replan(plan.states[1] + noise)
            yield f"{name}, replan {k}", plan
        for k in range(3):
            yield f"{name}, thrown {k}", planner.plan(state + 0.1 * (k + 1) * rng.uniform(-1.0, 1.0, state.size))


def toys() -> Iterator[tuple[str, Solution]]:
    """Problems without a door, by every solver: with kernels of their own, and from Python functions of every kind."""
    from test_python_model import cart, cart_of_every_kind
    from tutorial import tutorial

    pendulum = tutorial(1).pendulum
    for method in (Hybrid, Cddp):
        yield f"pendulum, {method.__name__}", method(pendulum).solve([0.0, 0.0])
        yield f"cart, {method.__name__}", method(cart()).solve([0.0, 0.0])
    for derivatives in ("differences", "complex step"):
        problem = cart_of_every_kind(derivatives)
        yield f"cart of every kind, {derivatives}", Hybrid(problem).solve([0.0, 0.0])
    yield "pendulum of functions", Hybrid(_pendulum_of_functions(pendulum)).solve([0.0, 0.0])


def _pendulum_of_functions(like: Problem) -> Problem:
    """The tutorial's pendulum with its cost of states in functions: its iterations need their line search."""
    cost, dt, wall = like.cost, like.time_step, float(like.model.parameters[0])
    effort = replace(cost, state_weights=np.zeros(2), terminal_weights=np.zeros(2))

    def swing(x: Any, u: Any) -> Any:
        rate = x[1] + dt * (u[0] - 9.81 * np.sin(x[0]) - 0.1 * x[1])
        return [x[0] + dt * rate, rate]

    described = PythonModel(
        swing,
        lambda x: -np.sin(x[0]) - wall,
        stage_cost=lambda x, u: 0.5 * dt * cost.state_weights @ (x - cost.state_goal) ** 2,
        end_cost=lambda x: 0.5 * cost.terminal_weights @ (x - cost.state_goal) ** 2,
        derivatives="complex step",
    )
    return described.problem(effort, like.horizon, dt, like.bounds)


def write(which: str, file: str) -> None:
    """Solve `doors` or `toys`, and write what came of it."""
    plans = {}
    for name, plan in {"doors": doors, "toys": toys}[which]():
        figures = {"status": str(plan.status), "iterations": plan.iterations, "cost": plan.cost}
        plans[name] = {**figures, "states": plan.states.tolist(), "inputs": plan.inputs.tolist()}
    Path(file).write_text(json.dumps(plans))
