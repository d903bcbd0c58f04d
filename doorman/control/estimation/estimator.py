"""Estimator: everything that is inferred from measurements, in one place: vehicle, wind, tip force, contact and door."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from doorman.control.center_of_mass import center_of_mass
from doorman.control.estimation.beliefs import VEHICLE_OBSERVER_RATE, WIND_RATE, Beliefs, ContactThresholds
from doorman.control.estimation.contact_monitor import ContactMonitor
from doorman.control.estimation.door_filter import DoorFilter, HingeEstimate, see_leaf
from doorman.control.estimation.present import present_attitude
from doorman.control.kernels.estimator_memory import (
    AT,
    BEYOND,
    FREE,
    GRIPPED,
    IS_TOLD,
    LEAVING,
    MEAN_WIND,
    MEMORY,
    MOVES,
    PUSHING,
    STATE,
    TIP_ANGLE,
    TIP_FORCE,
    TOLD,
    WIND,
    WIND_NOW,
    YAW,
    EstimatorMemory,
)
from doorman.control.kernels.estimator_step import NOT_FINITE, SINGULAR, advance_estimate
from doorman.control.kernels.tip import ARM
from doorman.control.kernels.vehicle_step import GIVEN, SEEN, SIZE
from doorman.control.observers.attitude_response import AttitudeResponse
from doorman.control.observers.door_observer import DoorObserver
from doorman.control.observers.vehicle_observer import VehicleObserver
from doorman.control.state_converter import StateConverter
from doorman.dynamics.attitude_loop import USUAL_LAG
from doorman.kinematics.rotations import euler_rates
from doorman.kinematics.vehicles.arms.arm import ArmParameters
from doorman.model import Model
from doorman.numba_types.handles import held, separate
from doorman.one_line import OneLine
from doorman.signals import Measurement

Array = NDArray[np.float64]


class Tie(Enum):
    """What is known of tip and leaf."""

    FREE = "free"
    """The tip is away from the leaf."""
    PUSHING = "pushing"
    """It should press on the leaf; whether it does is estimated."""
    LEAVING = "leaving"
    """It should come off the leaf; one that shuts may meet it anywhere."""
    GRIPPED = "gripped"
    """It is tied to the leaf."""


_NOISE = 2.0
"""Bound of the hinge's observer, as a multiple of what plans are told of: noise that is cut off at one end would be a bias."""
_AS_KERNELS_HAVE_IT = {Tie.FREE: FREE, Tie.PUSHING: PUSHING, Tie.LEAVING: LEAVING, Tie.GRIPPED: GRIPPED}


@dataclass(frozen=True, eq=False, repr=False)
class Estimate(OneLine):
    """What is known at one time."""

    time: float
    """[s]."""
    position: Array
    """P, shape (3,), world frame [m]."""
    velocity: Array
    """Ṗ, shape (3,), world frame [m/s]."""
    arm_angles: Array
    """H, shape (n,) [rad]."""
    state: Array
    """Reduced, [Φ, α, α̇, H], yaw without jumps, shape (5 + n,)."""
    tip_angle: float
    """Of the tip about the hinge: α where it touches [rad]."""
    tip_speed: float
    """Of the tip along the door's normal [m/s]."""
    wind: Array
    """Outer force of free flight, in contact as it blew on average before, shape (3,), world frame [N]."""
    tip_force: Array
    """Force of the tip on the door, shape (3,), world frame [N]."""
    normal_force: float
    """Its share along n_D: positive when the tip presses [N]."""
    near: bool
    """Whether the tip is where it may touch the leaf."""
    touching: bool
    """Contact state."""
    door_disturbance: float
    """τ̂_d, all of the hinge's torque that the scenario does not name, in the sense of damping [N m]."""
    hinge: HingeEstimate
    attitude_lag: float = USUAL_LAG
    """τ̂ of roll and pitch behind what they are told [s]."""
    push: float = 0.0
    """F_n of rotors and wind along n_D: what the vehicle presses with, or pulls, be there a leaf or not [N]."""

    @property
    def attitude(self) -> Array:
        """Φ, yaw without jumps, shape (3,) [rad]."""
        return self.state[:3]

    @property
    def yaw(self) -> float:
        """ψ without jumps [rad]."""
        return float(self.state[2])

    @property
    def door_angle(self) -> float:
        """α [rad]."""
        return float(self.state[3])

    @property
    def door_rate(self) -> float:
        """α̇ [rad/s]."""
        return float(self.state[4])


