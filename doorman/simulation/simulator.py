"""Simulator: plant and onboard loop together, advanced by physics steps, and the truth about them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array, sealed
from doorman.compilation import entry
from doorman.copying import Uncopied
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.exceptions import BackendError
from doorman.kinematics.rotations import SMALLEST_COSINE, quaternion_of
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.model import Model
from doorman.numba_types.handles import held
from doorman.simulation.delay_line import DelayLine
from doorman.simulation.plant.engine import check_stability, engine
from doorman.simulation.plant.gripper import TOUCH, ContactReader, Gripper
from doorman.simulation.plant.hinge_torques import HingeTorques
from doorman.simulation.plant.onboard.attitude_loop import AttitudeGains
from doorman.simulation.plant.parameters import step_parameters
from doorman.simulation.plant.plant import Plant, build_plant
from doorman.simulation.plant.stepping import State, look, take_steps
from doorman.simulation.reality.drag import Drag
from doorman.simulation.reality.latch import Latch
from doorman.simulation.reality.true_thrust import true_thrust
from doorman.simulation.truth import Truth


@dataclass(frozen=True)
class Disturbance:
    """What acts on the plant beside rotors, servos and contact."""

    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """At the base link's centre of mass, world frame [N]."""
    torque: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """On the base link, world frame [N m]."""
    hinge_torque: float = 0.0
    """On the leaf about the hinge, positive for growing α [N m]."""


DisturbanceSource = Callable[[float], Disturbance]
"""Disturbance at a time [s], called at every physics step."""


