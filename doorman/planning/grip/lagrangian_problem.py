r"""The door problem with the full Lagrangian dynamics: x = [Φ, α, Φ̇, α̇, H], u = [f_t, T, Ḣ_d].

Constraints and goal are those of the paper's problem. So are the weights of what both models have. The paper's weights of the
body rates, which are inputs there, go to Φ̇, since Ω = W⁻¹(Φ)Φ̇ and W is nearly I at the tilts that are flown. At the last
state Φ̇ has the same weights, as the paper has L = Q. A torque costs per (N m)² what the thrust costs per N²: in flight this
opens the paper's door in 6.2 s. With a tenth of it the plans ask for torques that the rotors do not have. With ten times as
much they lag behind the door.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.collision.rows.listed import Kinds
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Problem
from doorman.ocp.problem.terms import Constraint
from doorman.planning.composition import NO_EXTRAS, Extras, Made, task_problem
from doorman.planning.grip.door_problem import chosen_weights, door_numbers, door_rows
from doorman.planning.limits import tied_bounds
from doorman.planning.pace import time_constant_held

_STATE_WEIGHTS = (5.0, 5.0, 3.0, 9.0, 5.0, 5.0, 13.5, 8.0)
_INPUT_WEIGHTS = (0.1, 0.1, 0.1, 0.1)
_RATES = ("roll rate", "pitch rate", "yaw rate")


def lagrangian_problem(model: Model, numbers: Numbers | None = None, extras: Extras = NO_EXTRAS) -> Problem:
    """Optimal control problem of a scenario with the full dynamics."""
    cost, bounds = lagrangian_cost(model), tied_bounds(model, 8, body_rates=False)
    return task_problem("lagrangian", _lagrangian, model, numbers or lagrangian_numbers(model), cost, bounds, extras)


def lagrangian_numbers(model: Model) -> Numbers:
    """Numbers of the scenario's task, by name: those of the door problem, inertias and the limits of the body rates."""
    limits = model.scenario.limits
    rates = {"limits.body_rates": np.array(limits.body_rates)} if limits.enabled else {}
    numbers = door_numbers(model)
    of_inertia = {name: value for name, value in inertia_numbers(model.vehicle).items() if name not in numbers.sizes}
    return numbers.and_also({**of_inertia, **rates})


def inertia_numbers(vehicle: Vehicle) -> dict[str, Array]:
    """Numbers of the rotational inertia: I_A, the same in all postures, or the masses that it follows from."""
    if not vehicle.bodies.balanced:
        return vehicle.bodies.numbers()
    return {"vehicle.inertia": np.asarray(vehicle.inertia(np.zeros(vehicle.n_arm))[np.triu_indices(3)])}


def _lagrangian(pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers, kinds: Kinds) -> Made:
    """The task with the door problem's constraints, and limits of the body rates, which are no inputs here."""
    from doorman.dynamics.lagrangian import LagrangianTask  # CasADi

    task = LagrangianTask(pattern, point_names, numbers)
    rows = door_rows(task, kinds)
    for axis, rate in enumerate(_RATES if "limits.body_rates" in numbers.sizes else ()):
        for side, sign in (("above", 1), ("below", -1)):
            excess = sign * task.body_rates[axis] - task.limits.body_rates[axis]
            rows.append(Constraint(f"{rate} {side}", excess))
    return task, rows, []


def lagrangian_cost(model: Model) -> QuadraticCost:
    """The scenario's cost; the weights above where it gives none, extended to the arm's joints."""
    n = model.n_arm
    scale = model.scale
    by_state = np.array([*_STATE_WEIGHTS, *([0.05] + [0.1] * n)[:n]])
    by_state[4:7] *= scale.time**2
    by_state[7] = time_constant_held(model) ** 2 * by_state[3]
    by_input = np.array([*_INPUT_WEIGHTS, *[10.0] * n])
    by_input *= [1.0 / scale.force**2, *[1.0 / scale.torque**2] * 3, *[scale.time**2] * n]
    by_state = chosen_weights(model, "state", by_state)
    return QuadraticCost(
        state_weights=by_state,
        terminal_weights=scale.time * by_state,
        input_weights=chosen_weights(model, "input", by_input),
        state_goal=at_rest(model.goal_state),
        input_goal=model.hover_input,
    )


def at_rest(reduced: Array) -> Array:
    """State of the full dynamics with Φ̇ = 0."""
    return np.concatenate([reduced[:4], np.zeros(3), reduced[4:]])
