"""Model: everything that follows from a scenario's URDFs, contact and goal."""

from __future__ import annotations

import math
import os

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import number, numbers, vector
from doorman.collision.reduced_model import ReducedModel
from doorman.collision.rows.listed import Surroundings, kinds_of
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.exceptions import DimensionError, ScenarioError
from doorman.kinematics.contact import Contact
from doorman.kinematics.coupling import Coupling, distance_in_doorway
from doorman.kinematics.doors.frame_places import places_to_touch
from doorman.kinematics.doors.joint_friction import joint_friction, with_plants_friction
from doorman.kinematics.doors.reading import read_door, read_travel
from doorman.kinematics.doors.variants.true_door import TrueDoor, is_another
from doorman.kinematics.rotations import regular_state, regular_step
from doorman.kinematics.scale import Scale
from doorman.kinematics.task_numbers import task_numbers
from doorman.kinematics.urdf.document import each_file_once
from doorman.kinematics.urdf.robot import frozen
from doorman.kinematics.vehicles.actuation import actuation_of
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.postures.proposal import propose, start_arm
from doorman.scenario import Scenario
from doorman.scenario.sized import sized

_TOUCHES_A_JAMB = 0.02
"""Depth to which a disc must reach into a jamb for a way to lead there: the check measures it exactly [m]."""
_ROUNDED = 1e-6
"""By which a contact may be off the leaf, as a URDF's numbers are rounded [m]."""
_RIGHT_ANGLE = math.radians(1.0)
"""A leaf that is open by no more beyond 90° leaves its vehicle between the jambs [rad]."""
_RECESSED = 0.02
"""A leaf whose face lies so far behind the frame's is pulled by a vehicle whose disc may be between the jambs [m]."""


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
        self.scenario = scenario = sized(scenario, self._ratios())
        self.contact = Contact.of(scenario)
        """How the tip holds the leaf."""
        self.friction = joint_friction(scenario, self.door, self.hinge_scale)
        """Friction of the plant's joint: one value where a file names it, else an interval [N m]."""
        self.scenario = scenario = _unmeasured(self._with_friction(scenario))
        self.travel = read_travel(scenario, self.door)
        """Where the door is at start and goal."""
        true, contact = scenario.simulation, scenario.contact
        self.true_door = self.door
        """The simulated plant's: `door`, or another one where `[simulation]` says so."""
        if is_another(true):
            self.true_door = TrueDoor(scenario.door_urdf, scenario.door, true, self.door.side, contact)
        self._place = self._contact_place()
        self._check_contact()
        self.n_arm = self.vehicle.n_arm
        self.nx = 5 + self.n_arm
        self.nu = 4 + self.n_arm
        for name, given in (("start.arm", scenario.start.arm), ("goal.arm", scenario.goal.arm)):
            self._check_arm(name, given)
        self.surroundings: Surroundings = self._surroundings()
        """What stands beside the door."""
        self.kinds = kinds_of(self.surroundings, self._reaches_the_lintel())
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
        self.hover_offset = frozen(self._hover_offset())
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

    def _with_friction(self, scenario: Scenario) -> Scenario:
        """The scenario with the plant's friction, where no file names another."""
        if self.friction.known:
            return scenario
        return with_plants_friction(scenario, self.friction.expected / self.door.per_angle)

    def _ratios(self) -> dict[str, float]:
        """Ratios of the defaults that grow with vehicle and door, by unit."""
        size = self.scale
        resists = self.hinge_scale if self.door.in_plane else size.torque  # a lever is shorter than any leaf
        return {
            "force": size.force, "torque": size.torque, "length": size.length, "speed": size.speed, "rate": size.rate,
            "resistance": resists, "stiffness": size.stiffness, "hinge": self.hinge_scale,
        }  # fmt: skip

    def _reduced(self, distance_from_hinge: float) -> ReducedModel:
        numbers = task_numbers(self.vehicle, self.door, distance_from_hinge, self._place[1])
        return ReducedModel(self.vehicle, numbers, self.scenario.planner.time_step, self.kinds)

    def _hover_offset(self) -> Array:
        """Back along the leaf's normal; where that leads into a jamb, straight out of the doorway."""
        door, state, far = self.door, self.start_state, self.scenario.mission.hover_distance
        touch = door.in_doorway(
            self.coupling.vehicle_position(state[:3], float(state[3]), state[5:]) - door.hinge_position
        )
        straight = far * door.away(float(state[3]))
        steps = touch + np.outer(np.linspace(0.0, 1.0, 20), door.in_doorway(straight))
        before = np.maximum(np.maximum(-door.frame_depth - steps[:, 0], steps[:, 0] - door.frame_back), 0.0)
        beside = np.maximum(np.minimum(steps[:, 1], door.width - steps[:, 1]), 0.0)
        free = door.side == "pull" or self.stays_before
        if free or np.hypot(before, beside).min() > self.vehicle.radius - _TOUCHES_A_JAMB:
            return np.asarray(straight)
        middle = 0.5 * door.width
        outside = np.array([-door.frame_depth - self.vehicle.radius - far, middle, touch[2]])
        return np.asarray(door.from_doorway(outside - touch))

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
        if not self.contact.fits or contact.named is not None or not self.door.upright:
            return distance
        arm = start_arm(self.scenario, self.vehicle, self.door, self.travel, self._reduced(distance))
        reach = math.hypot(*self.vehicle.tip_position(arm)[:2])
        room = self.door.width - self.vehicle.radius - self.scenario.planner.margin
        return min(distance, distance_in_doorway(reach, room))

    def _contact_place(self) -> tuple[float, float]:
        """D_V and D_H [m]; without a frame, the middle of a slide's face, and of a hatch's along its hinge."""
        contact, door = self.scenario.contact, self.door
        return door.place_on_face(contact) if door.handle is None else door.handle[:2]

    @property
    def stays_before(self) -> bool:
        """Whether the vehicle stays before wall, panel or face all the way, or nothing stands around the leaf."""
        return self.surroundings in ("wall", "panel", "face", "open")

    def _surroundings(self) -> Surroundings:
        """A vehicle that pulls stays before the wall; one whose tip is near an edge of the leaf begins beside a jamb."""
        if self.door.in_plane:
            return "face"
        if not self.door.framed:
            return "open"
        if not self.door.upright:
            return "wall" if self.door.panel is None else "panel"
        if self.door.side == "pull":
            return "wall" if self.door.frame_depth - self.door.contact_offset < _RECESSED else "corners"
        width, radius = self.door.width, self.vehicle.radius
        behind_the_tip = radius - 1e-9 <= self._place[0] <= width - radius + 1e-9
        between = (behind_the_tip or self.contact.fits) and min(self.travel.start, self.travel.goal) > -_RIGHT_ANGLE
        return "doorway" if between or width < 2.0 * radius else "corners"

    def _reaches_the_lintel(self) -> bool:
        """Whether the disc of a vehicle in the doorway, with its tip on the contact point, could touch the lintel."""
        passes, given = self.surroundings in ("doorway", "corners"), self.scenario.door.frame_height
        if given is not None and not passes:
            raise ScenarioError(
                "the vehicle stays out of the doorway, where no lintel counts", file=self.scenario.source,
                field="door.frame_height", given=given, allowed="none for this task",
            )  # fmt: skip
        arm, ends = self.vehicle.arm, np.abs([self.vehicle.lower_limits, self.vehicle.upper_limits]).max(axis=0)
        reach = np.linalg.norm([*arm.links, arm.point_offsets[-1]], axis=1).sum() + ends[arm.slides].sum()
        rim = self.vehicle.radius * math.sin(self.largest_tilt)
        height = self.door.frame_height if passes else None
        return height is not None and bool(self._place[1] + reach + rim > height)

    def _check_contact(self) -> None:
        door, contact = self.door, self.scenario.contact
        if contact.kind != "push" and self.scenario.simulation.sensors.tip_force:
            raise ScenarioError(
                "only a tip without a gripper has a force sensor", file=self.scenario.source,
                field="simulation.sensors.tip_force", given=True, allowed='false, or contact.kind = "push"',
            )  # fmt: skip
        width, named = min(door.width, self.true_door.width), contact.named is not None
        if door.slides:
            return  # in the middle of its face, or at a frame that it carries
        for field, given, limit, what in (
            ("contact.distance_from_hinge", self._place[0], width, "the leaf's width"),
            ("contact.height", self._place[1], door.height, "the leaf's height"),
        ):
            if not -_ROUNDED <= given <= limit + _ROUNDED:
                field = f"contact.{contact.named}" if named else field
                raise ScenarioError(
                    "the contact point is off the leaf", file=self.scenario.source, field=field, given=given,
                    allowed=f"at most {limit:g} m, {what}",
                )  # fmt: skip


def _unmeasured(scenario: Scenario) -> Scenario:
    """The scenario with what whole-body plans of a grip count on where no hover measures it: before a start in contact.

    The attitude loop is the plant's. Thrust is as commanded: a held tip bears any force, so no motion tells lift from that.
    """
    in_the_grip = scenario.mission.start == "contact" and scenario.contact.kind == "grip"
    if not in_the_grip or scenario.planner.model != "whole_body":
        return scenario
    true, vehicle, estimation = scenario.simulation, scenario.vehicle, scenario.estimation
    loop = {"attitude_lag": true.attitude_lag, "attitude_dead_time": true.attitude_dead_time}
    believed = {key: value for key, value in loop.items() if key not in vehicle.model_fields_set}
    lift = {} if "lift" in estimation.start.model_fields_set else {"lift": estimation.noise.lift}
    start = estimation.start.model_copy(update=lift)
    return scenario.model_copy(update={
        "vehicle": vehicle.model_copy(update=believed), "estimation": estimation.model_copy(update={"start": start}),
    })  # fmt: skip
