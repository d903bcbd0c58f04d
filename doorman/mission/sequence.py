"""The mission as a state machine: hover (→ touch of the frame → hover) → approach → touch → open → release → retreat → hover.

Every phase is an object of `doorman.mission.phases`; docs/mission.md draws them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.control.position_controller import Setpoint
from doorman.control.state_converter import StateConverter
from doorman.control.way_out import in_the_doorway
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.done import Done
from doorman.mission.phases.free_flight.approach import Approach
from doorman.mission.phases.free_flight.hover import Hover
from doorman.mission.phases.free_flight.retreat import Retreat
from doorman.mission.phases.free_flight.through import Through
from doorman.mission.phases.free_flight.touch_frame import TouchFrame
from doorman.mission.phases.guard import Guard
from doorman.mission.phases.hold import Hold
from doorman.mission.phases.open import Open
from doorman.mission.phases.phase import GiveUp, MissionPhase, Phase, Then
from doorman.mission.phases.recover import Recover
from doorman.mission.phases.release import Release
from doorman.mission.phases.take_back import TakeBack
from doorman.mission.phases.touch import Touch
from doorman.mission.schedule import PlanSchedule
from doorman.mission.since import since
from doorman.model import Model
from doorman.planning.pace import OPEN

_KINDS: tuple[type[MissionPhase], ...] = (
    Hover, TouchFrame, Approach, Touch, Open, Hold, Recover, TakeBack, Release, Retreat, Through, Done,
)  # fmt: skip
_PHASES: dict[Phase, type[MissionPhase]] = {kind.phase: kind for kind in _KINDS}


class Sequence:
    """Phases of one mission.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        schedule: Plans.
        estimator: Takes what the phases know of the contact.
        on_change: Called with the name of every new phase and the reason for it.
        holds: Whether the gripper holds the handle already, and is known to.
        more: Phases of the user's own.
    """

    def __init__(
        self,
        model: Model,
        converter: StateConverter,
        schedule: PlanSchedule,
        estimator: Estimator,
        on_change: Callable[[float, str, str], None],
        holds: bool = False,
        more: Iterable[type[MissionPhase]] = (),
    ) -> None:
        self.attempt = Attempt(model, converter, schedule, estimator)
        """What the phases share, and what came of it."""
        on_the_leaf = Phase.OPEN if holds else Phase.TOUCH  # which tries a gripper
        self._first = Phase.HOVER if model.scenario.mission.start == "hover" else on_the_leaf
        self._now: MissionPhase | None = None
        self._on_change = on_change
        self._guard = Guard(self.attempt)
        self._loose_since: float | None = None
        self._more = {kind.before: kind for kind in more}

    @property
    def phase(self) -> Phase:
        """Where the mission is."""
        return self._first if self._now is None else self._now.phase

    @property
    def tie(self) -> Tie:
        """What is known of tip and leaf in this phase."""
        if self._now is not None:
            return self._now.tie
        return Tie.FREE if self._first is Phase.HOVER else Tie.PUSHING

    @property
    def closes_gripper(self) -> bool:
        """Whether a gripper is to be closed in this phase."""
        return self._now is not None and self._now.tied

    def abort(self, estimate: Estimate, reason: str) -> None:
        """Give up for good: let go of the door gently, retreat and hover."""
        self._follow(GiveUp(reason, takes_back=False), estimate)

    def enter(self, phase: Phase, estimate: Estimate, reason: str = "") -> None:
        """Begin a phase."""
        kind = self._more.get(phase, _PHASES[phase])
        if isinstance(self._now, kind):  # it goes on with what it was flown before
            kind = _PHASES[phase]
        self._now = kind(self.attempt, estimate, self._now)
        if kind.phase in (Phase.TOUCH, Phase.OPEN, Phase.HOLD):
            self._guard.begin(estimate.time)
        self._on_change(estimate.time, kind.name or kind.phase.value, reason)

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, MissionPhase]:
        """What to do now, and the phase that follows plans and closes the gripper until the next tick."""
        now = self._current(estimate)
        if now.expired(estimate.time):
            now = self._follow(now.time_out(estimate), estimate)
        now = self._yield_to_slam(now, estimate)
        if now.guarded:
            now = self._follow(self._guard.judge(now, estimate), estimate)
        if self._is_loose(now, estimate):
            now = self._follow(now.without_hold(estimate), estimate)
        setpoint, then = now.step(estimate, body_rates, time_step)
        return setpoint, self._follow(then, estimate)

    def _is_loose(self, now: MissionPhase, estimate: Estimate) -> bool:
        """Whether a closed gripper has seemed to hold nothing for a while."""
        holds = now.tied and now.holds(estimate.time)
        self._loose_since = since(self._loose_since, holds and not estimate.touching, estimate.time)
        lasts = self.attempt.model.scenario.estimation.loose_time
        return self._loose_since is not None and estimate.time - self._loose_since > lasts

    def _current(self, estimate: Estimate) -> MissionPhase:
        if self._now is None:
            self.enter(self._first, estimate)
        assert self._now is not None
        return self._now

    def _follow(self, then: Then, estimate: Estimate) -> MissionPhase:
        """Begin what follows, if anything does."""
        if isinstance(then, GiveUp):
            self._give_up(then, estimate)
        elif then is not None:
            self.enter(then.phase, estimate, then.reason)
        return self._current(estimate)

    def _give_up(self, what: GiveUp, estimate: Estimate) -> None:
        """Let go of the door, retreat and hover; another attempt may follow unless it is for good."""
        attempt, now = self.attempt, self._current(estimate)
        if not what.for_good:
            attempt.allow_another()
        else:
            attempt.aborted = True
            if attempt.again:
                attempt.again, attempt.failure = False, what.reason
        if now.leaves or now.phase is Phase.DONE:
            return
        attempt.failure = attempt.failure or what.reason
        attempt.opened = attempt.opened and now.phase is not Phase.HOLD  # it would not stay by itself
        touching = now.at_the_leaf and not what.at_once and (now.tied or estimate.touching)
        if touching and what.takes_back and self._is_to_go_back(now, estimate):
            self.enter(Phase.TAKE_BACK, estimate, what.reason)
        else:
            self.enter(Phase.RELEASE if touching else Phase.RETREAT, estimate, what.reason)

    def _is_to_go_back(self, now: MissionPhase, estimate: Estimate) -> bool:
        """Whether a gripper holds a door that it has opened, and does not take it back already."""
        model = self.attempt.model
        opens = model.door.opening_of(model.goal_angle) > model.door.opening_of(model.start_angle)
        has_moved = opens and model.travel.done(estimate.door_angle) > OPEN
        return has_moved and now.tied and now.phase is not Phase.TAKE_BACK

    def _yield_to_slam(self, now: MissionPhase, estimate: Estimate) -> MissionPhase:
        """Let go of a door that is slammed, if need be, and go out before the leaf."""
        if not self._is_slammed(now, estimate):
            return now
        reason = f"the door is slammed at {self.attempt.model.door.in_words(estimate.door_angle, 0)}"
        self.attempt.allow_another()
        self.attempt.failure, self.attempt.opened = self.attempt.failure or reason, False
        self.enter(Phase.RELEASE, estimate, reason)
        assert isinstance(self._now, Release)
        self._now.give_way(estimate)
        return self._now

    def _is_slammed(self, now: MissionPhase, estimate: Estimate) -> bool:
        """Whether the leaf throws the tip back, and that is not given way to yet."""
        slammed = self.attempt.model.scenario.estimation.slam_speed
        if not estimate.touching or estimate.tip_speed >= -slammed or now.gives_way or now.phase is Phase.DONE:
            return False
        if now.phase is Phase.RETREAT and not in_the_doorway(self.attempt.model, estimate.position):
            return False
        return estimate.tip_speed < -(slammed + now.speed_back(estimate))
