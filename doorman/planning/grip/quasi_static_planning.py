"""The simplified dynamics as a model to plan with: its states and inputs are the reduced ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.composition import NO_EXTRAS, NOTHING, Extras
from doorman.planning.grip.door_problem import door_numbers, door_problem
from doorman.planning.grip.push import LargestPushes, leaning, push_along_normal, too_stiff
from doorman.planning.hinge import Hinge
from doorman.planning.own_motion import Motion


class QuasiStaticPlanning:
    """x = [Φ, α, α̇, H], u = [f_t, Ω, Ḣ_d]; see `PlanningModel`."""

    def __init__(self, model: Model) -> None:
        self.model = model
        joints = model.vehicle.joint_names
        self.state_names = ("roll", "pitch", "yaw", "door angle", "door rate", *joints)
        self.input_names = ("thrust", "body rate x", "body rate y", "body rate z", *(f"rate of {j}" for j in joints))
        if model.actuation.fully:
            self.input_names += ("force ahead", "force to the left")
        self.start_state = model.start_state
        self.goal_state = model.goal_state
        self.hover_input = np.concatenate([model.hover_input, np.zeros(2 if model.actuation.fully else 0)])
        self.moved_mass = 0.0
        self.headings: tuple[tuple[int, int], ...] = ()
        self.tolerance = SolverOptions().feasibility
        self.numbers = door_numbers(model)

    @cached_property
    def _largest(self) -> LargestPushes:
        return LargestPushes(self.model)

    def check_state(self, state: ArrayLike, field: str = "state") -> Array:
        """A state as a contiguous float array. See `PlanningModel`."""
        return self.model.check_state(state, field)

    def problem(self, extras: Extras = NO_EXTRAS) -> Problem:
        """The paper's problem. See `PlanningModel`."""
        return door_problem(self.model, self.numbers, extras)

    def fitted(
        self, hinge: Hinge, margin: float, start: Array, given: Mapping[str, ArrayLike] = NOTHING, door_angle: float | None = None
    ) -> Numbers:  # fmt: skip
        """The scenario's numbers with those of the hinge and the margin; a start changes none. See `PlanningModel`."""
        known = {**hinge.numbers(), "door.moving_inertia": hinge.inertia, "limits.margin": margin}
        return self.numbers.replaced({**known, **given})

    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        """The reduced state itself: body rates are inputs here. See `PlanningModel`."""
        return np.array(reduced, dtype=np.float64)

    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        """States and inputs themselves. See `PlanningModel`."""
        return states, inputs

    def follows_start(self, given: Mapping[str, ArrayLike] = NOTHING) -> bool:
        """False: hinge and margin say it all. See `PlanningModel`."""
        return False

    def goal(self, start: Array, hinge: Hinge, door_angle: float | None = None) -> Array:
        """The scenario's goal, or a place on the way there, leaning against the hinge. See `PlanningModel`."""
        goal = self.goal_state if door_angle is None else self.state(self.model.on_the_way(door_angle), np.zeros(3))
        return leaning(self.model, goal, hinge)

    def impossible(self, hinge: Hinge, start: Array) -> tuple[PlanStatus, str] | None:
        """Whether the door resists by more than the vehicle can push. See `PlanningModel`."""
        return too_stiff(self.model, hinge, float(start[3]), self._largest)

    def normal_forces(self, numbers: Numbers, states: Array, inputs: Array) -> Array:
        """Share of the thrust along the door's normal. See `PlanningModel`."""
        return push_along_normal(self.model, *self.reduced(states, inputs))

    def swing(self, disturbance: float) -> Callable[[Array, Array], Array]:
        r"""This model with the inertia that a push really moves, :math:`I_D + m_A D_V^2`. See `PlanningModel`."""
        model = self.model
        moving = model.door.inertia + model.vehicle.mass * model.coupling.lever_length**2
        known = {"door.moving_inertia": moving, "door.friction": 0.0, "door.disturbance": disturbance}
        if model.actuation.fully:
            return Motion(door_problem(model, self.numbers.replaced(known)))
        return model.reduced.with_numbers(known).step
