"""Plain twin of `Estimator`."""

from __future__ import annotations

import math

import numpy as np
from plain_parts import PlainHinge, PlainMonitor, PlainResponse

from doorman.control.center_of_mass import center_of_mass
from doorman.control.estimation.beliefs import VEHICLE_OBSERVER_RATE, WIND_RATE, Beliefs, ContactThresholds
from doorman.control.estimation.door_filter import DoorFilter
from doorman.control.estimation.estimator import Estimate, Tie
from doorman.control.estimation.present import present, present_posture
from doorman.control.kernels.grip_step import GRIP_POLES
from doorman.control.kernels.vehicle_step import LATE
from doorman.control.observers.vehicle_observer import VehicleObserver
from doorman.control.state_converter import StateConverter
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.signals import Measurement

Array = np.ndarray

_REACH = 0.03
"""A tip that is farther from the leaf, beyond twice the deviation of where the leaf is, does not touch it [m]."""
_DRAWS_BACK = 0.04
"""A tip that moves away from the leaf faster than this [m/s]"""
_DOUBT = 0.4
"""is not believed to move the leaf with it for so long: the estimated force takes about as long to show that it has left [s]."""
_SMOOTHED = 0.05
"""Time over which the distance of tip and leaf is smoothed [s]."""
_AVERAGED = 30.0
"""Longest time in free flight over which the wind is averaged [s]."""


