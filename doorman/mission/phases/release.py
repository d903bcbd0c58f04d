"""How the tip leaves the leaf: a gripper rests on it before it opens, a push fades into backing off, a slam is given way to."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate, Tie
from doorman.control.position_controller import Setpoint
from doorman.control.way_out import in_the_doorway
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then

Array = NDArray[np.float64]

LOST_PAST = math.radians(2.5)
"""A leaf that was lost is not looked for so far beyond the goal [rad]."""
_BACKING_OFF = 0.4
"""Force away from the leaf while a tip that pushes lets go, of the shipped vehicle as all forces here [N]."""
_DRAWING_BACK = 1.0
"""Force away from the leaf while a gripper lets go: what it held against would push it back onto a free leaf [N]."""
_DRAWN_BACK = 0.15
"""It goes back no faster by itself: it would be a jamb that it comes nearer to [m/s]."""
_BRAKING, _MOST_BRAKING = 12.0, 4.0
"""Of a vehicle whose leaf still swings when it lets go [N s/m], [N]."""
_LETTING_GO, _FADES = 0.5, 8.0
"""For which the tip backs off, or the gripper draws back [s]; a hard push takes longer to fade [N/s]."""
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


class Release(MissionPhase):
    """Lets go of the leaf; a door that comes back meanwhile is held instead."""

    phase, leaves = Phase.RELEASE, True

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        closed = before is not None and before.closes_gripper
        self._goal = attempt.model.goal_angle
        self._angle, self._load, self._push = estimate.door_angle, estimate.normal_force, estimate.normal_force
        self._let_go_at = None if closed else self.entered
        self._gives_way = False
        attempt.leaf.begin(estimate.yaw, estimate, 0.0 if attempt.grips else max(self._push, 0.0))

    @property
    def tie(self) -> Tie:
        """A closed gripper still holds."""
        if self.closes_gripper:
            return Tie.GRIPPED
        return Tie.LEAVING if self.attempt.failure or self.attempt.grips else Tie.PUSHING

    @property
    def closes_gripper(self) -> bool:
        """Whether the load has not been taken off the gripper yet."""
        return self._let_go_at is None

    @property
    def gives_way(self) -> bool:
        """Whether a slam has been felt."""
        return self._gives_way

    def give_way(self, estimate: Estimate) -> None:
        """Let go at once, and go out before a leaf that slams."""
        self._gives_way, self._let_go_at = True, estimate.time

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Go on letting go: the gripper opens, the push fades into backing off."""
        attempt, leaf = self.attempt, self.attempt.leaf
        failed, scale = bool(attempt.failure), attempt.model.scale
        if self._let_go_at is None:
            if not failed:
                return self._rest_in_gripper(estimate)
            loaded = abs(estimate.normal_force) > _UNLOADED * scale.force and abs(estimate.door_rate) < _COMES_ALIVE
            if loaded and estimate.time - self.entered < _UNLOADING:
                return leaf.push(estimate, self._load_left(estimate)), None
            self._let_go_at = estimate.time
        spent = estimate.time - self._let_go_at
        if self._gives_way:
            outside = not in_the_doorway(attempt.model, estimate.position)
            return leaf.give_way(estimate), self._out(spent >= (_LETTING_GO if outside else _GIVING_WAY))
        if attempt.grips:
            gently = _DRAWING_BACK * scale.force * min(max(1.0 + estimate.tip_speed / _DRAWN_BACK, 0.0), 1.0)
            force = max(gently, min(_BRAKING * scale.damping * estimate.tip_speed, _MOST_BRAKING * scale.force))
            return leaf.draw_back(estimate, force), self._out(spent >= _LETTING_GO)
        pressed = self._push
        if not failed:
            if spent < _EASING + _WATCHING:
                return self._ease(estimate, min(spent / _EASING, 1.0))
            spent, pressed = spent - _EASING - _WATCHING, _RESTING * scale.force
        lasts = max(_LETTING_GO, pressed / (_FADES * scale.force))
        share = min(spent / lasts, 1.0)
        setpoint = leaf.push(estimate, (1.0 - share) * pressed - share * _BACKING_OFF * scale.force)
        return setpoint, self._out(spent >= lasts)

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The retreat: the vehicle leaves."""
        return Next(Phase.RETREAT, f"the phase release took longer than {self.longest:g} s")

    def _load_left(self, estimate: Estimate) -> float:
        """Of what the gripper held as this began [N]."""
        return max(1.0 - (estimate.time - self.entered) / _UNLOADING, 0.0) * self._load

    def _rest_in_gripper(self, estimate: Estimate) -> tuple[Setpoint, Then]:
        """Take the load off a closed gripper, and watch whether the door stays: it opens after that."""
        spent, left = estimate.time - self.entered, self._load_left(estimate)
        setpoint = self.attempt.leaf.push(estimate, left)
        moved = abs(estimate.door_angle - self._angle) > _COMES_BACK
        if moved and abs(estimate.door_rate) < _COMES_ALIVE:  # faster, somebody has it
            return setpoint, self._hold(estimate, left, "moved as the load was taken off it")
        if spent >= _UNLOADING + _WATCHING:
            self._let_go_at = estimate.time
            self.attempt.estimator.leaf_stays(estimate.door_angle)
        return setpoint, None

    def _ease(self, estimate: Estimate, eased: float) -> tuple[Setpoint, Then]:
        """Let the push fade, and watch whether the door stays: one that comes back is to be held instead."""
        left = (1.0 - eased) * self._push + eased * _RESTING * self.attempt.model.scale.force
        setpoint = self.attempt.leaf.rest(estimate, left)
        if estimate.door_angle > self._angle + _COMES_BACK:
            return setpoint, self._hold(estimate, left, "came back as the push faded")
        if not (estimate.near or estimate.touching):  # the tip has left the leaf, and the door stands without it
            return setpoint, self._out(True)
        if estimate.tip_angle < self._goal - LOST_PAST:
            stands = self.attempt.model.door.in_words(estimate.tip_angle, 0)
            self.attempt.failure = f"the leaf has gone past the goal, to {stands} or farther"
            return setpoint, self._out(True)
        return setpoint, None

    def _hold(self, estimate: Estimate, push: float, moved: str) -> Next:
        self.attempt.opening.hold_again(estimate, push)
        return Next(Phase.HOLD, f"the door {moved}")

    def _out(self, over: bool) -> Next | None:
        return Next(Phase.RETREAT, self.attempt.failure) if over else None
