"""How far the door is on its way to the goal, and for how long it has been there."""

from __future__ import annotations

import math

from doorman.control.estimation.estimator import Estimate
from doorman.mission.since import since
from doorman.model import Model

NEARLY = math.radians(4.0)
"""Nearer to the goal, a door that comes loose with a jerk would pass it [rad]."""
STANDS = 0.01
"""A door whose average rate is smaller stands [rad/s]."""
STILL_OPEN = math.radians(1.5)
"""A held door that is farther from the goal is pushed again, if it is not open enough [rad]."""
HELD_WITHIN = 0.006
"""A gripped door that stands within this of the goal is open: twice what the tip's angle is uncertain by [rad]."""
SLOW = 0.005
"""A gripped door that is slower at the goal, for a while, is taken to stay there [rad/s],"""
AT_GOAL = math.radians(0.9)
"""if it is no farther off [rad];"""
_LENIENCE = math.radians(0.35)
"""by which that is more with every time that it passed the goal but the first, up to `_NEAR`: it sticks and slips [rad]."""
_NEAR = math.radians(2.0)
"""A door that swings about the goal and no farther is near enough after a while [rad]."""
_SETTLING = 4.0
_PATIENCE = 12.0
"""Hold times after which a slow door, and one that swings about the goal, is there."""
_BEYOND = math.radians(2.0)
"""A held door that is so far past the goal has not been opened as asked."""
_AVERAGED = 0.5
"""Over which the rate is averaged [s]."""
_STEP = math.radians(0.5)
"""By which a door must have come nearer to the goal to get on [rad]."""
_LEVER, _LENIENT = 0.7, 0.9
"""Length of the lever that these angles and rates are for, of the shipped vehicle [m]: the same error of the tip turns a
shorter one farther. Largest share of `_NEAR` that such an angle may have."""
_SWINGING = 4
"""Such steps after which it has swung."""


class Progress:
    """Progress of one opening.

    Args:
        model: Model of the scenario.
        pushes: Whether the tip can only push, and holds the door at the goal.
    """

    def __init__(self, model: Model, pushes: bool) -> None:
        self._pushes = pushes
        self._hold_time = model.scenario.mission.hold_time
        self._goal = model.goal_angle
        self._way = abs(model.start_angle - self._goal)
        short = max(_LEVER * model.scale.length / model.coupling.lever_length, 1.0) if model.door.in_plane else 1.0
        self._within, self._at_goal = (min(short * angle, _LENIENT * _NEAR) for angle in (HELD_WITHIN, AT_GOAL))
        self._slow = short * SLOW
        self.rate = 0.0
        """The door's, averaged [rad/s]."""
        self.passes = -1
        """How often it passed the goal."""
        self.stood_before = 0.0
        """For how long it has stood just before the goal, and is not held [s]."""
        self._side = 0.0
        self._nearest = math.inf
        self._got_on_at = 0.0
        self._steps = 0
        self._good_since: float | None = None
        self._slow_since: float | None = None
        self._near_since: float | None = None
        self._held_since: float | None = None

    def resume(self, now: float) -> None:
        """Begin, or go on after contact was regained."""
        self.stood_before, self._nearest, self._got_on_at = 0.0, math.inf, now

    def update(self, estimate: Estimate, held: bool, time_step: float) -> None:
        """Take in where the door is. Once per tick."""
        now, off = estimate.time, estimate.door_angle - self._goal
        self.rate += min(time_step / _AVERAGED, 1.0) * (estimate.door_rate - self.rate)
        stands = 0.0 < off < NEARLY and abs(self.rate) < STANDS and not held
        self.stood_before = self.stood_before + time_step if stands else 0.0
        if self.passes > 0 and abs(off) > self._nearest + _STEP:
            self._nearest = abs(off)  # a grip brings a door back that has passed the goal, and so may a closer
        if abs(off) < self._nearest - _STEP:
            self._steps += math.isfinite(self._nearest) and abs(off) < self._way  # where it begins is no step
            self._nearest, self._got_on_at = abs(off), now
        if abs(off) > HELD_WITHIN and math.copysign(1.0, off) != self._side:
            self._side, self.passes = math.copysign(1.0, off), self.passes + 1
        self._good_since = since(self._good_since, abs(off) < self._within and abs(self.rate) < 2.0 * self._slow, now)
        self._slow_since = since(self._slow_since, abs(off) < self.at_goal and abs(self.rate) < self._slow, now)
        self._near_since = since(self._near_since, abs(off) < _NEAR, now)
        if self._near_since is not None:
            self._got_on_at = now  # one that leaves the goal has time to come back
        stays = held and -_BEYOND < off < STILL_OPEN and abs(self.rate) < STANDS
        self._held_since = since(self._held_since, stays, now)

    @property
    def at_goal(self) -> float:
        """Distance from the goal at which a gripped door may stay [rad]."""
        return min(self._at_goal + _LENIENCE * max(0, self.passes - 1), _NEAR)

    @property
    def swung(self) -> bool:
        """Whether the door has come nearer to the goal for a while."""
        return self._steps > _SWINGING

    def stuck_for(self, now: float) -> float:
        """Time without progress; none at the goal [s]."""
        return now - self._got_on_at

    def done(self, now: float) -> bool:
        """Whether the door has stood at the goal for long enough, and stands still right now."""
        if self._pushes:
            return self._held_since is not None and now - self._held_since >= self._hold_time
        good = self._good_since is not None and now - self._good_since >= self._hold_time
        slow = self._slow_since is not None and now - self._slow_since >= _SETTLING * self._hold_time
        near = self._near_since is not None and now - self._near_since >= _PATIENCE * self._hold_time
        return ((good or slow) and abs(self.rate) < 0.4 * self._slow) or near
