"""What planning, following and drawing plans need to know of the planner's model, and what all models share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array, frozen
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import regular_state
from doorman.model import Model
from doorman.numba_types.handles import held, separate
from doorman.ocp.kernels import functions
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.composition import NO_EXTRAS, NOTHING, Extras
from doorman.planning.grip.push import too_stiff
from doorman.planning.hinge import Hinge


class PlanningModel(ABC):
    """A model to plan with: its states and inputs, its problem, and the way to and from the *reduced* states and inputs.

    Reduced states and inputs are those of `Model`, [Φ, α, α̇, H] and [f_t, Ω, Ḣ_d]: what is measured, followed, recorded and
    drawn, whatever a plan is made with.
    """

    moved_mass: float = 0.0
    r"""Mass m of which a plan knows that the thrust moves it; :math:`f_t R e_3 - m_A g e_3 - m \ddot P` is the force on the door.
    0: the vehicle's own inertia is unknown to the model [kg]."""
    headings: tuple[tuple[int, int], ...] = ()
    """Places in the state of an angle and its rate that the autopilot's own loop holds, whatever torque a plan asks it for."""
    tolerance: float = SolverOptions().feasibility
    """Excess of a constraint up to which a plan may be used, in the constraint's unit."""

    def __init__(self, model: Model, states: tuple[str, ...], inputs: tuple[str, ...], numbers: Numbers) -> None:
        joints, side = model.vehicle.joint_names, ("force ahead", "force to the left") if model.actuation.fully else ()
        self.model = model
        self.state_names = (*states, *joints)
        """One for each of the nx states."""
        self.input_names = (*inputs, *(f"rate of {joint}" for joint in joints), *side)
        """One for each of the nu inputs."""
        self.numbers = numbers
        """Numbers of the scenario's task, by name; `fitted` returns others."""
        self.hover_input = np.concatenate([model.hover_input, np.zeros(len(side))])
        """Carries the vehicle's weight, shape (nu,)."""
        self.start_state = frozen(self.state(model.start_state, np.zeros(3)))
        """The scenario's, at rest, shape (nx,)."""
        self.goal_state = frozen(self.state(model.goal_state, np.zeros(3)))
        """The scenario's, at rest, shape (nx,)."""

    def check_state(self, state: ArrayLike, field: str = "state") -> Array:
        """A state as a contiguous float array."""
        return regular_state(state, len(self.state_names), field, pitch=self.state_names.index("pitch"))

    @abstractmethod
    def problem(self, extras: Extras = NO_EXTRAS, numbers: Numbers | None = None) -> Problem:
        """The scenario's optimal control problem."""

    @abstractmethod
    def fitted(
        self, hinge: Hinge, margin: float, start: Array, given: Mapping[str, ArrayLike] = NOTHING, door_angle: float | None = None
    ) -> Numbers:  # fmt: skip
        """Numbers of the problem for what is known of the hinge, for a margin, a start, and a place where the leaf is to go."""

    def follows_start(self, given: Mapping[str, ArrayLike] = NOTHING) -> bool:
        """Whether `fitted` and `goal` depend on the start, where these numbers are given."""
        return False

    @abstractmethod
    def goal(self, start: Array, hinge: Hinge, door_angle: float | None = None) -> Array:
        """Target of a plan's cost, shape (nx,): `goal_state`, leaning against the hinge, or a place on the way there."""

    def impossible(self, hinge: Hinge, start: Array) -> tuple[PlanStatus, str] | None:
        """Why the door cannot be opened from a start, whatever the plan."""
        return too_stiff(self.model, hinge, float(start[self.state_names.index("door angle")]))

    @abstractmethod
    def normal_forces(self, numbers: Numbers, states: Array, inputs: Array) -> Array:
        """Force of the tip on the door along its normal, positive where it presses, as the model understands it."""

    @abstractmethod
    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        """State to plan from."""

    @abstractmethod
    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        """Reduced states and inputs."""

    def swing(self, disturbance: float) -> Callable[[Array, Array], Array]:
        """The motion that inputs cause where vehicle and door are what the URDFs say and nothing lags or disturbs."""
        return Motion(
            self.problem(numbers=self.numbers.replaced({"door.disturbance": disturbance, "door.friction": 0.0}))
        )


class Motion:
    """The dynamics of a problem, x⁺ = f(x, u), with numbers of its own."""

    def __init__(self, problem: Problem) -> None:
        self._model = separate(problem.model)
        self._held = held(self._model)  # as one pointer: to pass a hundred arrays takes longer than the step
        self._first = problem.hidden_parameters

    def know(self, numbers: Array) -> None:
        """Take other numbers of a symbolic model."""
        self._model.parameters[self._first :] = numbers

    def __call__(self, state: Array, inputs: Array) -> Array:
        """One step."""
        following = np.empty_like(state)
        functions.step(self._held, state, inputs, following)
        return following
