"""Simulator: plant and onboard loop together, advanced by physics steps, and the truth about them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.copying import Uncopied
from doorman.exceptions import BackendError, SingularityError
from doorman.kinematics.rotations import attitude_from_rotation, rotation_body_to_world, skew
from doorman.model import GRAVITY, Model
from doorman.simulation.attitude_loop import AttitudeGains, AttitudeParameters
from doorman.simulation.contact import NO_FORCES, TOUCH, ContactReader, Gripper
from doorman.simulation.engine import check_stability, engine
from doorman.simulation.hinge_torques import HingeTorques
from doorman.simulation.onboard import OnboardParameters, onboard_step
from doorman.simulation.plant import Plant, build_plant, hover_wrench
from doorman.simulation.reality.drag import drag
from doorman.simulation.reality.true_thrust import true_thrust
from doorman.simulation.rotors import MixerParameters, RotorLayout, rotor_layout
from doorman.simulation.servos import ServoParameters
from doorman.simulation.truth import Truth

Array = NDArray[np.float64]


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
"""Disturbance at a time [s], asked for at every physics step."""


class Simulator(Uncopied):
    """Physics and onboard loop of one flight, beginning at the start of the scenario.

    Args:
        model: The model.
        time_step: Of the physics [s].
        disturbance: What else acts on the plant.
        gains: Of the attitude loop.

    Raises:
        BackendError: if MuJoCo is missing or cannot build the plant, or the rotors cannot steer.
    """

    def __init__(
        self,
        model: Model,
        time_step: float,
        disturbance: DisturbanceSource | None = None,
        gains: AttitudeGains | None = None,
    ) -> None:
        self.model = model
        self.time_step = time_step
        self._disturbance = disturbance
        self._mujoco = engine()
        self.layout = rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)
        self.plant = build_plant(self._mujoco, model, self.layout, time_step)
        data = self.plant.data
        self._qpos, self._qvel, self._control = data.qpos, data.qvel, data.ctrl
        self._onboard = _onboard_parameters(model, self.plant, self.layout, time_step, gains)
        shapes = self.plant.tip_shapes, self.plant.leaf_shapes
        true = model.scenario.simulation
        self._gripper = Gripper(
            self._mujoco, self.plant.engine_model, data, *shapes, true.gripper_closes, true.gripper_force
        )
        at_door = model.scenario.mission.start == "contact"
        if self._gripper.closed and not at_door:
            self._gripper.set(False)
        self._contacts = ContactReader(self._mujoco, self.plant.engine_model, data, *shapes, self._gripper)
        self._command = np.zeros(7 + model.n_arm)
        self.set_command(model.vehicle.mass * GRAVITY, model.start_state[:3], np.zeros(model.n_arm))
        self._hinge_torques = HingeTorques(model, self.plant)
        self._thrust, self._drag = true_thrust(model, self.plant, self.layout), drag(model, self.plant, self.layout)
        self._outer_force = 0.0
        self._rotors: Array | None = None
        self._steps = 0
        self._compile(_onboard_parameters(model, self.plant, self.layout, time_step, gains))
        self._begin_interval()
        self._note_contacts(self._qpos.item(self.plant.hinge_position))

    def _compile(self, parameters: OnboardParameters) -> None:
        """Run the onboard loop once, on memory of its own: nothing is compiled in flight."""
        onboard_step(parameters, self._qpos.copy(), self._qvel.copy(), self._command, self._control.copy())

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * self.time_step

    def set_command(
        self, thrust: float, attitude: ArrayLike, arm_rates: ArrayLike, side_force: ArrayLike = (0.0, 0.0)
    ) -> None:
        """Set what the onboard loop follows from the next physics step on.

        Args:
            thrust: f_t [N].
            attitude: Φ_d, shape (3,) [rad].
            arm_rates: Ḣ_d, shape (n,) [rad/s].
            side_force: Body force along x and y, shape (2,) [N]; rotors that cannot make it take no notice.
        """
        self._command[0] = thrust
        self._mujoco.mju_mat2Quat(self._command[1:5], rotation_body_to_world(attitude).ravel())
        self._command[5:7] = side_force
        self._command[7:] = arm_rates

    def set_rotors(self, thrusts: Array | None, directions: Array | None = None) -> None:
        """Let somebody else fly: set points of the rotors, from the next physics step on, instead of the onboard loop's.

        Args:
            thrusts: Shape (m,) [N]; None lets the onboard loop fly again.
            directions: Senses in which that somebody's rotors turn, +1 counter-clockwise seen from above, shape (m,); None
                leaves them as they are.
        """
        self._rotors = thrusts
        if directions is not None:
            gears = self.plant.engine_model.actuator_gear
            gears[: self.layout.count, 5] = -directions * self.layout.torque_per_thrust
            if self._thrust is not None:
                self._thrust.turn(directions)

    def set_grip(self, closed: bool) -> None:
        """Let the tip hold on to the leaf where it touches, or let go.

        Args:
            closed: What is asked for; see `Gripper`.
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
        engine_model, data, step = self.plant.engine_model, self.plant.data, self._mujoco.mj_step
        qpos, place = self._qpos, self.plant.hinge_position
        for _ in range(steps):
            if self._disturbance is not None:
                self._disturb(self._disturbance(self.time))
            onboard_step(self._onboard, self._qpos, self._qvel, self._command, self._control)
            if self._rotors is not None:
                self._control[: self.layout.count] = self._rotors
            if self._thrust is not None:
                self._thrust.act(self.time)
            if self._drag is not None:
                self._drag.act()
            self._hinge_torques.act()
            hinge_value = qpos.item(place)
            step(engine_model, data)
            self._steps += 1
            self._note_contacts(hinge_value)
        check_stability(self._mujoco, data)

    def truth(self) -> Truth:
        """State now, and contacts since the last call of `advance` began.

        Raises:
            BackendError: if the vehicle has pitched to ±90°, where Euler angles are singular.
        """
        plant = self.plant
        rotation = np.empty(9)
        self._mujoco.mju_quat2Mat(rotation, self._qpos[3:7])
        root = rotation.reshape(3, 3)
        to_base = plant.root_to_base
        try:
            attitude = attitude_from_rotation(root @ to_base[:3, :3])
        except SingularityError as error:
            raise BackendError(
                f"the vehicle has turned over: {error}", field="attitude", given=f"time {self.time:.3f} s"
            ) from error
        lever = skew(self._qvel[3:6]) @ to_base[:3, 3]
        return Truth(
            time=self.time,
            position=_sealed(self._qpos[:3] + root @ to_base[:3, 3]),
            velocity=_sealed(self._qvel[:3] + root @ lever),
            attitude=_sealed(attitude),
            body_rates=_sealed(to_base[:3, :3].T @ self._qvel[3:6]),
            door_angle=plant.door_angle,
            door_rate=plant.door_rate,
            arm_angles=_sealed(self._qpos[plant.arm_positions]),
            arm_rates=_sealed(self._qvel[plant.arm_velocities]),
            tip_force=_sealed(self._tip_force),
            tip_normal_force=self._normal_force,
            touching=self._gripper.closed or max(map(abs, self._tip_force.tolist())) > TOUCH,
            max_pull=self._max_pull,
            collisions=self._collisions,
            collision_pairs=self._pair_names(),
            rotor_thrusts=_sealed(plant.rotor_thrusts),
            max_push=self._max_push,
            gripping=self._gripper.closed,
            grip_slips=self._gripper.slips,
            outer_force=self._outer_force,
        )

    def _pair_names(self) -> tuple[str, ...]:
        """Of the shapes that have touched, but tip and leaf."""
        if not self._pairs:
            return ()
        return tuple(sorted({" and ".join(map(self.plant.shape_name, pair)) for pair in self._pairs}))

    def _begin_interval(self) -> None:
        self._max_pull, self._max_push, self._collisions = 0.0, 0.0, 0
        self._pairs: set[tuple[int, int]] = set()

    def _note_contacts(self, hinge_value: float) -> None:
        """Take in the contacts of a step that began with the hinge at this value."""
        forces = self._contacts.read()
        self._tip_force = forces.tip
        if forces is NO_FORCES:
            self._normal_force = 0.0
            return
        normal = self.plant.hinge.normal(self.plant.hinge.angle_of_joint(hinge_value))
        self._normal_force = float(normal @ forces.tip)
        self._gripper.strain(forces.tip, normal)
        self._max_pull = max(self._max_pull, -self._normal_force)
        self._max_push = max(self._max_push, self._normal_force)
        if forces.others:
            self._collisions = max(self._collisions, len(forces.others))
            self._pairs.update(forces.others)

    def _disturb(self, disturbance: Disturbance) -> None:
        data, plant = self.plant.data, self.plant
        data.xfrc_applied[plant.base_body, :3] = disturbance.force
        data.xfrc_applied[plant.base_body, 3:] = disturbance.torque
        self._hinge_torques.other = plant.hinge.joint_torque(disturbance.hinge_torque)
        self._outer_force = math.hypot(*disturbance.force)


def _sealed(array: Array) -> Array:
    """An array that nobody else has, from now on read-only."""
    array.flags.writeable = False
    return array


def _onboard_parameters(
    model: Model, plant: Plant, layout: RotorLayout, time_step: float, gains: AttitudeGains | None
) -> OnboardParameters:
    gains = gains or AttitudeGains.of(model.attitude_loop, model.scenario.simulation.motor_time_constant)
    attitude = AttitudeParameters.of(model.vehicle_inertia, layout.torque_authority, time_step, gains)
    attitude.memory[0] = np.linalg.solve(attitude.inertia, hover_wrench(model)[1:])  # trimmed: a hover is at rest
    return OnboardParameters(
        attitude=attitude,
        mixer=MixerParameters.of(layout),
        root_to_base=plant.root_to_base_quaternion,
        servos=_servos(model, plant, time_step),
        quaternion=np.zeros(4),
        rates=np.zeros(3),
    )


def _servos(model: Model, plant: Plant, time_step: float) -> ServoParameters:
    servos = ServoParameters.of(model.vehicle, plant.arm_positions, plant.arm_velocities, time_step)
    servos.limits[3] *= model.scenario.simulation.servo_torque_scale
    return servos
