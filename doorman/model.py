"""Model: everything that follows from a scenario's URDFs, contact and goal."""

from __future__ import annotations

import math
import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import number, numbers, vector
from doorman.collision.constraints import (
    ConstraintParameters,
    collision_constraints,
    collision_constraints_batch,
    collision_constraints_jacobian,
)
from doorman.copying import PerThread
from doorman.dynamics.quasi_static import (
    N_ENTRIES,
    QuasiStaticParameters,
    quasi_static_rates,
    quasi_static_step,
    quasi_static_step_jacobian,
)
from doorman.exceptions import DimensionError, ScenarioError, SingularityError, UrdfError
from doorman.kinematics.arm import ArmParameters
from doorman.kinematics.coupling import Coupling, distance_in_doorway
from doorman.kinematics.door import Door
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
        self._own_constraints: PerThread[ConstraintParameters] = PerThread()
        self._own_dynamics: PerThread[QuasiStaticParameters] = PerThread()
        self.vehicle = Vehicle(scenario.vehicle_urdf, scenario.vehicle)
        self.door = Door(scenario.door_urdf, scenario.door)
        self.true_door = self._true_door()
        """The simulated plant's: `door`, or another width of it."""
        self._check_contact()
        contact = scenario.contact
        self.n_arm = self.vehicle.n_arm
        self.nx = 5 + self.n_arm
        self.nu = 4 + self.n_arm
        for name, given in (("start.arm", scenario.start.arm), ("goal.arm", scenario.goal.arm)):
            self._check_arm(name, given)
        self.constraint_names = (*(f"{name} below body" for name in self.vehicle.point_names), "disc clear of leaf",
                                 "disc clear of latch jamb", "disc clear of hinge jamb")  # fmt: skip
        self.coupling = Coupling(self.vehicle, self.door, self._distance_from_hinge(), contact.height)
        postures = propose(scenario, self.vehicle, self._constraint_parameters)
        self.proposed = postures.proposed
        """What the scenario leaves open, by its keys: `start.attitude`, `start.arm`, `goal.attitude`, `goal.arm` [rad]."""
        self.start_state, self.goal_state = frozen(postures.start), frozen(postures.goal)
        self.start_arm, self.goal_arm = frozen(self.start_state[5:]), frozen(self.goal_state[5:])
        self.vehicle_inertia = frozen(self.vehicle.inertia(self.goal_arm))
        self.hover_input = frozen([self.vehicle.mass * GRAVITY, *np.zeros(3 + self.n_arm)])

    @property
    def _constraint_parameters(self) -> ConstraintParameters:
        return self._own_constraints.get(self.constraint_parameters)

    @property
    def _dynamics_parameters(self) -> QuasiStaticParameters:
        return self._own_dynamics.get(self.dynamics_parameters)

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
        x = vector(state, self.nx, field)
        if abs(x[1]) >= math.pi / 2 - 1e-6:
            raise SingularityError(
                "Euler rates are singular", field=f"{field}[1] (pitch)", given=float(x[1]), allowed="|pitch| < π/2"
            )
        return x

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
        h = np.empty(self.n_constraints)
        collision_constraints(self._constraint_parameters, vector(state, self.nx, "state"), h)
        return h

    def constraint_jacobian(self, state: ArrayLike) -> Array:
        """Jacobian of `constraints`.

        Args:
            state: x, shape (5 + n,).

        Returns:
            Shape (n + 2, 5 + n).

        Raises:
            DimensionError: if the state has another shape or is not finite.
        """
        h, jacobian = np.empty(self.n_constraints), np.zeros((self.n_constraints, self.nx))
        collision_constraints_jacobian(self._constraint_parameters, vector(state, self.nx, "state"), h, jacobian)
        return jacobian

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
        h = np.empty((len(x), self.n_constraints))
        collision_constraints_batch(self._constraint_parameters, x, h)
        return h

    def derivative(self, state: ArrayLike, inputs: ArrayLike) -> Array:
        """Time derivative of the quasi-static model.

        Args:
            state: x, shape (5 + n,).
            inputs: u, shape (4 + n,).

        Returns:
            ẋ, shape (5 + n,).
        """
        x, u = self.check_state(state), vector(inputs, self.nu, "inputs")
        roll_rate, pitch_rate, yaw_rate, acceleration = quasi_static_rates(self._dynamics_parameters, *x[:5], *u[:4])
        return np.array([roll_rate, pitch_rate, yaw_rate, x[4], acceleration, *u[4:]])

    def step(self, state: ArrayLike, inputs: ArrayLike) -> Array:
        """One RK4 step of the quasi-static model over `planner.time_step`.

        Args:
            state: x, shape (5 + n,).
            inputs: u, shape (4 + n,).

        Returns:
            The next state, shape (5 + n,).
        """
        out = np.empty(self.nx)
        quasi_static_step(self._dynamics_parameters, self.check_state(state), vector(inputs, self.nu, "inputs"), out)
        if np.isnan(out[1]):
            raise SingularityError(
                "the step leads through the singularity of the Euler rates", field="next state[1] (pitch)",
                allowed="|pitch| < π/2",
            )  # fmt: skip
        return out

    def step_jacobian(self, state: ArrayLike, inputs: ArrayLike) -> tuple[Array, Array]:
        """Exact sensitivities A, B of `step`.

        Args:
            state: x, shape (5 + n,).
            inputs: u, shape (4 + n,).

        Returns:
            A of shape (5 + n, 5 + n) and B of shape (5 + n, 4 + n).
        """
        out = np.empty((self.nx, self.nx + self.nu))
        quasi_static_step_jacobian(
            self._dynamics_parameters, self.check_state(state), vector(inputs, self.nu, "inputs"), out
        )
        return out[:, : self.nx].copy(), out[:, self.nx :].copy()

    def dynamics_parameters(self, disturbance: float = 0.0) -> QuasiStaticParameters:
        """Fresh parameters of the quasi-static kernels, with their own scratch memory.

        Args:
            disturbance: τ_d, a further torque in the sense of damping [N m].
        """
        door = self.door
        return QuasiStaticParameters(
            time_step=self.scenario.planner.time_step,
            distance_from_hinge=self.coupling.distance_from_hinge,
            door_inertia=door.inertia,
            damping=door.damping,
            friction=door.friction,
            friction_rate=door.friction_rate,
            stiffness=door.stiffness,
            rest_angle=door.rest_angle,
            disturbance=number(disturbance, "disturbance"),
            entries=np.zeros(N_ENTRIES),
        )

    def constraint_parameters(self, lanes: int = 0) -> ConstraintParameters:
        """Fresh parameters of the constraint kernels, with their own scratch memory, for states side by side if lanes > 0."""
        return self._parameters_at(self.coupling.distance_from_hinge, lanes)

    def _parameters_at(self, distance_from_hinge: float, lanes: int = 0) -> ConstraintParameters:
        return ConstraintParameters(
            radius=self.vehicle.radius,
            distance_from_hinge=distance_from_hinge,
            door_width=self.door.width,
            arm=ArmParameters.of(self.vehicle.arm, lanes),
        )

    def _true_door(self) -> Door:
        width = self.scenario.simulation.door_width
        if width is None:
            return self.door
        try:
            return Door(self.scenario.door_urdf, self.scenario.door.model_copy(update={"width": width}))
        except UrdfError as error:
            error.field = "simulation.door_width"
            raise

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
        parameters = self._parameters_at(contact.distance_from_hinge)
        reach = math.hypot(*self.vehicle.tip_position(start_arm(self.scenario, self.vehicle, parameters))[:2])
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
