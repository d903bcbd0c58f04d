"""What the vehicle knows at the leaf: its motion, the force it feels, leaf and hinge, whether it touches, and the wind.

Wind and contact cannot be told apart while the tip pushes steadily. `wind_filter` says what the wind does meanwhile. Three things
say that there is no contact: the force fades, the tip draws back, or it gains speed as no leaf would. A force sensor in the tip
says both: whether it touches, and what of the outer force is wind.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from doorman.control.center_of_mass import center_of_mass
from doorman.control.estimation.beliefs import VEHICLE_OBSERVER_RATE, Beliefs, ContactThresholds
from doorman.control.estimation.contact_monitor import ContactMonitor
from doorman.control.estimation.door_filter import DoorFilter, HingeEstimate, see_leaf
from doorman.control.estimation.wind_filter import WindFilter
from doorman.control.kernels.door_filter.memory import ANGLE
from doorman.control.kernels.leaf_estimator.contact import FACE_DEVIATION, begin_leaf
from doorman.control.kernels.leaf_estimator.memory import (
    AT,
    ATTITUDE_NOW,
    ATTITUDE_RATES,
    CLOSED,
    DOOR_ANGLE,
    FACE_VARIANCE,
    FOUND_SIZE,
    FRICTION_FORCE,
    LAST,
    LEVERS,
    MEMORY,
    MET,
    MOVES,
    NOT_FINITE,
    OFFSET_VARIANCE,
    READS,
    SINGULAR,
    WIND_NOW,
    LeafMemory,
)
from doorman.control.kernels.leaf_estimator.step import advance_leaf
from doorman.control.kernels.tip import ARM
from doorman.control.kernels.vehicle_step import GIVEN
from doorman.control.kernels.wind_step import HINGE_CHANGES, wind_doubt
from doorman.control.observers.door_observer import DoorObserver
from doorman.control.observers.vehicle_observer import VehicleObserver
from doorman.control.state_converter import StateConverter
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_normal
from doorman.kinematics.rotations import euler_rates
from doorman.kinematics.vehicles.arms.arm import ArmParameters
from doorman.model import Model
from doorman.numba_types.handles import held, separate
from doorman.planning.limits import largest_push
from doorman.signals import Measurement

Array = NDArray[np.float64]

_ON_LEAF = 0.5
"""Wind that is expected on the leaf, as a share of the vehicle's."""
_QUICK = 8.0
"""Rate of the quick observer [rad/s]."""


@dataclass(frozen=True, eq=False)
class LeafEstimate:
    """What is known at one time."""

    position: Array
    velocity: Array
    attitude: Array
    """Φ now, the measured one carried on by its rates, shape (3,) [rad]."""
    attitude_rates: Array
    arm_angles: Array
    door_angle: float
    door_rate: float
    touching: bool
    normal_force: float
    """λ that plans begin with [N]."""
    friction_force: Array
    """Of the tip on the face, along and up, shape (2,) [N]."""
    wind: Array
    resistance: float
    """Of the joint against opening, beside the leaf's weight [N m],"""
    friction_share: float
    """of which this share does not drive it back."""
    inertia: float
    face_offset: float
    """Of the face from where the model has it, towards the vehicle [m],"""
    lever: float
    """where a newton along the normal is so much torque in the joint [m]."""
    normal_pull: float
    """λ as the tip's sensor reads it, or as felt: wind less outer force along the normal [N]."""
    hinge: HingeEstimate
    """Parameters of the hinge. An error of the wind's force on the vehicle passes for torque of friction and closer: the
    deviation of that torque holds it."""


