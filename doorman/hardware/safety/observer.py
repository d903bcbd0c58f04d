r"""Looks at the links for the supervisor, and estimates the force of the surroundings on the vehicle.

.. math::
    F_e = m \dot v + m g e_3 - f_t R e_3

behind a first-order low-pass, with v of the autopilot and the commanded thrust.
"""

from __future__ import annotations

import math
from collections.abc import Set

import numpy as np

from doorman.arrays import Array
from doorman.gravity import weight_of
from doorman.hardware.dynamixel import ServoSample
from doorman.hardware.mocap import MocapFault, PoseSample
from doorman.hardware.pixhawk import EventKind, SampleStatus, Timeouts, VehicleSample
from doorman.hardware.safety.consistency import SHAPING, HeldTip, Obedience
from doorman.hardware.safety.rules import Observation
from doorman.hardware.vehicle.backend import VehicleBackend
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model

FORCE_LAG = SHAPING
"""Time constant of the estimated force: what is quicker the autopilot brings about itself [s]."""
_TICK_WINDOW = 1.0
"""Missed ticks are counted over this time [s]."""
_LIMPING = 0.3
"""Telemetry that was old within this time still counts so, where the cameras see the vehicle [s]."""


class ForceEstimator:
    """Force of the surroundings from two velocities and the thrust in between."""

    def __init__(self, mass: float, stale: float = Timeouts.state) -> None:
        self._mass, self._stale = mass, stale  # the latter of velocities too far apart for an acceleration [s]
        self._force, self._known = np.zeros(3), False
        self._last: VehicleSample | None = None

    @property
    def lift(self) -> float:
        """The force upwards, over the weight; NaN where the force is not known."""
        return float(self._force[2]) / weight_of(self._mass) if self._known else math.nan

    def update(self, sample: VehicleSample, thrust: float) -> float:
        last, self._last = self._last, sample
        self._known = last is not None and math.isfinite(thrust) and bool(np.isfinite(sample.attitude).all())
        if last is None or not self._known:
            self._force = np.zeros(3)
            return math.nan
        step = sample.position_time - last.position_time
        if 0.0 < step < self._stale:
            lift = thrust * rotation_body_to_world(sample.attitude)[:, 2] - np.array([0.0, 0.0, weight_of(self._mass)])
            force = self._mass * (sample.velocity - last.velocity) / step - lift
            self._force = self._force + (1.0 - math.exp(-step / FORCE_LAG)) * (force - self._force)
        elif step != 0.0:
            self._force = np.zeros(3)
        return float(np.linalg.norm(self._force))


