"""The whole body as a model to plan with: a vehicle that flies freely, and meets the leaf by a compliant contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import body_rates_of, euler_rates, rotation_body_to_world
from doorman.model import Model
from doorman.ocp.problem.problem import Problem
from doorman.planning.composition import NO_EXTRAS, NOTHING, Extras
from doorman.planning.grip.push import plumb
from doorman.planning.hinge import Hinge
from doorman.planning.model_base import PlanningModel
from doorman.planning.pace import RESTING
from doorman.planning.whole_body.contact import contact_forces, depth_of, turned_by, whole_body_state
from doorman.planning.whole_body.numbers import goal_numbers, whole_body_numbers
from doorman.planning.whole_body.problem import whole_body_problem
from doorman.planning.whole_body.references import Leaf, references

_TOUCHES = 0.25
"""A tip touches that presses with so much of what carries the leaf, or of what the vehicle's tip rests with, twice."""
_TOLERANCE = 2e-3
"""Tolerance of hard limits [m, or 30 N]: one iteration leaves active rows within it."""
_REDUCED = (3, 4, 5, 12, 13)
"""Places of [Φ, α, α̇] in the state; the arm's angles follow."""


class WholeBodyPlanning(PlanningModel):
    """x = [P, Φ, V, Φ̇, α, α̇, H], u = [f_t, φ_c, θ_c, τ_z, Ḣ_d]; see `PlanningModel` and `whole_body`."""

    headings = ((5, 11),)
    tolerance = _TOLERANCE

    def __init__(self, model: Model) -> None:
        states = (
            "x", "y", "z", "roll", "pitch", "yaw", "velocity x", "velocity y", "velocity z",
            "roll rate", "pitch rate", "yaw rate", "door angle", "door rate",
        )  # fmt: skip
        inputs = ("thrust", "commanded roll", "commanded pitch", "yaw torque")
        numbers, self._resting = whole_body_numbers(model), model.contact.between(RESTING * model.scale.force, 0.0)
        self._rests_at = depth_of(self._resting, numbers) if self._resting > 0.0 else 0.0
        super().__init__(model, states, inputs, numbers)
        self.moved_mass = model.vehicle.mass
        self._follow_start = frozenset(self._fitting(self.numbers, Hinge.of(model.door), self.start_state))

    def problem(self, extras: Extras = NO_EXTRAS, numbers: Numbers | None = None) -> Problem:
        """The whole-body problem. See `PlanningModel`."""
        return whole_body_problem(self.model, numbers or self.numbers, extras)

    def fitted(
        self, hinge: Hinge, margin: float, start: Array, given: Mapping[str, ArrayLike] = NOTHING, door_angle: float | None = None
    ) -> Numbers:  # fmt: skip
        """Numbers of a tip that opens the door, with the hinge as it is known. See `PlanningModel`."""
        known: dict[str, Any] = {"door.rest_angle": self.model.door.rest_angle, "limits.margin": margin}
        numbers = self.numbers
        if door_angle is not None:
            numbers = numbers.replaced(goal_numbers(self.model, door_angle))
        if self.follows_start(given):
            known |= self._fitting(numbers, hinge, start)
        return numbers.replaced({**known, **given})

    def follows_start(self, given: Mapping[str, ArrayLike] = NOTHING) -> bool:
        """Unless all references are given. See `PlanningModel`."""
        return not self._follow_start <= given.keys()

    def _fitting(self, numbers: Numbers, hinge: Hinge, start: Array) -> dict[str, Any]:
        """What depends on hinge and start, by name."""
        model, joint, rate = self.model, float(start[12]), float(start[13])
        ahead, door, lever = model.travel.ahead, model.door, model.coupling.lever_length
        rests = hinge.friction + ahead(hinge.torque_at_rest(joint, door.rest_angle))  # beyond the goal as before it
        against = max(rests + hinge.damping * ahead(rate), 0.0)
        force = float(contact_forces(numbers, model, start[None])[0])
        carried = (against + ahead(door.weight_torque(joint))) / lever
        touches = model.contact.tied > 0.0 or force > _TOUCHES * min(2.0 * self._resting, carried)
        force_in_world = float(touches) * plumb(model, force, joint)
        side = {}
        if model.actuation.fully:
            side = {"actuation.side": (rotation_body_to_world(start[3:6]).T @ force_in_world)[:2]}
        push = -(hinge.torque_at_rest(joint, door.rest_angle) + door.weight_torque(joint)) / lever
        beside = plumb(model, push, joint) - push * door.normal(joint)
        leaf = Leaf(joint, rate, touches, hinge, against, numbers["vehicle.wind"] - beside)
        return {
            **references(model, numbers, leaf, numbers.one("reference.opening_speed")), **side,
            "reference.turned": turned_by(model, rotation_body_to_world(start[3:6]), start[14:], force_in_world),
        }  # fmt: skip

    def goal(self, start: Array, hinge: Hinge, door_angle: float | None = None) -> Array:
        """The scenario's goal: residuals draw to where the leaf is to go, the quadratic cost only keeps equations regular."""
        return self.goal_state

    def normal_forces(self, numbers: Numbers, states: Array, inputs: Array) -> Array:
        """Force of the contact's spring. See `PlanningModel`."""
        return contact_forces(numbers, self.model, states[: len(inputs)])

    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        """State with the tip at the contact point, resting on the leaf or holding it, and moving with it. See `PlanningModel`."""
        x, omega = np.asarray(reduced, dtype=np.float64), np.asarray(body_rates, dtype=np.float64)
        motion = self.model.coupling.vehicle_motion(x, omega, np.zeros(self.model.n_arm))
        pressed = self._rests_at * self.model.door.normal(float(x[3]))
        rates = np.array(euler_rates(x[:3], omega))
        return whole_body_state(motion.position + pressed, x[:3], motion.velocity, rates, x[3], x[4], x[5:])

    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        r"""Attitude, door and arm, and :math:`\Omega = W^{-1}\dot\Phi` in place of what commands it. See `PlanningModel`."""
        x, u = np.array(states, ndmin=2), np.array(inputs, ndmin=2)
        u[:, 1:4] = body_rates_of(x[: len(u), 3:6], x[: len(u), 9:12])
        reduced = x[:, [*_REDUCED, *range(14, x.shape[1])]]
        return (reduced if states.ndim == 2 else reduced[0]), u.reshape(inputs.shape)