class PlainEstimator:
    """Estimates of one flight."""

    def __init__(self, model: Model, converter: StateConverter) -> None:
        self._model, self._converter = model, converter
        self._rate = WIND_RATE
        self._vehicle = VehicleObserver(model.vehicle.mass, VEHICLE_OBSERVER_RATE)
        self._weight = np.array([0.0, 0.0, model.vehicle.mass * GRAVITY])
        self.contact = PlainMonitor(ContactThresholds.of(model))
        self.lose_leaf()
        self._door_inertia = model.door.inertia
        self._lever = model.coupling.lever_length
        self._beyond: float | None = None
        self._grip: VehicleObserver | None = None
        self._grips, self._smoothed = model.scenario.contact.kind == "grip", 0.0
        self._drew_back, self._doubted = False, 0.0
        self._wind, self._mean_wind = np.zeros(3), np.zeros(3)
        self._free_time = 0.0
        self._yaw = model.start_yaw  # that the measured one is nearest to, whole turns apart
        self._response = PlainResponse(model.scenario.vehicle.attitude_lag)
        self._told: Array | None = None

    def tell(self, attitude: Array) -> None:
        """Take in what the vehicle is told from now on."""
        self._told = attitude

    def update(self, measurement: Measurement, force: Array, tie: Tie, time_step: float) -> Estimate:
        """Take in one measurement."""
        vehicle, now, lifts = self._vehicle, measurement.time, force - self._weight
        attitude, arm = present_posture(measurement)
        if self._told is not None:
            self._response.update(self._told, attitude, measurement.body_rates, time_step)
        center = center_of_mass(self._model.vehicle, measurement)
        vehicle.update(measurement.position, measurement.pose_time, now, lifts, time_step, center)
        velocity = vehicle.velocity.copy()
        tip_angle, tip_rate = self._converter.tip(measurement, velocity)
        turned_rate = tip_rate
        if tie is Tie.GRIPPED:
            tip_rate = self._rate_of_a_grip(measurement, tip_angle, time_step)
        else:
            self._grip = None
        near = self._near(tip_angle)
        may_touch = near or self.contact.touching or tie is Tie.LEAVING
        self._follow_wind(tie is Tie.FREE or not (may_touch or tie is Tie.GRIPPED), time_step)
        tip_force = self._wind - vehicle.outer_force
        normal = self._model.door.normal(self.door.angle)
        normal_force = float(normal @ tip_force)
        if tie is not Tie.GRIPPED and not may_touch:
            self.contact.listen(normal_force, time_step)
        force_felt = normal_force if may_touch else 0.0
        distance = math.inf if self._grips else self._distance_to_leaf(tip_angle, tip_rate, time_step)
        touching = tie is Tie.GRIPPED or (tie is not Tie.FREE and self.contact.update(force_felt, time_step, distance))
        acting = lifts + self._wind
        push = float(normal @ acting)
        if tie is Tie.GRIPPED:
            push = self._push_of_a_grip(acting, tip_angle, turned_rate, time_step)
        self._update_door(tie, touching, (tip_angle, tip_rate), measurement, acting, push, time_step)
        state = np.empty(5 + len(arm))
        state[:3], state[5:] = attitude, arm
        if tie is Tie.GRIPPED:
            state[3], state[4] = self._converter.tip(present(measurement, velocity), velocity)[0], tip_rate
        else:
            state[3], state[4] = self.door.angle, self.door.rate
        yaw = float(state[2])
        self._yaw = yaw + 2.0 * math.pi * round((self._yaw - yaw) / (2.0 * math.pi))  # without jumps at ±π
        state[2] = self._yaw
        return Estimate(
            time=now,
            position=vehicle.position.copy(),
            velocity=velocity,
            arm_angles=measurement.arm_angles,
            state=state,
            tip_angle=tip_angle,
            tip_speed=-self._lever * tip_rate,
            wind=self._wind,
            tip_force=tip_force,
            normal_force=normal_force,
            near=near,
            touching=touching,
            door_disturbance=self._hinge_torque.estimate,
            hinge=self.door.hinge(),
            attitude_lag=self._response.lag,
            push=push,
        )

    def meet_leaf(self, tip_angle: float, wind: Array) -> None:
        """Learn that the tip touches the leaf where it is now, though that should be farther; its force passed for wind."""
        self._wind, self._mean_wind = wind.copy(), wind.copy()
        self.door.meet(tip_angle)
        self.contact.declare(True)

    def lose_leaf(self) -> None:
        """Forget the leaf and its hinge: it may be anywhere, and what was learnt when something went wrong may be wrong."""
        control = self._model.scenario.control
        self.door = DoorFilter(self._model, Beliefs.of(self._model))
        self._hinge_torque = PlainHinge(self._model, control.door_observer_rate, 2.0 * control.max_door_disturbance)
        self.contact.declare(False)

    def _follow_wind(self, free: bool, time_step: float) -> None:
        """In free flight the wind is what is felt; at the leaf a gust is forgotten, and what has blown on average stays."""
        if free and time_step > 0.0:
            self._free_time += time_step
            share = time_step / min(self._free_time, _AVERAGED)
            self._mean_wind = self._mean_wind + share * (self._vehicle.outer_force - self._mean_wind)
        blows = self._vehicle.outer_force if free else self._mean_wind
        self._wind = self._wind + min(self._rate * time_step, 1.0) * (blows - self._wind)

    def _near(self, tip_angle: float) -> bool:
        return self._lever * (tip_angle - self.door.angle - 2.0 * self.door.angle_deviation) < _REACH

    def _distance_to_leaf(self, tip_angle: float, tip_rate: float, time_step: float) -> float:
        """Of the tip from where the leaf is believed to be, smoothed, and carried on by the lag of that [m]."""
        distance = self._lever * (tip_angle - self.door.angle)
        opening = self._lever * (tip_rate - self.door.rate)
        self._smoothed += min(time_step / _SMOOTHED, 1.0) * (distance - self._smoothed)
        return self._smoothed + _SMOOTHED * opening

    def _update_door(
        self,
        tie: Tie,
        touching: bool,
        tip: tuple[float, float],
        measurement: Measurement,
        acting: Array,
        push: float,
        time_step: float,
    ) -> None:
        seen, now = measurement.pose_time, measurement.time
        if tie is Tie.GRIPPED:
            self.door.update(push, True, tip[0], seen, now, time_step, wind=self._mean_wind)
            self._hinge_torque.update(*tip, push, self.door.inertia, time_step)
            return
        self._beyond = None
        doubted = self._doubts(touching, -self._lever * tip[1], now)
        touching = touching and not doubted
        self.door.update(push, touching, tip[0], seen, now, time_step, wind=self._mean_wind)
        if touching:
            push = float(self._model.door.normal(self.door.angle) @ acting)
            self._hinge_torque.update(self.door.angle, self.door.rate, push, self._door_inertia, time_step)
            return
        self._hinge_torque.pause()
        if tie in (Tie.PUSHING, Tie.LEAVING):
            self.door.passed(tip[0])

    def _doubts(self, touching: bool, tip_speed: float, now: float) -> bool:
        """Whether the tip has probably left the leaf, though its estimated force does not show that yet."""
        draws_back = touching and tip_speed < -_DRAWS_BACK
        if draws_back and not self._drew_back and now >= self._doubted:
            self._doubted = now + _DOUBT
        self._drew_back = draws_back
        return now < self._doubted

    def _rate_of_a_grip(self, measurement: Measurement, tip_angle: float, time_step: float) -> float:
        """Rate of a leaf that the tip grips, by an observer of the tip's own place [rad/s]."""
        turned, arm = rotation_body_to_world(measurement.attitude), measurement.arm_angles
        tip = measurement.position + turned @ self._model.vehicle.tip_position(arm)
        if self._grip is None:
            self._grip = VehicleObserver(1.0, GRIP_POLES * self._vehicle.rate)
            moves = np.cross(measurement.body_rates, self._model.vehicle.tip_position(arm))
            moves = moves + self._model.vehicle.tip_jacobian(arm) @ measurement.arm_rates
            self._grip.velocity[:] = self._vehicle.velocity + turned @ moves
            self._grip.memory[LATE] = self._vehicle.memory[LATE]
        self._grip.update(tip, measurement.pose_time, measurement.time, np.zeros(3), time_step)
        return -float(self._model.door.normal(tip_angle) @ self._grip.velocity) / self._lever

    def _push_of_a_grip(self, acting: Array, tip_angle: float, tip_rate: float, time_step: float) -> float:
        r"""Push at the tip that would turn leaf and vehicle together as they turn now [N].

        A vehicle that turns about the tip it holds moves otherwise than the tip. With :math:`u = n_D^T v + D_V\dot\alpha`, its
        speed along the normal beyond the tip's, the push is :math:`n_D^T F - m_A\dot u + m_A\dot\alpha\,n_D'^T v`; the
        normal of a hinged leaf bends by :math:`n_D' = c` (docs/theory.md).
        """
        door, velocity = self._model.door, self._vehicle.velocity
        normal, bend = door.normal(tip_angle), door.bend(tip_angle)
        beyond = float(normal @ velocity) + self._lever * tip_rate
        change = 0.0 if self._beyond is None else beyond - self._beyond
        self._beyond = beyond
        taken = (
            self._vehicle.mass * (change / time_step - tip_rate * float(bend @ velocity)) if time_step > 0.0 else 0.0
        )
        return float(normal @ acting) - taken
