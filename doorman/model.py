"""Model: everything that follows from a scenario's URDFs, contact and goal."""

from __future__ import annotations

import math
import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import number, numbers, vector
from doorman.collision.constraint_names import arm_constraint_names
from doorman.collision.reduced_model import ReducedModel
from doorman.exceptions import DimensionError, ScenarioError
from doorman.kinematics.coupling import Coupling, distance_in_doorway
from doorman.kinematics.door import Door
from doorman.kinematics.rotations import regular_state, regular_step
from doorman.kinematics.task_numbers import task_numbers
from doorman.kinematics.true_door import TrueDoor, is_another
from doorman.kinematics.urdf import frozen
from doorman.kinematics.vehicle import GRAVITY as GRAVITY
from doorman.kinematics.vehicle import Vehicle
from doorman.postures.proposal import propose, start_arm
from doorman.scenario import Scenario

Array = NDArray[np.float64]


class Model:
    """Vehicle and door of a scenario, tied together at the contact point.

    Threads may share it: the kernels behind its methods write to memory of the thread's own.

    States are x = [φ, θ, ψ, α, α̇, η_1 … η_n], inputs u = [f_t, Ω, Ḣ_d]; shapes (5 + n,) and (4 + n,).

    Args:
        scenario: The scenario, the name of a shipped one, or the path of a TOML file.

    Raises:
        UrdfError: if a URDF is unusable.
        ScenarioError: if the scenario's vectors do not fit the arm, or the contact point is off the leaf.
    """

    def __init__(self, scenario: Scenario | str | os.PathLike[str]) -> None:
        self.scenario = scenario = Scenario.of(scenario)
        self.vehicle = Vehicle(scenario.vehicle_urdf, scenario.vehicle)
        self.door = Door(scenario.door_urdf, scenario.door)
        true = scenario.simulation
        self.true_door = TrueDoor(scenario.door_urdf, scenario.door, true) if is_another(true) else self.door
        """The simulated plant's: `door`, or another one where `[simulation]` says so."""
        self._check_contact()
        contact = scenario.contact
        self.n_arm = self.vehicle.n_arm
        self.nx = 5 + self.n_arm
        self.nu = 4 + self.n_arm
        for name, given in (("start.arm", scenario.start.arm), ("goal.arm", scenario.goal.arm)):
            self._check_arm(name, given)
        self.constraint_names = (*arm_constraint_names(self.vehicle.point_names, self.vehicle.arm.above), "disc clear of leaf",
                                 "disc clear of latch jamb", "disc clear of hinge jamb")  # fmt: skip
        self.coupling = Coupling(self.vehicle, self.door, self._distance_from_hinge(), contact.height)
        self.reduced = self._reduced(self.coupling.distance_from_hinge)
        """Dynamics and constraints in numbers; parameters of the kernels by name."""
        postures = propose(scenario, self.vehicle, self.door, self.reduced)
        self.proposed = postures.proposed
        """What the scenario leaves open, by its keys: `start.attitude`, `start.arm`, `goal.attitude`, `goal.arm` [rad]."""
        self.start_state, self.goal_state = frozen(postures.start), frozen(postures.goal)
        self.start_arm, self.goal_arm = frozen(self.start_state[5:]), frozen(self.goal_state[5:])
        self.vehicle_inertia = frozen(self.vehicle.inertia(self.goal_arm))
        self.hover_input = frozen([self.vehicle.mass * GRAVITY, *np.zeros(3 + self.n_arm)])

    @property
    def n_constraints(self) -> int:
        """Number of rows of h: n + 2 for an arm of n ≥ 2 joints."""
        return len(self.constraint_names)

    def on_the_way(self, door_angle: float) -> Array:
        """State at rest between start and goal whose heading and arm keep step with the door.

        Args:
            door_angle: α; beyond start and goal, it is theirs [rad].

        Returns:
            x, shape (5 + n,).
        """
        first, last = self.start_state, self.goal_state
        door_angle = number(door_angle, "door_angle")
        done = min(max((first[3] - door_angle) / (first[3] - last[3]), 0.0), 1.0)
        return np.asarray(last + (1.0 - done) * (first - last))

    def check_state(self, state: ArrayLike, field: str = "state") -> Array:
        """A state as a contiguous float array.

        Raises:
            DimensionError: if it has another shape than (5 + n,) or is not finite.
            SingularityError: if the pitch is not inside ±90°.
        """
        return regular_state(state, self.nx, field)

    def constraints(self, state: ArrayLike) -> Array:
        """Analytic collision constraints h(x); h ≤ 0 is allowed (design equations 1 to 3, in that order).

        Args:
            state: x, shape (5 + n,).

        Returns:
            h, shape (n + 2,) [m]: height of S³ … Sⁿ and tip in the body, disc against leaf, disc against latch jamb, disc
            against hinge jamb.

        Raises:
            DimensionError: if the state has another shape or is not finite.
        """
        return self.reduced.constraints(vector(state, self.nx, "state"))

    def constraint_jacobian(self, state: ArrayLike) -> Array:
        """Jacobian of `constraints`.

        Args:
            state: x, shape (5 + n,).

        Returns:
            Shape (n + 2, 5 + n).

        Raises:
            DimensionError: if the state has another shape or is not finite.
        """
        return self.reduced.constraint_jacobian(vector(state, self.nx, "state"))

    def constraints_along(self, states: ArrayLike) -> Array:
        """`constraints` at many states.

        Args:
            states: Shape (m, 5 + n).

        Returns:
            Shape (m, n + 2) [m].

        Raises:
            DimensionError: if the array has another shape.
        """
        x = numbers(states, "states", f"shape (m, {self.nx})")
        if x.ndim != 2 or x.shape[1] != self.nx:
            raise DimensionError("wrong shape", field="states", given=x.shape, allowed=f"(m, {self.nx})")
        return self.reduced.constraints_along(x)

    def derivative(self, state: ArrayLike, inputs: ArrayLike) -> Array:
        """Time derivative of the quasi-static model.

        Args:
            state: x, shape (5 + n,).
            inputs: u, shape (4 + n,).

        Returns:
            ẋ, shape (5 + n,).
        """
        return self.reduced.derivative(self.check_state(state), vector(inputs, self.nu, "inputs"))

    def step(self, state: ArrayLike, inputs: ArrayLike) -> Array:
        """One RK4 step of the quasi-static model over `planner.time_step`.

        Args:
            state: x, shape (5 + n,).
            inputs: u, shape (4 + n,).

        Returns:
            The next state, shape (5 + n,).
        """
        return regular_step(self.reduced.step(self.check_state(state), vector(inputs, self.nu, "inputs")))

    def step_jacobian(self, state: ArrayLike, inputs: ArrayLike) -> tuple[Array, Array]:
        """Exact sensitivities A, B of `step`.

        Args:
            state: x, shape (5 + n,).
            inputs: u, shape (4 + n,).

        Returns:
            A of shape (5 + n, 5 + n) and B of shape (5 + n, 4 + n).
        """
        out = self.reduced.step_jacobian(self.check_state(state), vector(inputs, self.nu, "inputs"))
        return out[:, : self.nx].copy(), out[:, self.nx :].copy()

    def _reduced(self, distance_from_hinge: float) -> ReducedModel:
        numbers = task_numbers(self.vehicle, self.door, distance_from_hinge, self.scenario.contact.height)
        return ReducedModel(self.vehicle, numbers, self.scenario.planner.time_step)

    def _check_arm(self, field: str, given: tuple[float, ...] | None) -> None:
        n = self.vehicle.n_arm
        if given is not None and len(given) != n:
            raise ScenarioError(
                "wrong number of joint angles", file=self.scenario.source, field=field, given=len(given),
                allowed=f"{n}, the joints {', '.join(self.vehicle.joint_names)}",
            )  # fmt: skip

    def _distance_from_hinge(self) -> float:
        """D_V [m]."""
        contact = self.scenario.contact
        if contact.kind != "push" or not contact.fit_doorway:
            return contact.distance_from_hinge
        reduced = self._reduced(contact.distance_from_hinge)
        reach = math.hypot(*self.vehicle.tip_position(start_arm(self.scenario, self.vehicle, self.door, reduced))[:2])
        room = self.door.width - self.vehicle.radius - self.scenario.planner.margin
        return min(contact.distance_from_hinge, distance_in_doorway(reach, room))

    def _check_contact(self) -> None:
        contact, door = self.scenario.contact, self.door
        width = min(door.width, self.true_door.width)
        for field, given, limit, what in (
            ("contact.distance_from_hinge", contact.distance_from_hinge, width, "the leaf's width"),
            ("contact.height", contact.height, door.height, "the leaf's height"),
        ):
            if given > limit:
                raise ScenarioError(
                    "the contact point is off the leaf", file=self.scenario.source, field=field, given=given,
                    allowed=f"at most {limit:g} m, {what}",
                )  # fmt: skip
