"""Model: everything that follows from a scenario's URDFs, contact and goal."""

from __future__ import annotations

import math
import os

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array, frozen
from doorman.checks import number, numbers, vector
from doorman.collision.reduced_model import ReducedModel
from doorman.collision.rows.listed import Surroundings, kinds_of
from doorman.collision.surroundings import (
    check_contact,
    hover_offset,
    reaches_the_lintel,
    stays_before,
    surroundings_of,
)
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.exceptions import DimensionError, ScenarioError
from doorman.kinematics.contact import Contact
from doorman.kinematics.coupling import Coupling, distance_before_doorway, distance_in_doorway
from doorman.kinematics.doors.frame_places import places_to_touch
from doorman.kinematics.doors.joint_friction import joint_friction, with_plants_friction
from doorman.kinematics.doors.reading import read_door, read_travel
from doorman.kinematics.doors.variants.true_door import TrueDoor, is_another
from doorman.kinematics.rotations import regular_state, regular_step
from doorman.kinematics.scale import Scale
from doorman.kinematics.task_numbers import task_numbers
from doorman.kinematics.urdf.document import each_file_once
from doorman.kinematics.vehicles.actuation import actuation_of
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.postures.proposal import propose, start_arm
from doorman.scenario import Scenario
from doorman.scenario.sized import sized, unmeasured


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

    @each_file_once()
    def __init__(self, scenario: Scenario | str | os.PathLike[str]) -> None:
        self.scenario = scenario = Scenario.of(scenario)
        self.vehicle = Vehicle(scenario.vehicle_urdf, scenario.vehicle)
        self.scale = Scale.of(self.vehicle.radius, self.vehicle.mass)
        """Ratios of the vehicle's units to the shipped one's, for which defaults are tuned."""
        self.door = read_door(scenario)
        self.hinge_scale = self.scale.hinge(self.door)
        """Ratio of the torques that this hinge is expected to resist with to those of a room door."""
        self.ratios = self._ratios()
        """Ratios of the numbers that grow with vehicle and door, by unit."""
        self.scenario = scenario = sized(scenario, self.ratios)
        self.contact = Contact.of(scenario)
        """How the tip holds the leaf."""
        self.friction = joint_friction(scenario, self.door, self.hinge_scale)
        """Friction of the plant's joint: one value where a file names it, else an interval [N m]."""
        if not self.friction.known:
            scenario = with_plants_friction(scenario, self.friction.expected / self.door.per_angle)
        self.scenario = scenario = unmeasured(scenario)
        self.travel = read_travel(scenario, self.door)
        """Where the door is at start and goal."""
        true, contact = scenario.simulation, scenario.contact
        self.true_door = self.door
        """The simulated plant's: `door`, or another one where `[simulation]` says so."""
        if is_another(true):
            self.true_door = TrueDoor(scenario.door_urdf, scenario.door, true, self.door.side, contact)
        self._place = self._contact_place()
        check_contact(scenario, self.door, min(self.door.width, self.true_door.width), self._place)
        self.n_arm = self.vehicle.n_arm
        self.nx = 5 + self.n_arm
        self.nu = 4 + self.n_arm
        for name, given in (("start.arm", scenario.start.arm), ("goal.arm", scenario.goal.arm)):
            self._check_arm(name, given)
        self.surroundings: Surroundings = surroundings_of(
            self.door, self.contact, self.travel, self._place[0], self.vehicle.radius
        )
        """What stands beside the door."""
        lintel = reaches_the_lintel(
            scenario, self.vehicle, self.door, self.surroundings, self._place[1], self.largest_tilt
        )
        self.kinds = kinds_of(self.surroundings, lintel)
        """Kinds of this task's collision constraints."""
        self.coupling = Coupling(self.vehicle, self.door, self._distance_from_hinge(), self._place[1])
        self.turn_scale = self.scale.turned(self.door, self.coupling.lever_length)
        """Ratio of the angles by which the same way of the tip turns this mechanism and a leaf: a lever is short."""
        self.reduced = self._reduced(self.coupling.distance_from_hinge)
        """Dynamics and constraints in numbers; parameters of the kernels by name."""
        self.constraint_names = self.reduced.row_names
        postures = propose(scenario, self.vehicle, self.door, self.travel, self.reduced)
        self.proposed = postures.proposed
        """What the scenario leaves open, by its keys: `start.attitude`, `start.arm`, `goal.attitude`, `goal.arm` [rad]."""
        self.start_state, self.goal_state = frozen(postures.start), frozen(postures.goal)
        far = scenario.mission.hover_distance
        self.hover_offset = frozen(hover_offset(self.coupling, self.start_state, far, self.surroundings))
        """From where the tip touches the leaf in the start posture to the hover before the door, shape (3,), world frame [m]."""
        self.start_arm, self.goal_arm = frozen(self.start_state[5:]), frozen(self.goal_state[5:])
        reach = math.hypot(*self.vehicle.tip_position(self.start_arm)[:2])
        opening = self.door.opening_of(self.start_angle)
        self.frame_places = places_to_touch(scenario, self.door, self._place[1], reach, self.vehicle.radius, opening)
        """Where the tip touches what stands beside the leaf, before the leaf itself, if it does."""
        self.vehicle_inertia = frozen(self.vehicle.inertia(self.goal_arm))
        self.actuation = actuation_of(self.vehicle, scenario.simulation.torque_per_thrust)
        """How the vehicle makes a force: with a tilted thrust, or with a level body."""
        self.attitude_loop = AttitudeLoop(scenario.vehicle.attitude_lag, scenario.vehicle.attitude_dead_time)
        """How roll and pitch follow what is commanded."""
        self.hover_input = frozen([self.vehicle.weight, *np.zeros(3 + self.n_arm)])

    @property
    def start_angle(self) -> float:
        """α at the start [rad]."""
        return float(self.start_state[3])

    @property
    def goal_angle(self) -> float:
        """α at the goal [rad]."""
        return float(self.goal_state[3])

    @property
    def start_yaw(self) -> float:
        """ψ at the start [rad]."""
        return float(self.start_state[2])

    @property
    def largest_tilt(self) -> float:
        """Largest tilt of the body that limits and controller allow [rad]."""
        limits, most = self.scenario.limits, self.scenario.control.max_tilt
        return min(limits.tilt, most) if limits.enabled else most

    @property
    def n_constraints(self) -> int:
        """Number of rows of h: n + 2 for an arm of n ≥ 2 joints in a doorway."""
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
        return np.asarray(last + (1.0 - self.travel.share(door_angle)) * (first - last))

    def check_state(self, state: ArrayLike, field: str = "state") -> Array:
        """A state as a contiguous float array.

        Args:
            state: x, shape (5 + n,).
            field: Name of the argument, for the error.

        Returns:
            Shape (5 + n,).

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

    def _ratios(self) -> dict[str, float]:
        size = self.scale
        resists = self.hinge_scale if self.door.in_plane else size.torque  # a lever is shorter than any leaf
        return {
            "force": size.force, "torque": size.torque, "length": size.length, "speed": size.speed, "rate": size.rate,
            "resistance": resists, "stiffness": size.stiffness, "hinge": self.hinge_scale,
        }  # fmt: skip

    def _reduced(self, distance_from_hinge: float) -> ReducedModel:
        numbers = task_numbers(self.vehicle, self.door, distance_from_hinge, self._place[1])
        return ReducedModel(self.vehicle, numbers, self.scenario.planner.time_step, self.kinds)

    def _check_arm(self, field: str, given: tuple[float, ...] | None) -> None:
        n = self.vehicle.n_arm
        if given is not None and len(given) != n:
            raise ScenarioError(
                "wrong number of joint angles", file=self.scenario.source, field=field, given=len(given),
                allowed=f"{n}, the joints {', '.join(self.vehicle.joint_names)}",
            )  # fmt: skip

    def _distance_from_hinge(self) -> float:
        """D_V [m]."""
        contact, distance = self.scenario.contact, self._place[0]
        door, radius = self.door, self.vehicle.radius
        before = (
            self.contact.tied > 0.0 and door.side == "pull" and "distance_from_hinge" not in contact.model_fields_set
        )
        if not ((self.contact.fits or before) and door.upright and door.framed) or contact.named is not None:
            return distance
        arm = start_arm(self.scenario, self.vehicle, door, self.travel, self._reduced(distance))
        reach = math.hypot(*self.vehicle.tip_position(arm)[:2])
        if before:
            return min(
                distance, distance_before_doorway(reach + door.contact_offset - door.frame_depth, door.width, radius)
            )
        return min(distance, distance_in_doorway(reach, door.width - radius - self.scenario.planner.margin))

    def _contact_place(self) -> tuple[float, float]:
        """D_V and D_H [m]; without a frame, the middle of a slide's face, and of a hatch's along its hinge."""
        contact, door = self.scenario.contact, self.door
        return door.place_on_face(contact) if door.handle is None else door.handle[:2]

    @property
    def stays_before(self) -> bool:
        """Whether the vehicle stays before wall, panel or face all the way, or nothing stands around the leaf."""
        return stays_before(self.surroundings)
