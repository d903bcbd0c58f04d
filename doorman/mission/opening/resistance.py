"""What a gripped hinge resists with, as plans are told: learnt while the door swings, and more where it sticks."""

from __future__ import annotations

import math

from doorman.control.estimation.estimator import Estimate
from doorman.mission.opening.progress import AT_GOAL, HELD_WITHIN, NEARLY, SLOW, Progress
from doorman.model import Model

_SWINGS = 0.02
"""A door that opens faster teaches its resistance [rad/s],"""
_LEARNT = 1.0
"""within this time [s]."""
_STICKS = 0.01
"""A slower door sticks [rad/s]."""
_NUDGE = 0.8
"""Growth of the friction that plans are told of while a door sticks, of the shipped vehicle [N m/s]."""
_FORGOTTEN = 0.3
"""Time in which it is forgotten once the door moves [s]."""
_MOST_STICTION = 0.7
"""Of the shipped vehicle, as this is as much as plans are made to push harder [N m]."""
_ARRIVED = math.radians(0.5)
_ARRIVING = 0.05
"""A gripped door that comes this near to the goal, and is no faster, is left to its friction [rad], [rad/s]."""
_AVERAGED, _STAYS = 0.5, 2.0
"""Over which a torque that is to hold the door is averaged [s]; friction has held it that has done so for longer [s]."""
_NO_FRICTION = 0.1
"""A gripped room door with less, by estimate, does not rest by itself [N m]."""
_LEFT_TO_FRICTION = 0.7
"""Share of its friction that is then counted on."""
_UNSURE = 0.2
"""By which a room door's closer may seem to be stronger than friction for a gripped door to be tried nevertheless [N m]."""
_LEAST_RESISTANCE = 0.15
"""A room door that resisted a grip by less has no friction to speak of: it would drift away when let go [N m]."""


class Resistance:
    """Resistance of the door in one opening.

    Args:
        model: Model of the scenario.
        progress: Of the opening.
    """

    def __init__(self, model: Model, progress: Progress) -> None:
        control = model.scenario.control
        self._progress = progress
        self._goal, self._travel = model.goal_angle, model.travel
        self.is_open = False
        """Whether the door has been brought to the goal: friction may then hold it where it is near enough."""
        self._observed = control.door_observer_rate > 0.0
        self._most = control.max_door_disturbance
        self._hinge = model.hinge_scale
        self._growth, self._most_stiction = (
            _NUDGE * model.scale.torque / model.scale.time,
            _MOST_STICTION * model.scale.torque,
        )
        self.in_swing = 0.0
        """Torque against the way to the goal while the door swung last [N m]."""
        self._stiction = 0.0
        self._average: float | None = None
        self._rest: float | None = None
        self._rested, self._stood = False, 0.0

    def learn(self, estimate: Estimate, time_step: float) -> None:
        """Take in what the door resists with while it swings. Once per tick."""
        if self._travel.ahead(self._progress.rate) > _SWINGS:
            resists = self._travel.ahead(estimate.door_disturbance)
            self.in_swing += min(time_step / _LEARNT, 1.0) * (resists - self.in_swing)

    def torque(self, estimate: Estimate, time_step: float) -> float:
        """Torque of the hinge beyond what the scenario names, in the sense of damping; once per tick that plans [N m]."""
        off, torque = estimate.door_angle - self._goal, estimate.door_disturbance
        before = torque if self._average is None else self._average
        self._average = average = before + min(time_step / _AVERAGED, 1.0) * (torque - before)
        stands = self._rest is not None and abs(self._progress.rate) < SLOW
        self._stood = self._stood + time_step if stands else 0.0
        self._rested = self._rested and self._stood < _STAYS  # friction that has held it once may hold it again
        rests = estimate.hinge.friction >= _NO_FRICTION * self._hinge and (
            self.is_open or self._travel.ahead(off) > 0.0
        )
        self._nudge(off, AT_GOAL if rests else HELD_WITHIN, time_step)
        resists = self._travel.ahead(self._gripped(off, average, estimate) - self._stiction)
        return self._travel.ahead(min(resists, self._most))

    def keeps_the_door(self, estimate: Estimate) -> bool:
        """Whether the door may stay by itself: the closer seems stronger by no more than a deviation, nor by `_UNSURE`.

        What is let go is watched then, before it is left.
        """
        hinge = estimate.hinge
        unsure = min(hinge.spare_deviation, _UNSURE * self._hinge)
        return self.in_swing >= _LEAST_RESISTANCE * self._hinge and hinge.spare + unsure > 0.0

    def _nudge(self, off: float, tolerance: float, time_step: float) -> None:
        """Tell plans of more and more friction while the door sticks beside the goal: they push, or pull, harder."""
        stays = self._rest is not None and self._progress.passes > 1
        sticks = abs(self._progress.rate) < _STICKS  # averaged: the noise of a rate is no motion
        if self._observed and not stays and sticks and abs(off) > tolerance:
            stiction = self._stiction + math.copysign(self._growth * min(abs(off) / NEARLY, 1.0) * time_step, off)
            self._stiction = min(max(stiction, -self._most_stiction), self._most_stiction)
        else:
            self._stiction *= math.exp(-time_step / _FORGOTTEN)

    def _gripped(self, off: float, average: float, estimate: Estimate) -> float:
        """Torque of a gripped hinge, without its friction where the door should come to rest: it is what holds the door there.

        Else the push that overcomes the friction of a slow door carries it beyond the goal, by degrees. One without friction
        follows whatever it is pushed with: what is estimated brings it to the goal, and a torque of the moment away from it.
        """
        torque, rate = estimate.door_disturbance, self._progress.rate
        if estimate.hinge.friction < _NO_FRICTION * self._hinge:
            self._rest = None
        elif abs(off) > self._progress.at_goal:
            self._rest = None
            if off * rate > 0.0 and abs(rate) > _STICKS:  # it passes the goal, or leaves it
                torque = _left_to_friction(torque, estimate.hinge.friction, rate)
        elif self._progress.passes > 1 and abs(rate) < SLOW:
            self._rest = average if self._rest is None else self._rest
        elif not self._rested and abs(off) < _ARRIVED and abs(rate) < _ARRIVING:
            self._rested = True  # once: a door that does not stay so is held against its friction
            self._rest = _left_to_friction(average, estimate.hinge.friction, rate)
        return torque if self._rest is None else self._rest


def _left_to_friction(torque: float, friction: float, rate: float) -> float:
    """Torque of a hinge, in the sense of damping, whose friction is to stop the door, or to hold it [N m]."""
    counted = _LEFT_TO_FRICTION * max(0.0, friction)
    if rate < 0.0:
        return min(torque + counted, max(torque, 0.0))
    return max(torque - counted, min(torque, 0.0))