class Estimator:
    """Estimates of one flight.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
    """

    def __init__(self, model: Model, converter: StateConverter) -> None:
        lever, mass = model.coupling.lever_length, model.vehicle.mass
        self._model, self._converter = model, converter
        self._vehicle = VehicleObserver(mass, VEHICLE_OBSERVER_RATE)
        self._weight = np.array([0.0, 0.0, model.vehicle.weight])
        self.contact = ContactMonitor(ContactThresholds.of(model))
        grips = model.scenario.contact.kind == "grip"
        rates = VEHICLE_OBSERVER_RATE, WIND_RATE
        self._numbers = np.array([lever, mass, *rates, model.door.inertia, grips])
        self._memory = np.zeros(MEMORY)
        self._memory[BEYOND] = math.nan
        self._memory[YAW] = model.start_state[2]  # that the measured one is nearest to, whole turns apart
        self._response = AttitudeResponse(model.scenario.vehicle.attitude_lag)
        n = model.n_arm
        self._seen, self._acting, self._found = np.zeros(ARM + 2 * n), np.zeros(GIVEN), np.zeros(STATE + 5 + n)
        self._arm = ArmParameters.of(model.vehicle.arm)
        self.lose_leaf()
        self._compile()

    def _compile(self) -> None:
        """Make the kernel while nothing is in flight."""
        with_copies = held(separate(self._parts()))
        advance_estimate(with_copies, PUSHING, 0.0, 0.0, 0.0, 0.0)

    def tell(self, attitude: Array) -> None:
        """Take in what the vehicle is told from now on."""
        self._memory[IS_TOLD] = 1.0
        self._memory[TOLD : TOLD + 3] = attitude

    def update(self, measurement: Measurement, force: Array, tie: Tie, time_step: float) -> Estimate:
        """Take in one measurement."""
        measured, now = measurement, measurement.time
        see_leaf(self.door, self._model, measured)
        motion = measured.position, measured.velocity, measured.attitude, measured.body_rates
        np.concatenate((*motion, measured.arm_angles, measured.arm_rates), out=self._seen)
        center = center_of_mass(self._model.vehicle, measured)
        np.concatenate((measured.position, force - self._weight, *center), out=self._acting)
        arm_age = 0.0 if measured.arm_time is None else now - measured.arm_time
        ended = advance_estimate(self._kept, _AS_KERNELS_HAVE_IT[tie], measured.pose_time, arm_age, now, time_step)
        if ended == SINGULAR:
            euler_rates(present_attitude(measured), measured.body_rates)  # says so
        if ended == NOT_FINITE:
            self._converter.tip(measured, self._vehicle.velocity)  # says what
        found = self._found.copy()
        tip_angle, tip_speed, normal_force, near, touching, disturbance, lag, push = found[TIP_ANGLE:STATE].tolist()
        return Estimate(
            time=now,
            position=found[AT : AT + 3],
            velocity=found[MOVES : MOVES + 3],
            arm_angles=measured.arm_angles,
            state=found[STATE:],
            tip_angle=tip_angle,
            tip_speed=tip_speed,
            wind=found[WIND_NOW : WIND_NOW + 3],
            tip_force=found[TIP_FORCE : TIP_FORCE + 3],
            normal_force=normal_force,
            near=near != 0.0,
            touching=touching != 0.0,
            door_disturbance=disturbance,
            hinge=self.door.known_hinge(),
            attitude_lag=lag,
            push=push,
        )

    def meet_leaf(self, tip_angle: float, wind: Array) -> None:
        """Learn that the tip touches the leaf where it is now, though that should be farther; its force passed for wind."""
        self._memory[WIND : WIND + 3] = self._memory[MEAN_WIND : MEAN_WIND + 3] = wind
        self.door.meet(tip_angle)
        self.contact.declare(True)

    def lose_leaf(self) -> None:
        """Forget the leaf and its hinge: it may be anywhere, and what was learnt when something went wrong may be wrong."""
        control = self._model.scenario.control
        self.door = DoorFilter(self._model, Beliefs.of(self._model))
        most = _NOISE * control.max_door_disturbance
        self._hinge_torque = DoorObserver(self._model, control.door_observer_rate, most)
        self.contact.declare(False)
        self._kept = held(self._parts())

    def _parts(self) -> EstimatorMemory:
        return EstimatorMemory(
            numbers=self._numbers,
            memory=self._memory,
            seen=self._seen,
            carried=np.zeros_like(self._seen),
            acting=self._acting,
            vehicle=self._vehicle.memory,
            gripped=np.zeros(GIVEN),
            grip=np.where(np.arange(SIZE) == SEEN, np.nan, 0.0),
            door=self.door.memory,
            hinge_numbers=self._hinge_torque.numbers,
            hinge=self._hinge_torque.memory,
            contact_numbers=self.contact.numbers,
            contact=self.contact.memory,
            response=self._response.memory,
            arm=self._arm,
            tip=np.zeros(6),
            found=self._found,
        )
