"""How far a door is on its way to the goal, whether it is there, and whether going on does any good."""

from __future__ import annotations

import math

from doorman.control.estimation.estimator import Estimate
from doorman.mission.schedule import PlanSchedule
from doorman.mission.since import since
from doorman.model import Model
from doorman.planning.pace import OPEN

_WITHIN = 0.006
"""A door that rests within this of the goal is open: twice what the tip's angle is uncertain by [rad]. It grows with every hold
time that the door is near the goal, where friction may keep it."""
_PATIENCE = 8.0
"""A door that swings about the goal, `OPEN` away at most, is near enough after so many hold times: of some swings."""
_STEP = math.radians(0.5)
"""By which a door must have come nearer to the goal to get on [rad]."""
_LENIENT = 0.9
"""Largest share of `OPEN` that `_WITHIN` may be of a short lever, which the same error of the tip turns farther."""
_STUCK, _PRESSED = 10.0, 3.0
"""Time without progress after which an opening is given up, and after the largest push that there is [s]: no more will come."""
_LARGEST = 0.9
"""Share of that push from which on it is the largest: tilt and thrust follow with errors."""
_SURELY = 2.0
"""Deviations of the angle by which a door may seem to be farther."""
_HEADING_LOST = math.radians(40.0)
"""A vehicle that is turned so far from the heading that keeps step with the door does not find back [rad]."""


class Opening:
    """One attempt, from the touch until the door is open; or until it is back at the start."""

    def __init__(self, model: Model, schedule: PlanSchedule, back: bool = False) -> None:
        self._model, self._schedule = model, schedule
        self._goal = model.start_angle if back else model.goal_angle
        self._sense = -model.travel.sense if back else model.travel.sense
        self._hold_time = model.scenario.mission.hold_time
        self._within = min(model.turn_scale * _WITHIN, _LENIENT * OPEN)
        self._nearest, self._got_on_at, self._passed = math.inf, 0.0, False
        self._swung = 0.0
        control = model.scenario.control
        self._most = _LARGEST * min(control.max_push, model.vehicle.weight * math.tan(control.max_tilt))
        self._pressed_at = math.inf
        self._near_since: float | None = None
        self._there_since: float | None = None

    def resume(self, now: float) -> None:
        """Begin, or go on after contact was regained."""
        self._nearest, self._got_on_at, self._pressed_at = math.inf, now, math.inf

    def update(self, estimate: Estimate) -> None:
        """Take in where the door is; once per tick."""
        now, off = estimate.time, estimate.door_angle - self._goal
        self._passed = self._passed or self._past(estimate) > self._within
        if self._passed and abs(off) > self._nearest + _STEP:
            self._nearest = abs(off)  # a grip brings a door back that has passed the goal, and so may a closer
        if abs(off) < self._nearest - _STEP:
            self._nearest, self._got_on_at = abs(off), now
        self._swung = max(self._swung, self._model.travel.length - abs(off))
        self._near_since = since(self._near_since, abs(off) < OPEN, now)
        if self._near_since is not None:
            self._got_on_at = now  # one that leaves the goal has time to come back
        if self._got_on_at == now:
            self._pressed_at = math.inf
        headwind = min(float(estimate.normal @ estimate.wind), 0.0)
        if estimate.normal_force > self._most + headwind:
            self._pressed_at = min(self._pressed_at, now)
        there = abs(off) < self._within * max(self._waited(now), 1.0)
        self._there_since = since(self._there_since, there and estimate.rests, now)

    @property
    def near(self) -> bool:
        """Whether the door is near the goal."""
        return self._near_since is not None

    def done(self, now: float) -> bool:
        """Whether the door has rested at the goal for long enough, or swings about it and no farther."""
        rested = self._there_since is not None and now - self._there_since >= self._hold_time
        return rested or self._waited(now) >= _PATIENCE

    def passed(self, estimate: Estimate) -> bool:
        """Whether the door is a little past the goal, for all that is known: a push can do no more."""
        return 0.0 < self._past(estimate) <= OPEN + _SURELY * estimate.angle_deviation

    def stuck(self, estimate: Estimate) -> str:
        """Reason to give the opening up; empty if there is none."""
        door, angle = self._model.door, estimate.door_angle
        turned = abs(math.remainder(estimate.yaw - float(self._model.on_the_way(angle)[2]), 2.0 * math.pi))
        if turned > _HEADING_LOST:
            return f"the heading is lost: {math.degrees(turned):.0f}° off at {door.in_words(angle)}"
        if self.stuck_for(estimate.time) < _STUCK and estimate.time - self._pressed_at < _PRESSED:
            return ""
        if self._past(estimate) > OPEN:
            return f"the leaf has gone past the goal, to {door.in_words(angle)}"
        resists = max(0.0, self._model.coupling.lever_length * estimate.normal_force)
        stands = f"the door does not move on from {door.in_words(angle)} against {door.torque_in_words(resists)}"
        return stands + (f"; the last plan: {self._schedule.refusal}" if self._schedule.refusal else "")

    def stuck_for(self, now: float) -> float:
        """Time without progress; none near the goal [s]."""
        return now - self._got_on_at

    def may_go_on(self, estimate: Estimate) -> bool:
        """Whether another attempt may do better: plans are flown, the door has swung, and is not beyond the goal."""
        swung = self._swung > OPEN and self._past(estimate) <= OPEN
        return swung and not self._schedule.refusal and not self._schedule.is_silent(estimate.time)

    def _past(self, estimate: Estimate) -> float:
        """How far the door is beyond the goal [rad]."""
        return self._sense * (estimate.door_angle - self._goal)

    def _waited(self, now: float) -> float:
        """For how many hold times the door has been near the goal."""
        return 0.0 if self._near_since is None else (now - self._near_since) / self._hold_time