class Simulator(Uncopied):
    """Physics and onboard loop of one flight, beginning at the start of the scenario.

    Args:
        model: The model.
        time_step: Of the physics [s].
        disturbance: What else acts on the plant.
        gains: Of the attitude loop; those of `simulation.attitude_*` if not given.
        after: Simulator of the step before: this one begins where that one has ended, with the tip still on the handle.

    Raises:
        BackendError: if MuJoCo is missing or cannot build the plant, or the rotors cannot steer.
    """

    def __init__(
        self,
        model: Model,
        time_step: float,
        disturbance: DisturbanceSource | None = None,
        gains: AttitudeGains | None = None,
        after: Simulator | None = None,
    ) -> None:
        self.model = model
        self.time_step = time_step
        self._disturbance = disturbance
        self._mujoco = engine()
        self.layout = rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)
        self.plant = build_plant(self._mujoco, model, self.layout, time_step)
        data, true = self.plant.data, model.scenario.simulation
        self._gripper = Gripper(self._mujoco, self.plant, true.gripper_force)
        at_door = model.scenario.mission.start == "contact"
        if self._gripper.closed and not at_door:
            self._gripper.set(False)
        self._contacts = ContactReader(self._mujoco, self.plant, self._gripper)
        self._hinge = HingeTorques(model, self.plant)
        self._tip_on_frame = _tip_on_frame(self.plant)
        gains = gains or simulated_gains(model)
        self._state = np.zeros(12 + 2 * model.n_arm + self.layout.count)
        self._own = step_parameters(
            self._mujoco, model, self.plant, self.layout, time_step, gains, self._hinge.numbers, self._state
        )
        steps = round(gains.dead_time / time_step)
        self._late = DelayLine[tuple[float, float, float, float]](steps)
        self._stepping = held(self._own)
        self._command, self._noted = self._own.onboard.command, self._own.noted
        self._command.thrust = model.vehicle.weight
        self._command.attitude[:] = quaternion_of(model.start_state[:3])
        self._thrust = true_thrust(model, self.plant, self.layout)
        resisted = true.vehicle_drag > 0.0 or true.wash.wall > 0.0
        self._drag = Drag(model, self.plant, self.layout) if resisted else None
        self._strains = true.gripper_force is not None
        latched = model.scenario.door.latch is not None and model.scenario.door.beside
        self._latch = Latch(model, self.plant.engine_model, data) if latched else None
        varies = disturbance, self._thrust, self._drag, true.gripper_force, self._hinge.vary or None, self._latch
        self._at_once = all(each is None for each in varies)
        """Whether a step needs nothing from Python."""
        self._wrench = data.xfrc_applied[self.plant.base_body]
        self._warnings = data.warning.number  # a view, which takes long to get
        self._outer_force = 0.0
        self._steps = 0
        if after is not None:
            self._go_on(after)
        self._hinge.act()
        self._begin_interval()
        self._note_contacts(data.qpos.item(self.plant.hinge_position))
        self._take_steps, self._look = entry(take_steps, self._stepping, 0), entry(look, self._stepping)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * self.time_step

    def set_command(
        self, thrust: float, attitude: ArrayLike, arm_rates: ArrayLike, side_force: ArrayLike = (0.0, 0.0)
    ) -> None:
        """Set what the onboard loop follows from the next physics step on; the attitude only when its dead time has passed.

        Args:
            thrust: f_t [N].
            attitude: Φ_d, shape (3,) [rad].
            arm_rates: Ḣ_d, shape (n,) [rad/s].
            side_force: Body force along x and y, shape (2,) [N]; rotors that cannot make it take no notice.
        """
        self._command.thrust = thrust
        self._late.send(self._steps, quaternion_of(attitude))
        self._steps_until_attitude(1)
        self._command.side[:] = side_force
        self._own.onboard.arm_rates[:] = arm_rates

    def _go_on(self, before: Simulator) -> None:
        """Begin with the plant as another one has left it; the tip holds what it held there."""
        data, last = self.plant.data, before.plant.data
        self._gripper.set(False)
        for name in ("qpos", "qvel", "act", "ctrl"):
            getattr(data, name)[:] = getattr(last, name)
        own, last_own = self._own.onboard, before._own.onboard
        own.command.assign(last_own.command)
        own.arm_rates[:] = last_own.arm_rates
        own.attitude.memory.assign(last_own.attitude.memory)
        own.servos.integral[:] = last_own.servos.integral
        self._late = before._late.shifted(before._steps)
        self._mujoco.mj_forward(self.plant.engine_model, data)
        self._gripper.set(before._gripper.closed)
        self._mujoco.mj_forward(self.plant.engine_model, data)  # with the tie, whose force is read next

    def set_rotors(self, thrusts: Array | None, directions: Array | None = None) -> None:
        """Let another autopilot fly: its set points of the rotors, from the next physics step on, instead of the onboard loop's.

        Args:
            thrusts: Shape (m,) [N]; None lets the onboard loop fly again.
            directions: Senses in which its rotors turn, +1 counter-clockwise seen from above, shape (m,); None
                leaves them as they are.
        """
        self._own.rotors[:] = np.nan if thrusts is None else thrusts
        if directions is not None:
            gears = self.plant.engine_model.actuator_gear
            gears[: self.layout.count, 5] = -directions * self.layout.torque_per_thrust
            if self._thrust is not None:
                self._thrust.turn(directions)

    def set_grip(self, closed: bool) -> None:
        """Let the tip hold on to the leaf where it touches, or let go.

        Args:
            closed: What is wanted; see `Gripper`.
        """
        self._gripper.set(closed)

    def advance(self, steps: int) -> None:
        """Advance the physics, and note contacts on the way.

        Args:
            steps: Number of physics steps.

        Raises:
            BackendError: if the physics became unstable.
        """
        self._begin_interval()
        while steps > 0:
            if not self._at_once:
                self._act()
            taken, collides = self._take_steps(
                self._stepping, self._steps_until_attitude(steps if self._at_once else 1)
            )
            self._steps += taken
            steps -= taken
            if collides:
                self._note_contacts(self._noted.hinge_before)
            elif self._strains:
                self._gripper.strain(self._noted.force, self._normal(self._noted.hinge_before))
        if any(self._warnings.tolist()):
            check_stability(self._mujoco, self.plant.data)

    def _steps_until_attitude(self, most: int) -> int:
        """Let attitudes act whose dead time has passed; returns for how many steps, up to a number, no other does."""
        if (attitude := self._late.arrived(self._steps)) is not None:
            self._command.attitude[:] = attitude
        return int(min(self._late.due - self._steps, most))

    def truth(self) -> Truth:
        """State now, and contacts since the last call of `advance` began.

        Raises:
            BackendError: if the vehicle has pitched to ±90°, where Euler angles are singular.
        """
        if not self._look(self._stepping) >= SMALLEST_COSINE:
            raise BackendError(
                "the vehicle has turned over: Euler angles are singular", field="attitude",
                given=f"time {self.time:.3f} s",
            )  # fmt: skip
        plant, state, noted = self.plant, State.of(sealed(self._state.copy()), self.model.n_arm), self._noted.snapshot()
        force, closed, door, engine = sealed(noted.force), self._gripper.closed, plant.hinge, self._own.engine
        return Truth(
            time=self.time,
            position=state.position,
            velocity=state.velocity,
            attitude=state.attitude,
            body_rates=state.body_rates,
            door_angle=door.angle_of_joint(engine.qpos.item(plant.hinge_position)),
            door_rate=door.joint_rate(engine.qvel.item(plant.hinge_velocity)),
            arm_angles=state.arm_angles,
            arm_rates=state.arm_rates,
            tip_force=force,
            tip_normal_force=noted.along,
            touching=closed or max(map(abs, force.tolist())) > TOUCH,
            max_pull=noted.max_pull,
            collisions=self._collisions,
            collision_pairs=tuple(sorted({" and ".join(map(plant.shape_name, pair)) for pair in self._pairs})),
            only_tip_on_frame=bool(self._pairs) and self._pairs <= self._tip_on_frame,
            rotor_thrusts=state.thrusts,
            max_push=noted.max_push,
            gripping=closed,
            grip_slips=self._gripper.slips,
            outer_force=self._outer_force,
        )

    def _begin_interval(self) -> None:
        self._noted.max_pull = self._noted.max_push = 0.0
        self._collisions = 0
        self._pairs: set[tuple[int, int]] = set()

    def _note_contacts(self, hinge_value: float) -> None:
        """Take in the contacts of a step that began with the hinge at this value, one by one."""
        forces, normal = self._contacts.read(), self._normal(hinge_value)
        along = float(normal @ forces.tip)
        noted = self._noted
        noted.force, noted.along = forces.tip, along
        noted.max_pull, noted.max_push = np.maximum((noted.max_pull, noted.max_push), (-along, along))
        self._gripper.strain(forces.tip, normal)
        if forces.others:
            self._collisions = max(self._collisions, len(forces.others))
            self._pairs.update(forces.others)

    def _normal(self, hinge_value: float) -> Array:
        return self.plant.hinge.normal(self.plant.hinge.angle_of_joint(hinge_value))

    def _act(self) -> None:
        """Before a step: what acts on the plant and changes from one to the next."""
        other = 0.0
        if self._disturbance is not None:
            acting = self._disturbance(self.time)
            self._wrench[:] = (*acting.force, *acting.torque)
            other = self.plant.hinge.joint_torque(acting.hinge_torque)
            self._outer_force = math.hypot(*acting.force)
        if self._thrust is not None:
            self._thrust.act(self.time)
        if self._drag is not None:
            self._drag.act()
        self._hinge.act(other)
        if self._latch is not None:
            self._latch.act()


def simulated_gains(model: Model, feedback: float = 0.0) -> AttitudeGains:
    """Gains of the simulated vehicle's true loop; of one with feed-forward if the autopilot's feedback has such a lag [s]."""
    true = model.scenario.simulation
    loop = AttitudeLoop(true.attitude_lag, true.attitude_dead_time, feedback)
    return AttitudeGains.of(loop, true.motor_time_constant, true.attitude_overshoot)


def _tip_on_frame(plant: Plant) -> frozenset[tuple[int, int]]:
    """Pairs of a shape of the tip and one that does not move, either way round."""
    engine_model = plant.engine_model
    fixed = np.flatnonzero(engine_model.body_weldid[engine_model.geom_bodyid] == 0).tolist()
    pairs = [(tip, other) for tip in plant.tip_shapes for other in fixed]
    return frozenset([*pairs, *((other, tip) for tip, other in pairs)])
