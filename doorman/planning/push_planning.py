"""The simplified dynamics of a tip that can only push, as a model to plan with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.composition import NO_EXTRAS, Extras
from doorman.planning.hinge import Hinge
from doorman.planning.push_problem import CREEP, is_relaxed, push_numbers, push_problem, with_hinge
from doorman.planning.quasi_static_planning import QuasiStaticPlanning, push_along_normal

Array = NDArray[np.float64]


class PushPlanning(QuasiStaticPlanning):
    """x = [Φ, α, α̇, H], u = [f_t, Ω, Ḣ_d] with the tip pressing on the leaf; see `PlanningModel` and `push_problem`.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        super().__init__(model)
        self.follows_start = True
        self.numbers = push_numbers(model)
        planner = model.scenario.planner
        self._lead = 0.5 * model.scenario.push.max_rate * planner.horizon_steps * planner.time_step

    def problem(self, extras: Extras = NO_EXTRAS) -> Problem:
        """The problem with the push's constraints, see `PlanningModel`."""
        fitted = with_hinge(self.model, self.numbers, Hinge.of(self.model.door), self.start_state)
        return push_problem(self.model, fitted, extras)

    def fitted(self, hinge: Hinge, margin: float, start: Array) -> Numbers:
        """Constraints that fit the hinge's resistance and contain the start, see `PlanningModel`."""
        return with_hinge(self.model, self.numbers, hinge, start, margin)

    def goal(self, start: Array, hinge: Hinge) -> Array:
        """The door at its goal, heading and arm as far on their way as the door will be within the horizon.

        A pushed door takes many horizons. A heading that hurries to its goal turns the vehicle away from the line of the push,
        and its rotors make little torque against what the push does then.
        """
        goal, soon = np.array(self.goal_state), self.model.on_the_way(float(start[3]) - self._lead)
        goal[2], goal[5:] = soon[2], soon[5:]
        return goal

    def impossible(self, hinge: Hinge, start: Array) -> tuple[PlanStatus, str] | None:
        """The same, and a door at rest that resists by less than the least push makes, see `PlanningModel`."""
        if (stiff := super().impossible(hinge, start)) is not None:
            return stiff
        angle, rate = float(start[3]), float(start[4])
        resists = hinge.friction - hinge.torque_at_rest(angle, self.model.door.rest_angle)
        least = self.model.scenario.push.least_force
        made = least * self.model.coupling.distance_from_hinge
        if abs(rate) > CREEP or resists >= made:
            return None
        words = (
            f"resists by {resists:.2f} N m; the least push, {least:.2f} N, makes {made:.2f} N m: nothing would brake it"
        )
        return PlanStatus.CANNOT_STOP, words

    def relaxed(self, numbers: Numbers) -> bool:
        """Whether the start is too fast to be stopped by the door's own resistance, or beyond the largest rate."""
        return is_relaxed(self.model, numbers)

    def normal_forces(self, numbers: Numbers, states: Array, inputs: Array) -> Array:
        r"""λ_n of `dynamics.push` with the thrust's push, see `PlanningModel`."""
        angle, rate = states[: len(inputs), 3], states[: len(inputs), 4]
        torque = numbers.one("door.damping") * rate + numbers.one("door.disturbance")
        torque += numbers.one("door.stiffness") * (angle - numbers.one("door.rest_angle"))
        torque += numbers.one("door.friction") * np.tanh(rate / numbers.one("door.friction_rate"))
        lever = numbers.one("vehicle.mass") * numbers.one("contact.distance_from_hinge")
        moved = numbers.one("door.inertia") * push_along_normal(self.model.door, states, inputs) - lever * torque
        return np.asarray(moved / numbers.one("door.moving_inertia"))
