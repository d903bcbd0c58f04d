"""Rig plant: one simulated vehicle and door, advanced in real time by a thread of its own, for several emulators at once."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.background import InThread
from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.vehicle.places import Places
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recorder
from doorman.rig.landing_gear import LandingGear
from doorman.rig.sitl.rotor_pilot import RotorPilot
from doorman.simulation.plant.engine import engine
from doorman.simulation.simulator import Disturbance, Simulator, simulated_gains
from doorman.simulation.truth import Truth

MOST_BEHIND = 0.1
"""Physics that is later than this lets time stand still instead of making up for it [s]."""


@dataclass(frozen=True)
class Snapshot:
    """The plant at one instant, as all emulators see it."""

    at: float
    """Time of the state, by `time.monotonic` [s]."""
    truth: Truth
    """State and contact."""
    on_ground: bool
    """Whether the landing gear touches."""
    motors: bool
    """Whether the motors run."""
    arm_torques: Array
    """Torques of the servos, shape (n,) [N m]."""


class RigPlant(InThread):
    """Vehicle and door in real time. The vehicle stands on its pad until its motors lift it.

    Args:
        model: The model, for this plant alone.
        recorder: Gets a message `truth` per tick while the motors run or the vehicle is in the air; written by the plant's
            thread only.
        pilot: Flies the rotors, and is started and stopped with the plant; None lets whoever calls `fly`.
        motor_lag: Least time constant of the motors, where the scenario gives them one [s].
        feedback: Lag of the feedback of an emulated autopilot with feed-forward; 0 without [s].
        clock: Clock of all its waits.
    """

    def __init__(
        self,
        model: Model,
        recorder: Recorder | None = None,
        pilot: RotorPilot | None = None,
        motor_lag: float = 0.0,
        feedback: float = 0.0,
        clock: Clock = REAL_TIME,
    ) -> None:
        super().__init__("plant", clock)
        self.model = model
        self.places = Places.of(model)
        self.gear = LandingGear(float(self.places.pad[2]))
        rates = model.scenario.simulation
        rate = rates.controller_rate if pilot is None else pilot.rate
        self.period = 1.0 / rate
        self._steps = max(1, math.ceil(rates.physics_rate / rate - 1e-9))
        self.lock = clock.lock()
        """Held while the physics advances."""
        self.slipped = 0.0
        """By how much the plant's time has fallen behind the clock's [s]."""
        self.failure: str | None = None
        """Why the physics ended, if it did."""
        self._recorder = recorder
        self._recorded_epoch: float | None = None
        self._simulator = Simulator(model, self.period / self._steps, self._acting, simulated_gains(model, feedback))
        self._gains = self._simulator.plant.engine_model.actuator_gainprm
        lags = self._simulator.plant.engine_model.actuator_dynprm[: self._simulator.layout.count, 0]
        lags[:] = np.where(lags > 0.0, np.maximum(lags, motor_lag), 0.0)
        self._thrust, self._attitude, self._side_force = 0.0, np.array([0.0, 0.0, self.places.yaw]), (0.0, 0.0)
        plant = self._simulator.plant
        self._free = float(plant.engine_model.dof_frictionloss[plant.hinge_velocity])
        self._own_spring = float(plant.engine_model.jnt_stiffness[plant.engine_model.dof_jntid[plant.hinge_velocity]])
        self._arm_rates = np.zeros(model.n_arm)
        self._motors, self._grip = False, False
        self._pilot = pilot
        if pilot is not None:
            self._simulator.set_rotors(None, pilot.directions)
        self._wind = _NOTHING
        self._stand()
        self.epoch = self._clock.now()
        """When the plant's time was zero [s]."""
        self._snapshot = self._look()

    # ------------------------------------------------------------ life

    def _begin(self) -> None:
        if self._pilot is not None:
            self._pilot.open()
        self.epoch = self._clock.now() - self._simulator.time

    def _end(self) -> None:
        if self._pilot is not None:
            self._pilot.stop()

    # ------------------------------------------------------------ what emulators do

    @property
    def snapshot(self) -> Snapshot:
        """Newest state."""
        return self._snapshot

    def fly(self, thrust: float, attitude: Array, side_force: tuple[float, float] = (0.0, 0.0)) -> None:
        """Run the motors.

        Args:
            thrust: f_t [N].
            attitude: Φ_d, shape (3,) [rad].
            side_force: Along the body's x and y axis [N].
        """
        with self.lock:
            self._thrust, self._attitude, self._side_force, self._motors = thrust, attitude, side_force, True

    def stop_motors(self) -> None:
        """Let the motors stand still."""
        with self.lock:
            self._thrust, self._motors = 0.0, False

    def move_arm(self, rates: Array) -> None:
        """Ask for joint rates.

        Args:
            rates: Ḣ_d, shape (n,) [rad/s].
        """
        with self.lock:
            self._arm_rates = np.array(rates)

    def grip(self, closed: bool) -> None:
        """Close or open the gripper; closed, it takes hold of the leaf as soon as the tip is there.

        Args:
            closed: Whether to hold.
        """
        self._grip = closed

    def reset(self) -> None:
        """Put vehicle, arm and door back to where they began, at rest; time goes on."""
        with self.lock:
            self._grip, self._motors, self._thrust = False, False, 0.0
            self._arm_rates = np.zeros(self.model.n_arm)
            self._stand()
            self._snapshot = self._look()

    def kick(self, door_rate: float) -> None:
        """Slam the door: give it a rate.

        Args:
            door_rate: α̇ [rad/s].
        """
        with self.lock:
            self._simulator.plant.data.qvel[self._simulator.plant.hinge_velocity] = self.model.true_door.joint_rate(
                door_rate
            )

    def block(self, torque: float) -> None:
        """Hold the door where it is, as somebody or a wedge does, until the next call.

        Args:
            torque: What it takes to move it nevertheless, beyond its own friction [N m]; 0 lets it go.
        """
        plant = self._simulator.plant
        with self.lock:
            plant.engine_model.dof_frictionloss[plant.hinge_velocity] = self._free + torque

    def draw_shut(self, stiffness: float) -> None:
        """Give the door a closer, until the next call.

        Args:
            stiffness: Of its spring, beside the door's own one [N m/rad]; 0 takes it away.
        """
        model, hinge = self._simulator.plant.engine_model, self._simulator.plant.hinge_velocity
        with self.lock:
            model.jnt_stiffness[model.dof_jntid[hinge]] = self._own_spring + stiffness

    def blow(self, force: tuple[float, float, float]) -> None:
        """Let wind, or somebody's hand, push the vehicle until the next call.

        Args:
            force: World frame [N].
        """
        self._wind = Disturbance(force)

    # ------------------------------------------------------------ the thread

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                behind = self._clock.now() - self.epoch - self._simulator.time
                if behind < self.period:
                    self._stopping.wait(self.period - behind)
                    continue
                if behind > MOST_BEHIND:
                    self.epoch += behind - MOST_BEHIND
                    self.slipped += behind - MOST_BEHIND
                self.advance()
        except BackendError as error:
            self.failure = str(error)
        except Exception as error:  # whatever it is: servos and cameras would go on showing a vehicle that stands still
            self.failure = f"{type(error).__name__}: {error}"

    def advance(self) -> None:
        """Let one tick pass, and look."""
        pilot = self._pilot
        rotors = None if pilot is None else pilot.thrusts(self._simulator.time)
        with self.lock:
            if pilot is not None:
                self._motors = rotors is not None
                self._simulator.set_rotors(rotors)
            self._simulator.set_grip(self._grip)
            self._gains[: self._simulator.layout.count, 0] = float(self._motors)
            attitude = self._attitude if self._motors else self._snapshot.truth.attitude
            thrust, side = (self._thrust, self._side_force) if self._motors else (0.0, (0.0, 0.0))
            self._simulator.set_command(thrust, attitude, self._arm_rates, side)
            self._simulator.advance(self._steps)
            self._snapshot = self._look()
        if pilot is not None:
            pilot.tell(self._snapshot.truth)
        if self._recorder is not None and (self._snapshot.motors or not self._snapshot.on_ground):
            self._record(self._recorder)

    def _record(self, recorder: Recorder) -> None:
        truth = self._snapshot.truth
        if self.epoch != self._recorded_epoch:
            recorder.write("epoch", truth.time, {"epoch": self.epoch})
            self._recorded_epoch = self.epoch
        recorder.write("truth", truth.time, truth.fields())

    def _look(self) -> Snapshot:
        truth, plant = self._simulator.truth(), self._simulator.plant
        return Snapshot(
            at=self.epoch + truth.time,
            truth=truth,
            on_ground=self.gear.touches(float(truth.position[2])),
            motors=self._motors,
            arm_torques=plant.data.qfrc_actuator[plant.arm_velocities].copy(),
        )

    def _acting(self, _: float) -> Disturbance:
        """The landing gear's wrench, at every physics step."""
        plant = self._simulator.plant
        data = plant.data
        if data.xpos[plant.base_body, 2] > self.gear.length:
            return self._wind
        rotation = data.xmat[plant.base_body].reshape(3, 3)
        spin = data.xmat[plant.base_body - 1].reshape(3, 3) @ data.qvel[3:6]
        force, torque = self.gear.wrench(data.xpos[plant.base_body], data.qvel[:3], rotation[:, 2], spin)
        x, y, z = force.tolist()
        roll, pitch, yaw = torque.tolist()
        return Disturbance((x, y, z), (roll, pitch, yaw))

    def _stand(self) -> None:
        """Put the vehicle on its pad, at rest, with its motors off."""
        plant = self._simulator.plant
        self._simulator.set_grip(False)
        data, to_root = plant.data, np.linalg.inv(plant.root_to_base)
        rotation = rotation_body_to_world([0.0, 0.0, self.places.yaw])
        sunk = self.model.vehicle.weight / self.gear.stiffness
        data.qpos[:3] = self.places.pad - [0.0, 0.0, sunk] + rotation @ to_root[:3, 3]
        engine().mju_mat2Quat(data.qpos[3:7], (rotation @ to_root[:3, :3]).ravel())
        data.qpos[plant.arm_positions] = self.model.start_arm
        data.qpos[plant.hinge_position] = self.model.true_door.joint_value(self.model.travel.start)
        data.qvel[:] = 0.0
        if plant.engine_model.na:
            data.act[:] = 0.0
        engine().mj_forward(plant.engine_model, data)


_NOTHING = Disturbance()
