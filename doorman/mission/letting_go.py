"""How the tip leaves the leaf: a gripper rests on it before it opens, a push fades into backing off, a slam is given way to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from doorman.control.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.at_the_leaf import AtTheLeaf
from doorman.mission.motion import in_the_doorway
from doorman.model import Model

LOST_PAST = math.radians(2.5)
"""A leaf that was lost is not looked for so far beyond the goal [rad]."""
_BACKING_OFF = 0.4
"""Force away from the leaf while a tip that pushes lets go [N]."""
_DRAWING_BACK = 1.0
"""The same for one that grips: what it held against would else push it back onto a leaf that nothing holds [N]."""
_DRAWN_BACK = 0.15
"""It goes back no faster by itself: it would be a jamb that it comes nearer to [m/s]."""
_BRAKING, _MOST_BRAKING = 12.0, 4.0
"""Of a vehicle whose leaf still swings when it lets go [N s/m], [N]."""
_LETTING_GO = 0.5
"""For which the tip backs off, or the gripper draws back [s]."""
_UNLOADING, _UNLOADED = 0.7, 1.5
"""Time in which a load fades, and the load with which a gripper opens before that has passed, where nobody minds whether the door
stays [s], [N]: a vehicle that lets go of a load is flung away from it until its tilt has followed;"""
_COMES_ALIVE = 0.1
"""at once where the leaf moves faster, which is then not let back but thrown [rad/s]."""
_GIVING_WAY = 2.5
"""A vehicle that has not left the doorway by then [s] is held there, or is as slow as it may be."""
_EASING = 1.5
"""Time in which the push on an opened door fades [s]."""
_WATCHING = 3.0
"""For which the tip only rests on it then, or the gripper holds it without a load [s]."""
_RESTING = 0.15
"""Push of a tip that rests on the leaf [N]."""
_COMES_BACK = math.radians(0.35)
"""A door that has moved back by more meanwhile would not stay, nor does one in a gripper that has moved either way [rad]."""


class Then(Enum):
    """What follows."""

    MORE = "it goes on"
    OUT = "the tip is free"
    HELD = "the door must be held"
    GONE = "there is no door where it was held"


@dataclass(frozen=True)
class Parting:
    """What to do now, and what follows."""

    setpoint: Setpoint
    then: Then = Then.MORE
    push: float = 0.0
    """F_n that is left, if the door must be held [N]."""


class LettingGo:
    """Lets go of the leaf once.

    Args:
        model: Model of the scenario.
        leaf: Motion at the leaf, begun where the tip is.
        push: F_n that a tip presses with; None with a gripper [N].
        estimate: Where it begins.
        closed: Whether a gripper is closed: the load is taken off it first.
    """

    def __init__(self, model: Model, leaf: AtTheLeaf, push: float | None, estimate: Estimate, closed: bool) -> None:
        self._model, self._leaf, self._push = model, leaf, push
        self._goal = float(model.goal_state[3])
        self._angle, self._began = estimate.door_angle, estimate.time
        self._load = estimate.normal_force
        self._since = None if closed else estimate.time
        self.gives_way = False
        """Whether it gives way to a slammed door."""

    @property
    def unloads(self) -> bool:
        """Whether a gripper is about to open, and the load is taken off it."""
        return self._since is None

    def give_way(self, estimate: Estimate) -> None:
        """Let go at once, and go out before a leaf that is slammed."""
        self.gives_way, self._since = True, estimate.time

    def step(self, estimate: Estimate, failed: bool) -> Parting:
        """Let go on: the gripper opens, the push fades into backing off. Once per tick.

        Args:
            estimate: What is known now.
            failed: Whether the mission was given up: nobody minds then whether the door stays.
        """
        if self._since is None and not failed:
            return self._rest_in_gripper(estimate)
        if self._since is None:
            loaded = abs(estimate.normal_force) > _UNLOADED and abs(estimate.door_rate) < _COMES_ALIVE
            if loaded and estimate.time - self._began < _UNLOADING:
                return Parting(self._leaf.push(estimate, 0.0))
            self._since = estimate.time
        spent = estimate.time - self._since
        if self.gives_way:
            outside = not in_the_doorway(self._model, estimate.position)
            return _parting(self._leaf.give_way(estimate), spent >= (_LETTING_GO if outside else _GIVING_WAY))
        if self._push is None:
            gently = _DRAWING_BACK * min(max(1.0 + estimate.tip_speed / _DRAWN_BACK, 0.0), 1.0)
            force = max(gently, min(_BRAKING * estimate.tip_speed, _MOST_BRAKING))
            return _parting(self._leaf.draw_back(estimate, force), spent >= _LETTING_GO)
        pressed = self._push
        if not failed:
            if spent < _EASING + _WATCHING:
                return self._ease(estimate, pressed, min(spent / _EASING, 1.0))
            spent, pressed = spent - _EASING - _WATCHING, _RESTING
        share = min(spent / _LETTING_GO, 1.0)
        setpoint = self._leaf.push(estimate, (1.0 - share) * pressed - share * _BACKING_OFF)
        return _parting(setpoint, spent >= _LETTING_GO)

    def _rest_in_gripper(self, estimate: Estimate) -> Parting:
        """Take the load off a closed gripper, and watch whether the door stays: it opens after that."""
        spent = estimate.time - self._began
        left = max(1.0 - spent / _UNLOADING, 0.0) * self._load
        setpoint = self._leaf.push(estimate, left)
        moved = abs(estimate.door_angle - self._angle) > _COMES_BACK
        if moved and abs(estimate.door_rate) < _COMES_ALIVE:  # faster, somebody has it
            return Parting(setpoint, Then.HELD, left)
        if spent >= _UNLOADING + _WATCHING:
            self._since = estimate.time
        return Parting(setpoint)

    def _ease(self, estimate: Estimate, pressed: float, eased: float) -> Parting:
        """Let the push fade, and watch whether the door stays: one that comes back is to be held instead."""
        left = (1.0 - eased) * pressed + eased * _RESTING
        setpoint = self._leaf.rest(estimate, left)
        if estimate.door_angle > self._angle + _COMES_BACK:
            return Parting(setpoint, Then.HELD, left)
        if not (estimate.near or estimate.touching):  # the tip has left the leaf, and the door stands without it
            return Parting(setpoint, Then.OUT)
        return Parting(setpoint, Then.GONE if estimate.tip_angle < self._goal - LOST_PAST else Then.MORE)


def _parting(setpoint: Setpoint, over: bool) -> Parting:
    return Parting(setpoint, Then.OUT if over else Then.MORE)
