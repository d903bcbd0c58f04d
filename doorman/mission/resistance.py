"""What the hinge resists with, as plans are told: learnt while the door swings, and more where it sticks."""

from __future__ import annotations

import math

import numpy as np

from doorman.control.estimator import Estimate
from doorman.mission.progress import NEARLY, SLOW, Progress
from doorman.model import Model
from doorman.planning.hinge import Hinge

_SWINGS = 0.02
"""A door that opens faster teaches its resistance [rad/s],"""
_LEARNT = 1.0
"""within this time [s]."""
_STICKS = 0.01
"""A slower door sticks [rad/s]."""
_NUDGE = 0.8
_PUSHED_NUDGE = 0.6
"""Growth of the friction that plans are told of while a door sticks, with a grip and with a push [N m/s]."""
_FORGOTTEN = 0.3
_PUSHED_FORGOTTEN = 1.0
"""Time in which it is forgotten once the door moves [s]."""
_MOST_STICTION = 1.5
"""[N m]."""
_HELD_MORE = 1.0
"""By which a pushed door that has swung may resist more than it did then, before it is waited for [N m]."""
_FAR_FROM_IT, _LEAST_MORE = math.radians(10.0), 0.3
"""Nearer to the goal it is less in proportion, down to this share: what comes loose must stop before the goal."""
_STANDS_LONG, _GROWTH = 2.0, 0.1
"""A door that has stood just before the goal for longer [s] is pushed more and more [N m/s]."""
_SHARE_MORE = 0.5
"""A door that resists much may resist more by this share anywhere: it also stops the sooner."""
_HELD = 1.0
"""A door that stood for so long in its swing may have been held, [s],"""
_LOOSE = 2.0
"""and is taken to resist by no more than before for this long when it moves on [s]."""
_STOPPED = 0.3
"""A door that stands for so long meanwhile has stopped again [s]."""
_ARRIVED = math.radians(0.5)
_ARRIVING = 0.05
"""A gripped door that comes this near to the goal, and is no faster, is left to its friction [rad], [rad/s]."""
_NO_FRICTION = 0.1
"""A gripped door with less, by estimate, does not rest by itself [N m]."""
_LEFT_TO_FRICTION = 0.7
"""Share of its friction that is then counted on."""
_UNSURE = 0.2
"""By which a closer may seem to be stronger than friction for a gripped door to be tried nevertheless [N m]."""
_LEAST_RESISTANCE = 0.15
"""A door that resisted a grip by less has no friction to speak of: it would drift away when let go [N m]."""
_GUSTINESS = 1.5
"""Wind on the leaf that a door must stand, as a share of what the vehicle feels."""


