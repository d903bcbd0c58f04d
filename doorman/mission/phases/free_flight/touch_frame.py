"""Where the door stands: the tip touches what stands beside the leaf, before the leaf itself."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.motion import DOUBTED, TOUCH_DISTANCE, Glide, arm_rates_to
from doorman.control.position_controller import Setpoint
from doorman.kinematics.doors.frame_places import FramePlace
from doorman.mission.feeler import Feeler
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then

_SPEED = 0.5
"""Before the wall [m/s]: the frame of the poses may drift meanwhile."""
_FAST, _PASSES = 0.08, 0.05
"""Speed of a vehicle that may begin to feel [m/s], and distance at which the reference passes a target on its way [m]."""
_AVERAGED = 4.0
"""Time over which the position controller averages the wind that it counts on while a tip presses [s]."""


class TouchFrame(MissionPhase):
    """Touches every place of `Model.frame_places`, each where the touches before have found it; then back to the hover.

    The tip comes to a place and leaves it along the face's normal. From one to the next it flies before the wall. Where gusts
    have blown it aside by more than a place leaves between rotors and frame, that place is left out.
    """

    phase, gives_way = Phase.TOUCH_FRAME, True  # no leaf reaches the tip there

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        known = None if before is None else before.glide
        self.glide: Glide = known or Glide(estimate.position, estimate.yaw)
        self._model, self._places = attempt.model, list(attempt.model.frame_places)
        self._found, self._hinge = attempt.place, attempt.model.door.hinge_position
        self._feeler: Feeler | None = None
        self._steady_wind, self._strayed = estimate.wind, 0.0
        first = self._before(self._places[0], estimate.time)
        self._plane = float(self._model.door.into @ first[0])
        self._way = [first]

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Fly to the next place, touch it, leave it; the hover follows the last one."""
        self._steady_wind = self._steady_wind + min(time_step / _AVERAGED, 1.0) * (estimate.wind - self._steady_wind)
        if self._feeler is not None:
            return self._feel(estimate, self._feeler)
        setpoint = self._fly(estimate, time_step)
        if self._way:
            return setpoint, None
        if self._places:
            place = self._places[0]
            _, normal = self._placed(place)
            at, yaw, speed = self.glide.position, self.glide.yaw, self.attempt.settings.touch_speed
            self._feeler = Feeler(self._model, at, yaw, normal, speed, self._steady_wind)
            self.attempt.estimator.feel(normal)
            return setpoint, None
        self._found.found = True
        return setpoint, Next(Phase.HOVER, "the frame has been touched")

    def _fly(self, estimate: Estimate, time_step: float) -> Setpoint:
        """Towards the next target of O_B, until the vehicle is there."""
        model, (target, yaw) = self._model, self._way[0]
        rates = arm_rates_to(model.start_arm, estimate.arm_angles)
        setpoint = self.glide.to(target, yaw, _SPEED, rates, time_step)
        last = len(self._way) == 1
        arrived = self.glide.near(target, 0.01 if last else _PASSES) and abs(self.glide.yaw - yaw) < 1e-6
        off, fast = np.linalg.norm(estimate.position - target), np.linalg.norm(estimate.velocity) > _FAST
        there = min(0.5 * self._places[0].room, TOUCH_DISTANCE) if last and self._places else 2.0 * _PASSES
        if arrived and off < there and not (last and fast):
            self._way.pop(0)
        return setpoint

    def _feel(self, estimate: Estimate, feeler: Feeler) -> tuple[Setpoint, Then]:
        """Move the tip on until it meets the face."""
        tip = estimate.position + self._model.coupling.tips(estimate.attitude[None], estimate.arm_angles[None])[0]
        place = self._places[0]
        setpoint, (there, normal) = feeler.step(estimate, tip), self._placed(place)
        beyond = float(normal @ (tip - there))
        if beyond > self._doubt(place, estimate.time) and not estimate.stopped:
            self.attempt.estimator.feel(None)
            return setpoint, GiveUp(
                f"the frame is not where the map has it: nothing up to {1e2 * beyond:.0f} cm behind"
            )
        aside = tip - there - beyond * normal
        off = float(np.linalg.norm(aside))
        strays, self._strayed = off > place.room, max(self._strayed, off)
        if (met := feeler.met(estimate.time)) is None and not strays:
            return setpoint, None
        back = self._before(place, estimate.time)
        self.attempt.estimator.feel(None)
        self._feeler, self.glide = None, Glide(estimate.position, estimate.yaw)
        if met is None:
            self._way = [back]
            return setpoint, None
        self._found.touched(estimate.time, met - self._hinge, place.point - self._hinge, place.normal)
        self._places = [each for each in self._places[1:] if each.clear > self._strayed]
        self._way = [back, self._outside(back)]
        if self._places:
            ahead = self._before(self._places[0], estimate.time)
            self._way += [self._outside(ahead), ahead]
        return setpoint, None

    def _before(self, place: FramePlace, now: float) -> tuple[Array, float]:
        """O_B, shape (3,), world frame [m], and ψ [rad], with the tip before a place as far as that is doubted."""
        model, (there, normal), yaw = self._model, self._placed(place), self._model.start_yaw + place.turn
        away = self._doubt(place, now) + TOUCH_DISTANCE
        tip = model.coupling.tips(np.array([[0.0, 0.0, yaw]]), model.start_arm[None])[0]
        return np.asarray(there - away * normal - tip), yaw

    def _outside(self, target: tuple[Array, float]) -> tuple[Array, float]:
        """A target, back before the wall."""
        (place, yaw), into = target, self._model.door.into
        return place + min(self._plane - float(into @ place), 0.0) * into, yaw

    def _placed(self, place: FramePlace) -> tuple[Array, Array]:
        """Point and normal of a place, as far as the touches tell, shapes (3,), world frame [m]."""
        return self._hinge + self._found.placed(place.point - self._hinge), self._found.turn @ place.normal

    def _doubt(self, place: FramePlace, now: float) -> float:
        """How far a face may be from there [m]."""
        return DOUBTED * self._found.deviation(place.point - self._hinge, place.normal, now)