class LeafEstimator:
    """Estimates of one flight.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
    """

    def __init__(self, model: Model, converter: StateConverter) -> None:
        beliefs, door, size = Beliefs.of(model), model.door, model.scale
        self._model, self._converter = model, converter
        self._mass, self._lever = model.vehicle.mass, model.coupling.lever_length
        self._doubt = 0.0  # of the torque, as the wind in contact and the hinge's changes are doubted [N m]
        self._changes = HINGE_CHANGES * model.hinge_scale
        self._weight_force = np.array([0.0, 0.0, model.vehicle.weight])
        self._vehicle = VehicleObserver(self._mass, VEHICLE_OBSERVER_RATE)
        self._monitor = ContactMonitor(ContactThresholds.of(model))
        self._monitor.declare(model.scenario.mission.start == "contact")
        self._wind = WindFilter(size.force, model.hinge_scale)
        self._door = DoorFilter(model, beliefs)
        most = largest_push(model, model.scenario.control.max_tilt) * self._lever
        """Torque of the largest push [N m]."""
        goal, start = model.goal_angle, model.start_angle
        levers = self._lever + _ON_LEAF * door.wind_lever
        numbers = [
            self._mass, self._lever, VEHICLE_OBSERVER_RATE, goal, door.rest_angle, start, most,
            self._lever * beliefs.angle_deviation, levers, door.closing_torque, model.travel.ahead(1.0), *door.up,
            size.force, size.torque, size.time, model.hinge_scale,
            door.upper_limit, model.scenario.estimation.tip_force_noise,
        ]  # fmt: skip
        memory = np.zeros(MEMORY)
        memory[FACE_VARIANCE], memory[CLOSED], memory[MET] = FACE_DEVIATION**2, 1.0, math.nan
        memory[LAST] = -math.inf
        memory[READS], memory[OFFSET_VARIANCE] = math.nan, model.scenario.estimation.tip_force_offset**2
        self._kept = self._parts(np.array(numbers), memory, most)
        self._held = held(self._kept)
        begin_leaf(self._held)
        advance_leaf(held(separate(self._kept)), True, 0.0, math.nan, 0.0, 0.0, 0.0)  # compiles: nothing is in flight

    def _parts(self, numbers: Array, memory: Array, most: float) -> LeafMemory:
        model, n = self._model, self._model.n_arm
        rate = model.scenario.control.door_observer_rate
        first = DoorFilter(model, Beliefs.of(model)).memory
        torque, bare = (DoorObserver(model, rate, most, whole=True) for _ in range(2))
        quick = DoorObserver(model, max(rate, _QUICK), most, whole=True)
        return LeafMemory(
            numbers=numbers,
            memory=memory,
            seen=np.zeros(ARM + 2 * n),
            acting=np.zeros(GIVEN),
            vehicle=self._vehicle.memory,
            door=self._door.memory,
            first=first,
            wind=self._wind.memory,
            torque_numbers=torque.numbers,
            torque=torque.memory,
            quick_numbers=quick.numbers,
            quick=quick.memory,
            bare=bare.memory,
            contact_numbers=self._monitor.numbers,
            contact=self._monitor.memory,
            arm=ArmParameters.of(model.vehicle.arm),
            tip=np.zeros(6),
            found=np.zeros(FOUND_SIZE),
        )

    def update(
        self, measured: Measurement, rotors: Array, time_step: float, seeks: bool, wanted: float
    ) -> LeafEstimate:
        """Take in one measurement."""
        see_leaf(self._door, self._model, measured)
        kept = self._kept
        motion = measured.position, measured.velocity, measured.attitude, measured.body_rates
        np.concatenate((*motion, measured.arm_angles, measured.arm_rates), out=kept.seen)
        center = center_of_mass(self._model.vehicle, measured)
        np.concatenate((measured.position, rotors - self._weight_force, *center), out=kept.acting)
        reading = math.nan if measured.tip_force is None else measured.tip_force
        ended = advance_leaf(self._held, seeks, wanted, reading, measured.pose_time, measured.time, time_step)
        if ended == SINGULAR:
            euler_rates(measured.attitude, measured.body_rates)  # says so
        if ended == NOT_FINITE:
            self._converter.tip(measured, self._vehicle.velocity)  # says what
        found = kept.found.copy()
        angle, rate, touches, force, resistance, share, inertia, face, pulled = found[DOOR_ANGLE:].tolist()
        return LeafEstimate(
            found[AT : AT + 3], found[MOVES : MOVES + 3], found[ATTITUDE_NOW : ATTITUDE_NOW + 3],
            found[ATTITUDE_RATES : ATTITUDE_RATES + 3], np.array(measured.arm_angles), angle, rate, touches != 0.0, force,
            found[FRICTION_FORCE : FRICTION_FORCE + 2], found[WIND_NOW : WIND_NOW + 3], resistance, share, inertia, face,
            self._lever, pulled, self._hinge(touches != 0.0),
        )  # fmt: skip

    def know_the_face(self) -> None:
        """The closed leaf's face is where the model has it: what is met elsewhere is a leaf that stands ajar."""
        self._kept.memory[CLOSED] = 0.0

    def _hinge(self, touching: bool) -> HingeEstimate:
        r"""The door's filter takes the wind on the vehicle for known, and friction and closer for constant.

        The doubt of the wind in contact is added, by the levers of tip and leaf: it blows on both. So is what a torque that
        changes by chance on the way s is off from its mean: :math:`c^2 s / 3` for a variance of :math:`c^2` per radian, as the
        wind's filter expects it.
        """
        hinge, door = self._door.hinge(), self._door.memory
        if touching:
            angle = float(door.state[ANGLE])
            wind = float(self._kept.numbers[LEVERS]) * wind_doubt(
                self._wind.memory.covariance, leaf_normal(door.leaf, angle)
            )
            self._doubt = math.hypot(wind, self._changes * math.sqrt(abs(angle - self._model.start_angle) / 3.0))
        return replace(hinge, torque_deviation=math.hypot(hinge.torque_deviation, self._doubt))
