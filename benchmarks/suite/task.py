"""What is to be solved, as plain numbers: all that a solver in another environment is told of a door and a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRAVITY = 9.81
"""[m/s²]."""


@dataclass(frozen=True)
class Task:
    """One optimal control problem; SI units, angles in rad, states [Φ, α, α̇, H], inputs [f_t, Ω, Ḣ_d]."""

    name: str
    overrides: dict[str, Any]
    """How doorman is told of it: `Scenario.load("paper", overrides)`."""
    horizon: int
    """N, number of steps."""
    time_step: float
    margin: float
    """h + margin ≤ 0 at the nodes 1 … N [m]."""
    mass: float
    radius: float
    door_width: float
    door_inertia: float
    damping: float
    friction: float
    friction_rate: float
    stiffness: float
    rest_angle: float
    distance_from_hinge: float
    axes: Array
    """Joint axes in the body at H = 0, shape (n, 3)."""
    links: Array
    """From joint i − 1 to joint i at H = 0, shape (n, 3)."""
    point_parents: NDArray[np.int64]
    """Joint that carries each constrained point, shape (points,); the last point is the tip."""
    point_offsets: Array
    """From that joint to the point, shape (points, 3)."""
    state_weights: Array
    terminal_weights: Array
    input_weights: Array
    start_state: Array
    goal_state: Array
    hover_input: Array
    state_bounds: Array
    """Lower and upper at the nodes 1 … N, shape (2, nx); infinite where there is none."""
    input_bounds: Array
    """Lower and upper, shape (2, nu); infinite where there is none."""
    least_cosine: float
    """Of the tilt at the nodes 1 … N, a constraint more; −1 where there is none."""

    @property
    def nx(self) -> int:
        """Number of states."""
        return len(self.goal_state)

    @property
    def nu(self) -> int:
        """Number of inputs."""
        return len(self.hover_input)

    @property
    def nh(self) -> int:
        """Number of constraints at a node: the arm's points, the disc, the jambs, the tilt if it is limited."""
        return len(self.point_parents) + 3 + (self.least_cosine > -1.0)


@dataclass(frozen=True)
class Answer:
    """What a solver hands out."""

    states: Array
    """x_0 … x_N, shape (N + 1, nx)."""
    inputs: Array
    """u_0 … u_{N−1}, shape (N, nu)."""
    iterations: int
    claim: str
    """Its own word on how it ended."""
    usable: bool
    """Whether it claims that the plan may be used."""
    converged: bool
    """Whether it claims that the plan is optimal."""
    callbacks: float = 0.0
    """Time of the solve that went into Python callbacks of the model [s]."""


class Timing(NamedTuple):
    """How long one call took."""

    seconds: float
    on_core: float
    """Time that the solver's process had the core [s]: the same on an idle machine, and what counts on a busy one."""
    interrupted: bool
    """Whether the scheduler took the core away in between."""


def hover_guess(task: Task, state: Array) -> tuple[Array, Array]:
    """First guess of a cold solve: the state held and hover inputs, shapes (N + 1, nx) and (N, nu)."""
    return np.tile(state, (task.horizon + 1, 1)), np.tile(task.hover_input, (task.horizon, 1))


def shifted(states: Array, inputs: Array) -> tuple[Array, Array]:
    """The same plan one step later; the last node is held."""
    return np.vstack([states[1:], states[-1:]]), np.vstack([inputs[1:], inputs[-1:]])