class Observer:
    """Makes observations of a vehicle in flight; used by one thread.

    Args:
        model: Model of the scenario.
        backend: What the mission flies; its links are looked at, never waited for.
        oldest_pose: Age of a pose, as the next one comes, that the controller's gains bear [s].
    """

    def __init__(self, model: Model, backend: VehicleBackend, oldest_pose: float = math.inf) -> None:
        self._backend, self._oldest_pose = backend, oldest_pose
        self._held_tip = HeldTip.of(model)
        self._max_thrust = model.vehicle.max_thrust
        self._stale = backend.links.config.pixhawk.timeouts.state
        self._force = ForceEstimator(model.vehicle.mass, self._stale)
        self._obedience = Obedience()
        self._ticks = (-math.inf, 0, 0.0)
        self._stale_at = -math.inf

    def look(self) -> Observation:
        """What is to be seen now."""
        backend, links, now = self._backend, self._backend.links, self._backend.links.clock.now()
        autopilot, servos = links.autopilot, links.servos.read()
        sample, status = autopilot.state(), autopilot.status()
        commanding = backend.commanding
        thrust = backend.thrust if commanding else math.nan
        pose = None if links.mocap is None else links.mocap.read()
        fit = self._fit(pose, servos, now)
        usable = pose is not None and pose.usable
        stale = sample.status is not SampleStatus.FRESH
        seen: PoseSample | VehicleSample = pose if pose is not None and usable and stale else sample
        unknown = stale and not usable
        self._stale_at = now if stale else self._stale_at
        force = self._force.update(sample, math.nan if stale else thrust)
        limps = usable and now - self._stale_at < _LIMPING
        return Observation(
            now=now,
            armed=sample.armed,
            commanding=commanding,
            authority=status.authority,
            conditions=status.conditions | {EventKind.STATE_STALE} if limps else status.conditions,
            position=pose.position if pose is not None and usable else sample.position,
            speed=math.nan if unknown else float(np.linalg.norm(seen.velocity)),
            tilt=math.nan if unknown else _tilt(seen.attitude),
            thrust_share=thrust / self._max_thrust,
            force=force,
            lift=self._force.lift,
            pose=None if pose is None else pose.quality,
            pose_jumped=pose is not None and not usable and MocapFault.JUMPED in pose.fault,
            pose_age=self._pose_age(pose),
            misfit=fit,
            divergence=float(np.linalg.norm(pose.position - sample.position))
            if pose is not None and usable and not stale
            else math.nan,
            disobedience=self._disobedience(sample, status.conditions, now),
            grips_unheard=commanding and stale and usable and links.holding,
            battery=sample.battery.remaining,
            servo_fault=servos.fault,
            grip_failed=links.grip_failed,
            servo_state=servos.state,
            command_age=now - max(backend.commanded_at, backend.began_at),
            missed_ticks=self._missed(now),
        )

    def _pose_age(self, pose: PoseSample | None) -> float:
        """Age of the newest pose as the next one comes, over the oldest that the gains bear."""
        if pose is None or pose.count == 0:
            return math.nan
        mocap = self._backend.links.config.mocap
        assert mocap is not None, "whose poses these are"
        return (pose.lateness + self._backend.pose_delay + mocap.period) / self._oldest_pose

    def _fit(self, pose: PoseSample | None, servos: ServoSample, now: float) -> float:
        """Misfit of the held tip, in standard deviations."""
        held = self._held_tip
        if held is None:
            return math.nan
        if not self._backend.links.gripped:
            held.let_go()
            return math.nan
        if pose is not None and pose.fresh and servos.fresh:
            n = self._backend.model.n_arm
            arm = servos.angles[:n] + (pose.time - servos.times[:n]) * servos.rates[:n]
            held.take(pose.position, pose.attitude, arm, now)
        return held.misfit

    def _disobedience(self, sample: VehicleSample, conditions: Set[EventKind], now: float) -> float:
        """Angle by which the autopilot steers elsewhere than commanded, while the gripper holds on to the door."""
        backend = self._backend
        commanded = backend.attitude
        holds = EventKind.SETPOINT_STALE in conditions  # the link tells it to, while the controller is late
        if holds or not (backend.commanding and np.isfinite(commanded).all()):
            self._obedience.forget()
            return math.nan
        self._obedience.follow(commanded, now)
        if not backend.links.holding or backend.links.config.pixhawk.setpoints != "attitude":
            return math.nan
        if now - sample.thrust_target_time > self._stale or not np.isfinite(sample.attitude_target).all():
            return math.nan
        return self._obedience.angle(sample.attitude_target)

    def _missed(self, now: float) -> float:
        """Share of the ticks that were missed in the last window that is over."""
        since, missed, share = self._ticks
        if now - since >= _TICK_WINDOW:
            count = self._backend.missed_ticks
            expected = (now - since) * self._backend.links.config.rate  # infinite at first
            share = max(count - missed, 0) / expected
            self._ticks = (now, count, share)
        return share


def _tilt(attitude: Array) -> float:
    roll, pitch = float(attitude[0]), float(attitude[1])
    return math.acos(min(max(math.cos(roll) * math.cos(pitch), -1.0), 1.0)) if math.isfinite(roll + pitch) else math.nan
