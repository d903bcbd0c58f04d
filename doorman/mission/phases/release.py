"""How the tip leaves the leaf: the load on it fades, it is watched whether the leaf stays, then the tip goes back."""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate, Tie
from doorman.control.position_controller import Setpoint
from doorman.control.way_out import in_the_doorway
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Next, Phase, Then
from doorman.planning.pace import OPEN

_LETTING_GO = 0.5
"""For which the tip draws back [s]."""
_EASING = 0.7
"""Time in which the load on a door fades [s]: a vehicle that drops a load is flung away from it until its tilt has followed."""
_LOADED, _COMES_ALIVE = 3, 0.1
"""A given-up leaf is let go before that with a load of no more than so many pushes of a touch, or where it moves faster: it is
thrown then [rad/s]. A lever turns as many times faster by the same way of the tip as it is shorter than a leaf."""
_GIVING_WAY = 2.5
"""A vehicle that has not left the doorway by then [s] is held there, or is as slow as it may be."""
_WATCHING = 3.0
"""For which the tip then only rests on an opened leaf, or the gripper holds it without a load [s]."""
_RESTING = 0.15
"""Push of a tip that rests on the leaf [N]."""
_COMES_BACK = math.radians(0.35)
"""A door that has moved back by more meanwhile would not stay, nor does one in a gripper that has moved either way [rad]."""


class Release(MissionPhase):
    """Lets go of the leaf; a door that does not stay meanwhile is held instead."""

    phase, leaves, follows = Phase.RELEASE, True, False  # the load fades by itself

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        self._angle, self._load = estimate.door_angle, estimate.normal_force
        self._holds = before is not None and before.tied
        self._let_go_at: float | None = None
        self._comes_alive = attempt.model.turn_scale * _COMES_ALIVE
        self._gives_way = False
        attempt.leaf.begin(estimate.yaw, estimate, 0.0 if self._holds else max(self._load, 0.0))

    @property
    def tie(self) -> Tie:
        """A closed gripper still holds, another tip rests until it goes back."""
        if self.tied:
            return Tie.GRIPPED
        return Tie.PUSHING if self._let_go_at is None and not self.attempt.failure else Tie.LEAVING

    @property
    def closes_gripper(self) -> bool:
        """Whether the load has not been taken off the gripper yet."""
        return self._holds and self._let_go_at is None

    @property
    def gives_way(self) -> bool:
        """Whether a slam has been felt."""
        return self._gives_way

    def give_way(self, estimate: Estimate) -> None:
        """Let go at once, and go out before a leaf that slams."""
        self._gives_way, self._let_go_at = True, estimate.time

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Go on letting go."""
        leaf = self.attempt.leaf
        if self._let_go_at is None:
            setpoint, then, over = self._unload(estimate)
            if then is not None or not over:
                return setpoint, then
            self._let_go_at = estimate.time
        spent = estimate.time - self._let_go_at
        if self._gives_way:
            outside = not in_the_doorway(self.attempt.model, estimate.position)
            return leaf.give_way(estimate), self._out(spent >= (_LETTING_GO if outside else _GIVING_WAY))
        return leaf.draw_back(estimate), self._out(spent >= _LETTING_GO)

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The retreat: the vehicle leaves."""
        return Next(Phase.RETREAT, f"the phase release took longer than {self.longest:g} s")

    def _unload(self, estimate: Estimate) -> tuple[Setpoint, Then, bool]:
        """Let the load fade; what follows, and whether that is over. An opened door is watched for a while."""
        attempt, spent, failed = self.attempt, estimate.time - self.entered, bool(self.attempt.failure)
        left = max(1.0 - spent / _EASING, 0.0)
        if failed:
            loaded = abs(estimate.normal_force) > _LOADED * attempt.touch_force
            over = left == 0.0 or not loaded or abs(estimate.door_rate) >= self._comes_alive
            return attempt.leaf.push(estimate, left * self._load), None, over
        rests = 0.0 if self._holds else _RESTING * attempt.model.scale.force
        push = left * self._load + (1.0 - left) * rests
        setpoint = attempt.leaf.push(estimate, push) if self._holds else attempt.leaf.rest(estimate, push)
        back = attempt.model.travel.left(estimate.door_angle) - attempt.model.travel.left(self._angle)
        moved = abs(back) if self._holds else back
        if moved > _COMES_BACK and abs(estimate.door_rate) < self._comes_alive:  # faster, somebody has it
            return setpoint, Next(Phase.HOLD, "the door moved as the load was taken off it"), False
        if not (self._holds or estimate.near or estimate.touching):  # it stands without the tip
            return setpoint, None, True
        if not self._holds and attempt.model.travel.left(estimate.tip_angle) < -attempt.model.turn_scale * OPEN:
            stands = attempt.model.door.in_words(estimate.tip_angle, 0)
            attempt.failure = f"the leaf has gone past the goal, to {stands} or farther"
            return setpoint, None, True
        over = spent >= _EASING + _WATCHING
        if over:
            attempt.estimator.leaf_stays(estimate.door_angle)
        return setpoint, None, over

    def _out(self, over: bool) -> Next | None:
        return Next(Phase.RETREAT, self.attempt.failure) if over else None
