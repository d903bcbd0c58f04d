"""What planning, following and drawing plans need to know of the planner's model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.exceptions import ScenarioError
from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.composition import NO_EXTRAS, NOTHING, Extras
from doorman.planning.grip.lagrangian_planning import LagrangianPlanning
from doorman.planning.grip.quasi_static_planning import QuasiStaticPlanning
from doorman.planning.hinge import Hinge
from doorman.planning.whole_body.planning import WholeBodyPlanning


class PlanningModel(Protocol):
    """A model to plan with: its states and inputs, its problem, and the way to and from the *reduced* states and inputs.

    Reduced states and inputs are those of `Model`, [Φ, α, α̇, H] and [f_t, Ω, Ḣ_d]: what is measured, followed, recorded and
    drawn, whatever a plan is made with.
    """

    model: Model
    """Model of the scenario."""
    state_names: tuple[str, ...]
    """One for each of the nx states."""
    input_names: tuple[str, ...]
    """One for each of the nu inputs."""
    start_state: Array
    """The scenario's, at rest, shape (nx,)."""
    goal_state: Array
    """The scenario's, at rest, shape (nx,)."""
    hover_input: Array
    """Carries the vehicle's weight, shape (nu,)."""
    numbers: Numbers
    """Numbers of the scenario's task, by name; `fitted` returns others."""
    moved_mass: float
    r"""Mass m of which a plan knows that the thrust moves it; :math:`f_t R e_3 - m_A g e_3 - m \ddot P` is the force on the door.
    0: the vehicle's own inertia is unknown to the model [kg]."""
    headings: tuple[tuple[int, int], ...]
    """Places in the state of an angle and its rate that the autopilot's own loop holds, whatever torque a plan asks it for."""
    tolerance: float
    """Excess of a constraint up to which a plan may be used, in the constraint's unit."""

    def check_state(self, state: ArrayLike, field: str = "state") -> Array:
        """A state as a contiguous float array."""

    def problem(self, extras: Extras = NO_EXTRAS) -> Problem:
        """The scenario's optimal control problem."""

    def fitted(
        self, hinge: Hinge, margin: float, start: Array, given: Mapping[str, ArrayLike] = NOTHING, door_angle: float | None = None
    ) -> Numbers:  # fmt: skip
        """Numbers of the problem for what is known of the hinge, for a margin, a start, and a place where the leaf is to go."""

    def follows_start(self, given: Mapping[str, ArrayLike] = NOTHING) -> bool:
        """Whether `fitted` and `goal` depend on the start, where these numbers are given."""

    def goal(self, start: Array, hinge: Hinge, door_angle: float | None = None) -> Array:
        """Target of a plan's cost, shape (nx,): `goal_state`, leaning against the hinge, or a place on the way there."""

    def impossible(self, hinge: Hinge, start: Array) -> tuple[PlanStatus, str] | None:
        """Why the door cannot be opened from a start, whatever the plan."""

    def normal_forces(self, numbers: Numbers, states: Array, inputs: Array) -> Array:
        """Force of the tip on the door along its normal, positive where it presses, as the model understands it."""

    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        """State to plan from."""

    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        """Reduced states and inputs."""

    def swing(self, disturbance: float) -> Callable[[Array, Array], Array]:
        """The motion that inputs cause where vehicle and door are what the URDFs say and nothing lags or disturbs."""


def planning_model(model: Model) -> PlanningModel:
    """The model that a scenario plans with: by `planner.model`."""
    kinds: dict[str, Callable[[Model], PlanningModel]] = {"whole_body": WholeBodyPlanning}
    if model.contact.tied > 0.0:  # their tip is
        kinds |= {"quasi_static": QuasiStaticPlanning, "lagrangian": LagrangianPlanning}
    given = model.scenario.planner.model
    if given not in kinds:
        raise ScenarioError(
            f'this model does not plan for contact.kind = "{model.scenario.contact.kind}"', file=model.scenario.source,
            field="planner.model", given=given, allowed=", ".join(kinds),
        )  # fmt: skip
    for refused, why in (
        (model.actuation.fully, "this model does not plan for a fully actuated vehicle"),
        (not model.door.vertical, "this model plans only for doors on vertical hinges"),
    ):
        if given == "lagrangian" and refused:
            raise ScenarioError(
                why, file=model.scenario.source, field="planner.model", given=given, allowed="quasi_static"
            )
    return kinds[given](model)