class Resistance:
    """Of the door in one opening.

    Args:
        model: Model of the scenario.
        progress: Of the opening.
        pushes: Whether the tip can only push.
    """

    def __init__(self, model: Model, progress: Progress, pushes: bool) -> None:
        control = model.scenario.control
        self._progress, self._pushes, self._door = progress, pushes, model.door
        self._goal, self._travel = float(model.goal_state[3]), model.travel
        self._tolerance = model.scenario.push.hold_tolerance
        self._observed = control.door_observer_rate > 0.0
        self._most = control.max_door_disturbance
        self.in_swing = 0.0
        """Torque against the way to the goal while the door swung last [N m]."""
        self._taught = 0.0
        self._stood = 0.0
        self._loose = 0.0
        self._stiction = 0.0
        self._counted_on = 0.0
        self._rest: float | None = None
        self._rested = False

    @property
    def known(self) -> bool:
        """Whether a pushed door has swung for a while, and has shown what it resists with."""
        return self._pushes and self._progress.swung and self._taught > _LEARNT

    def learn(self, estimate: Estimate, time_step: float) -> None:
        """Take in what the door resists with while it swings, and whether it has just been let go of. Once per tick.

        What it was pushed with while it was held is no resistance any more then. If it stops again it is, and was not held.

        Args:
            estimate: What is known now.
            time_step: Since the last call [s].
        """
        self._loose = max(0.0, self._loose - time_step)
        if abs(estimate.door_rate) < _STICKS:
            self._stood += time_step
            if self._loose > 0.0 and self._stood > _STOPPED:
                more = min(self._travel.ahead(estimate.door_disturbance), self.in_swing + _HELD_MORE)
                self.in_swing, self._loose = max(self.in_swing, more), 0.0
        elif self._travel.ahead(estimate.door_rate) > _SWINGS:
            if self._stood > _HELD and self.known:
                self._loose, self._stiction = _LOOSE, 0.0
            self._stood = 0.0
            if self._loose == 0.0:
                self._taught += time_step
                resists = self._travel.ahead(estimate.door_disturbance)
                self.in_swing += min(time_step / _LEARNT, 1.0) * (resists - self.in_swing)

    def torque(self, estimate: Estimate, time_step: float) -> float:
        """Torque of the hinge beyond what the scenario names, in the sense of damping; once per tick that plans [N m].

        Args:
            estimate: What is known now.
            time_step: Since the last tick [s].
        """
        off = estimate.door_angle - self._goal
        self._nudge(off, estimate.door_rate, time_step)
        torque = self._pushed(estimate) if self._pushes else self._gripped(off, estimate)
        resists = min(self._travel.ahead(torque - self._stiction), self.most(off))
        return self._travel.ahead(resists)

    def most(self, off: float) -> float:
        """Largest resistance that plans are told of [N m].

        A door that has swung and stands is held by somebody, or sticks a little more than it slid. Whoever holds it will let
        it go, and a push that has grown meanwhile would throw it beyond the goal.

        Args:
            off: Distance of the door from the goal, positive before it [rad].
        """
        if not self.known:
            return self._most
        least = max(self.in_swing, 0.0)
        more = max(_HELD_MORE * min(max(off / _FAR_FROM_IT, _LEAST_MORE), 1.0), _SHARE_MORE * least)
        more += min(_GROWTH * max(0.0, self._progress.stood_before - _STANDS_LONG), _HELD_MORE)
        return min(self._most, least + (0.0 if self._loose > 0.0 else more))

    def hinge(self, estimate: Estimate, torque: float) -> Hinge:
        """What plans are told: the estimated parameters, and a disturbance that makes their sum what it is now.

        Without an observer that finds that sum, it is the scenario's hinge.

        Args:
            estimate: Of door and hinge.
            torque: Of the hinge now beyond what the scenario names [N m].
        """
        hinge, door = estimate.hinge, self._door
        if not self._observed:
            return Hinge.of(door, torque)
        torque += (door.damping - hinge.damping) * estimate.door_rate
        torque += (door.stiffness - hinge.stiffness) * (estimate.door_angle - door.rest_angle)
        return Hinge(0.0, torque, hinge.inertia, hinge.damping, hinge.stiffness)

    def keeps_the_door(self, estimate: Estimate) -> bool:
        """Whether the door may stay by itself: what is let go is watched then, before it is left.

        Of a pushed door friction is probably stronger than the closer, and the wind on leaf and vehicle besides. Of a gripped
        one it may be: the closer seems stronger by no more than a deviation, nor by `_UNSURE`.

        Args:
            estimate: Of door, hinge and wind.
        """
        hinge = estimate.hinge
        if not self._pushes:
            unsure = min(hinge.spare_deviation, _UNSURE)
            return self.in_swing >= _LEAST_RESISTANCE and hinge.spare + unsure > 0.0
        wind = float(np.hypot(estimate.wind[0], estimate.wind[1])) * 0.5 * self._door.width
        return hinge.spare - max(_GUSTINESS * wind, hinge.closing_wind) > 0.0

    def _nudge(self, off: float, rate: float, time_step: float) -> None:
        """Tell plans of more and more friction while the door sticks beside the goal: they push, or pull, harder."""
        nudge, forgotten = (_PUSHED_NUDGE, _PUSHED_FORGOTTEN) if self._pushes else (_NUDGE, _FORGOTTEN)
        stays = self._rest is not None and self._progress.passes > 1
        if self._observed and not stays and abs(rate) < _STICKS and abs(off) > self._tolerance:
            stiction = self._stiction + math.copysign(nudge * min(abs(off) / NEARLY, 1.0) * time_step, off)
            self._stiction = min(max(stiction, -_MOST_STICTION), _MOST_STICTION)
        else:
            self._stiction *= math.exp(-time_step / forgotten)

    def _pushed(self, estimate: Estimate) -> float:
        """Torque of a pushed hinge: a door that stands resists by no more than it is pushed, but could."""
        if abs(estimate.door_rate) > _STICKS:
            self._counted_on = estimate.door_disturbance
        else:
            self._counted_on = min(self._counted_on, estimate.door_disturbance)
        return self._counted_on

    def _gripped(self, off: float, estimate: Estimate) -> float:
        """Torque of a gripped hinge, without its friction where the door should come to rest: it is what holds the door there.

        Else the push that overcomes the friction of a slow door carries it beyond the goal, by degrees. One without friction
        follows whatever it is pushed with: what is estimated brings it to the goal, and a torque of the moment away from it.
        """
        torque, rate = estimate.door_disturbance, self._progress.rate
        if abs(off) > self._progress.at_goal or estimate.hinge.friction < _NO_FRICTION:
            self._rest = None
        elif self._progress.passes > 1 and abs(rate) < SLOW:
            self._rest = torque if self._rest is None else self._rest
        elif not self._rested and abs(off) < _ARRIVED and abs(rate) < _ARRIVING:
            self._rested = True  # once: a door that does not stay so is held against its friction
            friction = _LEFT_TO_FRICTION * max(0.0, estimate.hinge.friction)
            if rate < 0.0:
                self._rest = min(torque + friction, max(torque, 0.0))
            else:
                self._rest = max(torque - friction, min(torque, 0.0))
        return torque if self._rest is None else self._rest
