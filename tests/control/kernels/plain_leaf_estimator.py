"""Plain twin of `LeafEstimator`."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from plain_parts import PlainHinge, PlainMonitor, PlainWind

from doorman.control.center_of_mass import center_of_mass
from doorman.control.estimation.beliefs import VEHICLE_OBSERVER_RATE, Beliefs, ContactThresholds
from doorman.control.estimation.door_filter import DoorFilter, HingeEstimate
from doorman.control.estimation.leaf_estimator import LeafEstimate
from doorman.control.observers.vehicle_observer import VehicleObserver
from doorman.control.state_converter import StateConverter
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import euler_rates
from doorman.model import Model
from doorman.planning.limits import largest_push
from doorman.signals import Measurement

Array = np.ndarray

_NEAR = 0.03
"""A tip that is farther from the leaf's place does not touch it [m]."""
_FACE, _MEASURED = 0.02, 0.3
"""Deviation of where the face stands [m], which the first touch measures in so long [s],"""
_STOPPED, _WENT_ON = 0.03, 0.015
"""with a tip that has stopped [m/s]; one that goes on by the second has met nothing [m]."""
_AJAR = 0.04
"""No face stands so far behind its place: a leaf that is met there has been opened [m]."""
_TIP_NOISE, _TIP_TIME = 0.003, 0.05
"""Noise of the tip's place, which is a new one after the latter [m], [s]."""
_LEAST = 0.2
"""Force of the shipped vehicle's tip that touches [N]."""
_CARRIED = 0.5
"""Share of the normal force that friction is believed to carry."""
_ON_LEAF = 0.5
"""Wind that is expected on the leaf, as a share of the vehicle's."""
_MOVES = 0.02
"""A door that is faster teaches its resistance [rad/s],"""
_LEARNT = 0.3
"""in this time [s]."""
_NUDGE, _QUICKENS, _NUDGE_FADES = 0.6, 2.5, 0.5
"""Growth of the resistance that a plan is told of while a door sticks [N m/s], twice as quick at the second [N m]."""
_QUICK, _GIVES_WAY = 8.0, 0.8
"""A seal or a latch gives way at once: an observer this quick [rad/s] that finds so much less resistance of a room"""
_BREAKS_LOOSE = 0.05
"""A leaf that has gone no farther may still be held by a seal or a latch: it tells nothing of the wind [rad]."""
_HELD_FIRST = 0.1
"""Seals and latches hold no farther [rad]."""
_NUDGED_WITHIN = 0.07
"""Nearer to the goal it grows in proportion [rad]."""
_STANDS_AT_GOAL = 0.015
"""Nearer than this it does not grow [rad]."""
_DRAWN_BACK, _FAR_BACK, _FADED, _CERTAIN = 0.02, 0.06, 0.4, 3.0
"""A tip that draws back by more than the first, while it feels less than the last, a share of what the hinge resists with."""
_GHOST, _GHOST_RATE, _GHOST_SUM = 1.5, 0.06, 0.3
"""nor one whose leaf would be driven by more than the first [N m], in a cumulative sum;"""
_LIGHTEST, _BEHIND = 0.6, 0.02
"""nor one that is so far before a leaf that stands in its frame."""
_SETTLED = 0.5
"""once the touch is older [s]."""
_PAST = 0.007
"""A tip that is farther than it last was in contact has met the leaf again [rad]."""
_LEAST_RESISTANCE, _FIRST_RESISTANCE = 0.05, 0.3
"""Of a room door's hinge, and what is believed at first [N m]."""


class PlainLeafEstimator:
    """Estimates of one flight."""

    def __init__(self, model: Model, converter: StateConverter) -> None:
        settings = Beliefs.of(model)
        self._converter = converter
        self._mass, self._lever = model.vehicle.mass, model.coupling.lever_length
        self._doubt = 0.0  # of the torque, as the wind in contact is doubted [N m]
        self._weight_force = np.array([0.0, 0.0, self._mass * GRAVITY])
        self._goal, self._rest = model.goal_angle, float(model.door.rest_angle)
        self._start = model.start_angle
        self._most_resistance = largest_push(model, model.scenario.control.max_tilt) * self._lever
        """Torque of the largest push [N m]."""
        size = model.scale
        self._least = _LEAST * size.force
        self._nudge, self._quickens, self._hinge = (
            _NUDGE * size.torque / size.time,
            _QUICKENS * size.torque,
            model.hinge_scale,
        )
        self._vehicle = VehicleObserver(self._mass, VEHICLE_OBSERVER_RATE)
        self._monitor = PlainMonitor(ContactThresholds.of(model))
        self._monitor.declare(model.scenario.mission.start == "contact")
        self._model, self._leaf, self._touched_at, self._last = model, model.door, 0.0, -math.inf
        self._opened = 0.0
        self._shut = model.door.upper_limit
        self._stood = -math.inf
        self._begin()
        self._wind, self._friction = PlainWind(size.force, self._hinge), np.zeros(2)
        self._face, self._face_variance, self._closed = 0.0, _FACE**2, True
        self._met: float | None = None
        self._measured = 0.0
        self._angle_deviation = self._lever * settings.angle_deviation
        self._levers = (self._lever, _ON_LEAF * model.door.wind_lever)
        self._yaw = 0.0
        self._reads: list[float] | None = None
        self._offset, self._offset_variance = 0.0, model.scenario.estimation.tip_force_offset**2
        self._reading_noise, self._fastest = model.scenario.estimation.tip_force_noise**2, VEHICLE_OBSERVER_RATE

    def update(
        self, measured: Measurement, rotors: Array, time_step: float, seeks: bool, wanted: float
    ) -> LeafEstimate:
        """Take in one measurement."""
        lifts = rotors - self._weight_force
        center = center_of_mass(self._model.vehicle, measured)
        self._vehicle.update(measured.position, measured.pose_time, measured.time, lifts, time_step, center)
        velocity, felt = self._vehicle.velocity.copy(), self._vehicle.outer_force
        self._wind.predict(time_step)
        self._read(measured.tip_force, time_step)
        tip = self._tip(measured, velocity)
        normal = self._leaf.normal(self._door.angle)
        push = float(normal @ lifts)
        touching = self._contact(tip, normal, measured.tip_force, measured.time, time_step, seeks)
        if touching and self._closed:
            touching, tip = self._first_touch(tip, time_step)
        wind = self._wind.force
        acting = push + float(normal @ wind)
        if time_step > 0.0:
            self._turn_wind(float(self._wind.state[3]) * time_step)
        self._door.update(acting, touching, tip[0], measured.pose_time, measured.time, time_step, wind=wind)
        angle, rate = self._door.angle, self._door.rate
        if touching:
            self._torque.update(angle, rate, acting, self._door.inertia, time_step)
            self._quick.update(angle, rate, acting, self._door.inertia, time_step)
            bare = -self._bare.update(angle, rate, push, self._door.inertia, time_step)
            self._stood = max(self._stood, angle)
            loose = self._stood - angle > _BREAKS_LOOSE
            if loose and self._bare.rate > 0.0:  # an observer that is off tells nothing
                self._wind.pushed(normal, self._levers, bare, -rate, self._door.stiffness, time_step)
        else:
            for observer in (self._torque, self._quick, self._bare):
                observer.pause()
            if seeks:
                self._door.passed(tip[0])
        resistance = self._resistance(touching, wanted, time_step)
        force = self._forces(normal, felt, acting, resistance, time_step) if touching else 0.0
        attitude, rates = self._attitude(measured)
        return LeafEstimate(
            self._vehicle.position.copy(), velocity, attitude, rates, np.array(measured.arm_angles), self._door.angle,
            self._door.rate, touching, force, self._friction.copy(), self._wind.force, resistance,
            self._friction_share(), self._door.inertia, self._face, self._lever, self._presses(normal),
            self._hinge_of(touching),
        )  # fmt: skip

    def _turn_wind(self, angle: float) -> None:
        """Turn the wind on the leaf as that on the vehicle turns [rad]."""
        turn = np.eye(9)
        turn[7:, 7:] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
        self._door.state[:] = turn @ self._door.state
        self._door.covariance[:] = turn @ self._door.covariance @ turn.T

    def _hinge_of(self, touching: bool) -> HingeEstimate:
        """The hinge, with the doubt of the wind in contact and of changes on the way in the deviation of its torque."""
        if touching:
            normal = self._leaf.normal(self._door.angle)
            wind = sum(self._levers) * math.sqrt(float(normal @ self._wind.covariance[:3, :3] @ normal))
            way = abs(self._door.angle - self._model.start_angle)
            self._doubt = math.hypot(wind, 0.7 * self._hinge * math.sqrt(way / 3.0))
        hinge = self._door.hinge()
        return replace(hinge, torque_deviation=math.hypot(hinge.torque_deviation, self._doubt))

    def _weight(self) -> float:
        """Torque of the leaf's weight against opening [N m]."""
        return self._model.travel.ahead(self._leaf.weight_torque(self._door.angle))

    def _friction_share(self) -> float:
        """Share of friction in what the hinge resists with, beside the leaf's weight."""
        closer = max(self._door.stiffness * (self._rest - self._door.angle), 0.0) + abs(self._leaf.closing_torque)
        slides = self._door.friction + _LEAST_RESISTANCE * self._hinge
        return slides / (slides + closer)

    def _tip(self, measured: Measurement, velocity: Array) -> tuple[float, float]:
        """Angle and rate of a leaf that the tip is on [rad], [rad/s]."""
        angle, rate = self._converter.tip(measured, velocity)
        return angle - self._model.coupling.angle_of_face(self._face), rate

    def _first_touch(self, tip: tuple[float, float], time_step: float) -> tuple[bool, tuple[float, float]]:
        """Where the face stands, as a closed leaf stands at a known angle; and whether anything has been met."""
        off, speed = self._lever * (tip[0] - self._start), -self._lever * tip[1]
        before = off + self._face
        self._met = before if self._met is None else self._met
        if self._met < -_AJAR:
            self._closed = False
            self._deepest = tip[0]
            self._door.meet(tip[0])
            return True, tip
        if abs(self._met - before) > _WENT_ON and abs(speed) > _STOPPED:
            self._face, self._face_variance, self._met, self._deepest = 0.0, _FACE**2, None, math.inf
            self._monitor.declare(False)
            self._wind.lost(self._vehicle.outer_force)
            return False, tip
        if abs(speed) < _STOPPED:
            noise = _TIP_NOISE**2 * max(_TIP_TIME / max(time_step, 1e-6), 1.0) + self._angle_deviation**2
            gain = self._face_variance / (self._face_variance + noise)
            self._face += gain * off
            self._face_variance *= 1.0 - gain
            self._measured += time_step
        self._closed = self._measured < _MEASURED
        self._deepest = self._start
        self._door.meet(self._start)
        return True, (self._start, 0.0)

    def _begin(self) -> None:
        """Forget what resists the leaf: something went wrong. It stands where the tip left it, or farther on."""
        self._sought = True
        stands = self._door.angle if hasattr(self, "_door") else None
        self._door = DoorFilter(self._model, Beliefs.of(self._model))
        if stands is not None:
            self._door.meet(stands)
        rate = self._model.scenario.control.door_observer_rate
        most = self._most_resistance
        self._torque = PlainHinge(self._model, rate, most, whole=True)
        self._bare = PlainHinge(self._model, rate, most, whole=True)
        self._quick = PlainHinge(self._model, max(rate, _QUICK), most, whole=True)
        self._stood = -math.inf
        self._deepest, self._ghost = math.inf, 0.0
        driven = max(-self._weight(), 0.0)  # its friction is more, as it stands
        self._resists, self._moved, self._more = _FIRST_RESISTANCE * self._hinge + driven, False, 0.0

    def _contact(
        self, tip: tuple[float, float], normal: Array, reading: float | None, now: float, time_step: float,
        seeks: bool,
    ) -> bool:  # fmt: skip
        """Whether the tip touches; the wind is what is felt where it does not."""
        felt, monitor = self._vehicle.outer_force, self._monitor
        reach = _NEAR + 2.0 * math.sqrt(self._face_variance) * self._closed
        near = seeks and self._lever * (tip[0] - self._door.angle) < reach
        if not seeks:
            monitor.declare(False)
            self._sought = False
        elif not self._sought:
            self._begin()
        was = monitor.touching
        reads, pulled, force = self._reads, float(normal @ (self._wind.force - felt)), self._presses(normal)
        if reads is not None and was:
            noise = self._reading_noise, self._offset_variance
            self._wind.pressed(normal, float(normal @ felt) + reads[2], *noise, time_step)
        elif not was:
            beside = felt if reads is None else felt + reads[2] * normal
            self._wind.feel(beside, near and reads is None, time_step)
        if not (was or near):
            monitor.listen(pulled, time_step)
            if reading is not None:
                self._learn_offset(reading)
        touching = seeks and monitor.update(force if near or was or reads else 0.0, time_step)
        if touching and not was:
            self._deepest = tip[0]
            self._note_touch(now, tip[1])
        if reads is not None:
            if touching:
                self._deepest, self._last = min(self._deepest, tip[0]), now
            return touching
        if near and not touching and tip[0] < self._deepest - _PAST and math.isfinite(self._deepest):
            touching = True
            self._note_touch(now, tip[1])
            monitor.declare(True)
            expected = max((self._resists + self._more + self._weight()) / self._lever, self._least)
            self._wind.met(normal, expected - force)
            force = expected
        doubt = math.sqrt(max(float(normal @ self._wind.covariance[:3, :3] @ normal), 0.0))
        if touching and self._is_none(tip, force, doubt, now, time_step):
            touching = False
            monitor.declare(False)
            self._wind.lost(felt)
        if touching:
            self._last = now
        return touching

    def _note_touch(self, now: float, tip_rate: float) -> None:
        """A tip that bounces still touches since then."""
        self._opened, self._ghost = -tip_rate, 0.0
        if now - self._last > _SETTLED:
            self._touched_at = now

    def _read(self, reading: float | None, time_step: float) -> None:
        """Smooth a reading, less the offset, by three poles as late as the observer of the outer force."""
        if reading is None:
            self._reads = None
            return
        late, value = float(self._vehicle.memory[16]), reading - self._offset
        rate = self._fastest if late <= 0.0 else min(self._fastest, 0.6 / late)
        share = 1.0 - math.exp(-time_step / (1.0 / rate + late / 3))
        reads = self._reads or [value] * 3
        for k in range(3):
            reads[k] += share * (value - reads[k])
            value = reads[k]
        self._reads = reads

    def _presses(self, normal: Array) -> float:
        """Force of the tip along the normal: as it is read, or else wind less outer force [N]."""
        if self._reads is not None:
            return self._reads[0]
        return float(normal @ (self._wind.force - self._vehicle.outer_force))

    def _learn_offset(self, reading: float) -> None:
        """Take in a reading of a tip that is far from everything."""
        off, noise = reading - self._offset, self._reading_noise
        if self._offset_variance < noise and abs(off) > 4.0 * math.sqrt(noise):
            return
        gain = self._offset_variance / (self._offset_variance + noise)
        self._offset += gain * off
        self._offset_variance *= 1.0 - gain
        self._reads = [0.0] * 3

    def _is_none(self, tip: tuple[float, float], force: float, doubt: float, now: float, time_step: float) -> bool:
        """Whether what the tip does contradicts a contact."""
        self._deepest = min(self._deepest, tip[0])
        gained, self._opened = -tip[1] - self._opened, -tip[1]
        bears = max(self._resists + max(self._more, 0.0) + self._weight(), 0.0)
        hinge, excess = self._lever * force * time_step - _LIGHTEST * self._model.door.inertia * gained, 0.0
        settled = now - self._touched_at > _SETTLED
        if tip[1] < -_GHOST_RATE:
            excess = -hinge
        elif settled and tip[1] > _MOVES and force < _CERTAIN * doubt:
            excess = hinge - bears * time_step
        self._ghost = max(0.0, self._ghost + excess - _GHOST * self._hinge * time_step)
        friction = self._friction_share() * (self._resists + self._more)
        shuts = bears - 2.0 * friction
        faded = self._lever * force < _FADED * (shuts if shuts > 0.0 else bears)
        drawn = tip[0] - self._deepest
        gone = drawn > _DRAWN_BACK if faded else drawn > _FAR_BACK and force < _CERTAIN * doubt
        back = settled and tip[1] > _MOVES and gone
        behind = self._lever * (tip[0] - self._shut) > _BEHIND + 2.0 * math.sqrt(self._face_variance)
        if not (back or behind or self._ghost > _GHOST_SUM * self._hinge):
            return False
        self._ghost = 0.0
        if back or behind:
            self._door.meet(self._deepest)
        else:
            self._deepest = math.inf
        return True

    def _resistance(self, touching: bool, wanted: float, time_step: float) -> float:
        """Torque of the hinge against opening: learnt while the door moves, and more where it sticks [N m]."""
        opening, left = -self._door.rate, self._door.angle - self._goal
        if touching and opening > _MOVES:
            self._learn(time_step)
        if touching and opening < min(0.3 * wanted, _MOVES) and left > _STANDS_AT_GOAL:
            self._more += (
                self._nudge * (1.0 + self._more / self._quickens) * min(left / _NUDGED_WITHIN, 1.0) * time_step
            )
            self._more = min(self._more, max(self._most_resistance - self._resists, 0.0))
        elif touching and opening > -_MOVES and left < -_STANDS_AT_GOAL:
            self._more -= self._nudge * min(-left / _NUDGED_WITHIN, 1.0) * time_step
            self._more = max(self._more, _LEAST_RESISTANCE * self._hinge - self._resists)
        else:
            self._more *= math.exp(-time_step / _NUDGE_FADES)
        return min(max(self._resists + self._more, _LEAST_RESISTANCE * self._hinge), self._most_resistance)

    def _learn(self, time_step: float) -> None:
        """What a door that moves resists with. What it was pushed with beyond that, while it stuck, is part of it."""
        held = self._stood - self._door.angle < _HELD_FIRST
        least, moved_with = -self._quick.estimate + _GIVES_WAY * self._hinge, 0.0 if held else self._resists
        least = least if held else max(least, moved_with)
        if self._torque.rate > 0.0 and -self._torque.estimate > least:
            self._torque.restart(-least)
        before, share = self._resists, min(time_step / _LEARNT, 1.0) if self._moved else 1.0
        learnt = before + share * (-self._torque.estimate - before)
        self._resists, self._moved = min(learnt, max(least, _LEAST_RESISTANCE * self._hinge)), True
        self._more = max(min(self._more, self._more + before - self._resists, least - moved_with), 0.0)

    def _forces(self, normal: Array, felt: Array, acting: float, resistance: float, time_step: float) -> float:
        """λ of vehicle and leaf that move as one; the wind takes what no contact explains."""
        leaf, vehicle = self._door.inertia, self._mass * self._lever
        reaction = resistance if -self._door.rate > _MOVES else max(-self._torque.estimate, 0.0)
        reaction += self._weight()
        force = max((leaf * acting + vehicle * reaction) / (leaf + vehicle * self._lever), self._least)
        along, up = self._leaf.leaf_direction(self._door.angle), self._leaf.up
        tip_force = self._wind.force - felt
        pressed = float(normal @ tip_force)
        dragged = np.array([along @ tip_force, up @ tip_force])
        carried = _CARRIED * max(pressed, force)
        self._friction = dragged * min(1.0, carried / max(float(np.hypot(*dragged)), 1e-9))
        over = dragged - self._friction
        self._wind.unexplained(along, float(over[0]), time_step)
        self._wind.unexplained(up, float(over[1]), time_step)
        if self._reads is None:
            self._wind.unexplained(normal, min(pressed - self._least, 0.0), time_step)
        return force

    def _attitude(self, measured: Measurement) -> tuple[Array, Array]:
        """Φ now, without jumps of ψ, and Φ̇."""
        rates = np.array(euler_rates(measured.attitude, measured.body_rates))
        attitude = measured.attitude + (measured.time - measured.pose_time) * rates
        attitude[2] += 2.0 * math.pi * round((self._yaw - attitude[2]) / (2.0 * math.pi))
        self._yaw = float(attitude[2])
        return attitude, rates
