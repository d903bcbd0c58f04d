"""The mission as a state machine: hover → approach → touch → open → release → retreat → hover.

Every phase has an entry condition, a time-out and an action where it fails; docs/mission.md draws them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimator import Estimate, Estimator, Tie
from doorman.control.position_controller import Setpoint
from doorman.control.state_converter import StateConverter
from doorman.mission.approach import Approach
from doorman.mission.at_the_leaf import AtTheLeaf
from doorman.mission.grip_watch import TUG, GripWatch
from doorman.mission.held_door import MOVING, OPEN_ENOUGH, After, HeldDoor
from doorman.mission.letting_go import LOST_PAST, LettingGo, Then
from doorman.mission.motion import in_the_doorway, planned_speed_back
from doorman.mission.opening import SILENT, Opening
from doorman.mission.retreat import Retreat
from doorman.mission.schedule import PlanSchedule
from doorman.mission.slam import SlamDetector
from doorman.mission.swing import Swing
from doorman.model import GRAVITY, Model

Array = NDArray[np.float64]

_PRESSING = 0.5
"""From the touch to the opening, or to the tug by which a gripper is tried [s],"""
_TUGGING, _TURNING_ROUND = 0.9, 0.3
"""which takes so long, of which the estimated force takes a part to follow from push to pull [s]."""
_MISSING = math.radians(5.0)
"""A tip that gets so far beyond the leaf's place before it touches anything looks for it along its swing [rad],"""
_SEARCH_SPEED = 0.08
"""at this speed [m/s]."""
_DOUBT = 0.1
"""For which rotors must seem to meet something [s], but a leaf that is looked for: a gap in the poses moves it by centimetres."""
_PAST = math.radians(10.0)
"""A leaf that is so far beyond the goal cannot be brought back by a push [rad]."""
_OPENED_ALREADY = math.radians(1.5)
"""A leaf that is looked for before the first touch may be so far beyond the goal: it is open [rad]."""
_SURE = 2.0
"""Contact with a leaf that had to be looked for, lost again within this time, may have been none [s]."""
_PROGRESS = math.radians(1.0)
_WHOLE_SEARCH = 3.0
"""A tip that follows a leaf which moves on by itself, or looks for it along its swing, may go on as long as it comes nearer to
the goal by that [rad], but for no more than so many time-outs."""
_FAR = 1.0
"""A tip that has looked for the leaf for longer is far from where it lost it [s]."""


class Phase(Enum):
    """Where a mission is."""

    HOVER = "hover"
    APPROACH = "approach"
    TOUCH = "touch"
    OPEN = "open"
    HOLD = "hold"
    RECOVER = "recover"
    RELEASE = "release"
    RETREAT = "retreat"
    DONE = "done"


@dataclass(frozen=True)
class Action:
    """What a phase asks for."""

    setpoint: Setpoint
    grip: bool


class Sequence:
    """Phases of one mission.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        schedule: Plans.
        estimator: What the contact state is told.
        on_change: Called with every new phase and the reason for it.
    """

    def __init__(
        self,
        model: Model,
        converter: StateConverter,
        schedule: PlanSchedule,
        estimator: Estimator,
        on_change: Callable[[float, Phase, str], None],
    ) -> None:
        self.phase = Phase.HOVER if model.scenario.mission.start == "hover" else Phase.OPEN
        self.opened = False
        """Whether the door has been brought to the goal."""
        self.failure = ""
        """Why the mission was given up; empty if it was not."""
        self.seen = ""
        """What it has seen of a door that it went all its way for and that is not where it should be by its own estimate."""
        self.comes_back = False
        """Whether the vehicle leaves in the end even a door that would not stay: one that has to land must."""
        self._model, self._converter, self._estimator = model, converter, estimator
        self._settings = model.scenario.mission
        self._grips = model.scenario.contact.kind == "grip"
        self._schedule = schedule
        self._leaf = AtTheLeaf(model, converter)
        self._opening = self._make_opening()
        self._on_change = on_change
        self._slam = SlamDetector(model.vehicle.mass)
        self._grip_watch = GripWatch(model)
        self._tug = TUG * model.vehicle.mass * GRAVITY
        self._keeps_hold = False
        self._approaching = Approach(model, self._leaf)
        self._held_door: HeldDoor | None = None
        self._letting_go: LettingGo | None = None
        self._way_out: Retreat | None = None
        self._since: float | None = None
        self._entered: float | None = None
        self._attempt = 1
        self._again = self._aborted = False
        self._recoveries = 0
        self._unsure = False
        self._nearest = self._progress_at = 0.0
        self._clear_at = 0.0
        self._steps = {
            Phase.HOVER: self._hover, Phase.APPROACH: self._approach, Phase.TOUCH: self._touch, Phase.OPEN: self._open,
            Phase.HOLD: self._hold, Phase.RECOVER: self._recover, Phase.RELEASE: self._release,
            Phase.RETREAT: self._retreat, Phase.DONE: self._retreat,
        }  # fmt: skip

    def _make_opening(self) -> Opening | Swing:
        if self._grips:
            return Opening(self._model, self._converter, self._schedule)
        return Swing(self._model, self._leaf, self._schedule)

    @property
    def at_the_leaf(self) -> bool:
        """Whether the tip is to touch the leaf."""
        return self.phase in (Phase.TOUCH, Phase.OPEN, Phase.HOLD, Phase.RECOVER)

    @property
    def tie(self) -> Tie:
        """What is known of tip and leaf in this phase."""
        if self._unloads or self.phase in (Phase.OPEN, Phase.HOLD, Phase.RECOVER):
            return Tie.GRIPPED if self._grips else Tie.PUSHING
        if self.phase in (Phase.RELEASE, Phase.RETREAT):
            return Tie.LEAVING if self.failure else Tie.PUSHING
        return Tie.PUSHING if self.phase is Phase.TOUCH else Tie.FREE

    def abort(self, estimate: Estimate, reason: str, at_once: bool = False) -> None:
        """Give up: let go of the door, gently unless `at_once`, retreat and hover; for good."""
        self._aborted = True
        if self._again:
            self._again, self.failure = False, reason
        self._back_out(estimate, reason, at_once)

    def _give_up(self, estimate: Estimate, reason: str, at_once: bool = False) -> None:
        """The same for this attempt; another one may follow from the hover."""
        self._allow_another()
        self._back_out(estimate, reason, at_once)

    def _allow_another(self) -> None:
        """Let another attempt follow, unless this one has failed already, or the mission was aborted."""
        if not self.failure and not self._aborted:
            knows_the_leaf = (
                self._model.door.side == "push"
            )  # else it may stand open, where the vehicle would come back
            self._again = knows_the_leaf and self._attempt < self._settings.attempts

    def _back_out(self, estimate: Estimate, reason: str, at_once: bool) -> None:
        if self.phase not in (Phase.RELEASE, Phase.RETREAT, Phase.DONE):
            self.failure = self.failure or reason
            self.opened = self.opened and self.phase is not Phase.HOLD  # it would not stay by itself
            touching = self.at_the_leaf and not at_once and (self._grips or estimate.touching)
            self._enter(Phase.RELEASE if touching else Phase.RETREAT, estimate, reason)

    def _give_way(self, estimate: Estimate) -> None:
        """Let go of a door that is slammed, if need be, and go out before the leaf."""
        reason = f"the door is slammed at {np.degrees(estimate.door_angle):.0f}°"
        self._allow_another()
        self.failure, self.opened = self.failure or reason, False
        self._enter(Phase.RELEASE, estimate, reason)
        assert self._letting_go is not None
        self._letting_go.give_way(estimate)

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> Action:
        """What to do now.

        Args:
            estimate: What is known now.
            body_rates: Ω, shape (3,) [rad/s].
            time_step: Since the last call [s].
        """
        if self._entered is None:
            self._enter(self.phase, estimate, "")
        assert self._entered is not None
        if self.phase is not Phase.HOLD:
            limit = float(getattr(self._settings.time_out, self.phase.value))
            # a search that gets on has longer
            begun = min(self._progress_at, self._entered + (_WHOLE_SEARCH - 1.0) * limit)
            if estimate.time - begun > limit:
                self._time_out(estimate, limit)
        if self._is_slammed(estimate, time_step):
            self._give_way(estimate)
        if self.phase in (Phase.OPEN, Phase.HOLD) or (not self._grips and self.phase in (Phase.TOUCH, Phase.RECOVER)):
            self._guard(estimate)
        if self._grips and self._grip_watch.is_loose(estimate, self._holds(estimate.time), time_step):
            self.abort(estimate, "the gripper does not hold the leaf", at_once=True)
        setpoint = self._steps[self.phase](estimate, body_rates, time_step)
        return Action(setpoint, self._closed)

    def _holds(self, now: float) -> bool:
        """Whether a gripper should hold the leaf by now, and is no longer pressed onto it."""
        if self.phase is Phase.TOUCH:
            return self._since is not None and now - self._since >= _PRESSING + _TURNING_ROUND
        return self._closed

    @property
    def _closed(self) -> bool:
        """Whether a gripper is to be closed."""
        pressing = self.phase is Phase.TOUCH and self._since is not None
        holding = self._unloads or self._keeps_hold or self.phase in (Phase.OPEN, Phase.HOLD)
        return self._grips and (pressing or holding)

    @property
    def _unloads(self) -> bool:
        """Whether a gripper is about to open, and the load is taken off it."""
        return self._letting_go is not None and self._letting_go.unloads

    def _guard(self, estimate: Estimate) -> None:
        """Give up where a push would do harm or no good."""
        angle = float(np.degrees(estimate.door_angle))
        searching = self._searching(estimate.time)
        near = self._leaf.hits_the_rotors(estimate, searching)
        if not self._grips:
            beside = self._leaf.meets_a_jamb(estimate)
        elif abs(estimate.door_rate) < MOVING:
            beside = self._leaf.levels_into_a_jamb(estimate)
        else:  # a leaf that swings meets a vehicle that lets go
            near = beside = False
        self._clear_at = self._clear_at if near or beside else estimate.time
        if (near and searching) or estimate.time - self._clear_at > _DOUBT:
            what = "the leaf" if near else "a jamb"
            self._give_up(estimate, f"the rotors come too near to {what} at {angle:.0f}°", at_once=not self._grips)
            return
        if self._grips:
            return
        if (late := self._schedule.overdue(estimate.time)) > SILENT:
            self.abort(estimate, f"the planner is silent for {late:.1f} s")
            return
        past = LOST_PAST if self.phase is Phase.RECOVER else _PAST
        if estimate.door_angle < float(self._model.goal_state[3]) - past:
            self.abort(estimate, f"the leaf has gone past the goal, to {angle:.0f}°")

    def _is_slammed(self, estimate: Estimate, time_step: float) -> bool:
        """Whether the leaf throws the tip back, and that is not given way to yet; once per tick."""
        retreats, lets_go = self.phase is Phase.RETREAT, self.phase is Phase.RELEASE
        gives_way = self._letting_go is not None and self._letting_go.gives_way
        outside = retreats and not in_the_doorway(self._model, estimate.position)
        if gives_way or outside or self.phase is Phase.DONE:
            self._slam.reset()
            return False
        back = self._way_out.speed_from_leaf(estimate) if retreats and self._way_out is not None else 0.0
        if self.phase is Phase.OPEN and self._grips:
            back = planned_speed_back(self._converter, self._schedule.current, estimate.time)
        return self._slam.update(estimate, self._closed, lets_go or retreats, back, time_step)

    def _searching(self, now: float) -> bool:
        """Whether the tip looks for the leaf away from where it last was."""
        if self.phase is Phase.TOUCH:
            return self._since is None
        return (
            self.phase is Phase.RECOVER and self._entered is not None and (now - self._entered > _FAR or self._unsure)
        )

    def _time_out(self, estimate: Estimate, limit: float) -> None:
        reason = f"{self.phase.value} took longer than {limit:g} s"
        if self.phase is Phase.OPEN:
            reason += f", the door stands at {np.degrees(estimate.door_angle):.1f}°"
        if self.phase is Phase.RECOVER and estimate.door_angle < float(self._model.goal_state[3]):
            reason = f"the leaf has gone past the goal, to {np.degrees(estimate.door_angle):.0f}° or farther"
        if self.phase is Phase.RELEASE:
            self._enter(Phase.RETREAT, estimate, reason)
        elif self.phase is Phase.RETREAT:
            self.failure = self.failure or reason
            self._enter(Phase.DONE, estimate, reason)
        elif self.phase is Phase.RECOVER and estimate.door_angle >= float(self._model.goal_state[3]):
            self._give_up(estimate, reason)
        else:
            self.abort(estimate, reason)

    def _enter(self, phase: Phase, estimate: Estimate, reason: str) -> None:
        closed, self._letting_go = self._closed, None
        self.phase, self._entered, self._progress_at, self._since = phase, estimate.time, estimate.time, None
        if phase in (Phase.TOUCH, Phase.OPEN, Phase.HOLD):
            self._clear_at = estimate.time
        if phase is Phase.OPEN:
            self._opening.resume(estimate.time, self._settings.touch_force)
            if not self._grips:
                self._estimator.contact.declare(True)
        elif phase is Phase.HOLD:
            self._held_door = HeldDoor(self._model, estimate.time, self.comes_back)
        elif phase is Phase.TOUCH:
            self._leaf.begin(float(self._model.start_state[2]))
            self._estimator.contact.expect()
        elif phase is Phase.RECOVER:
            self._leaf.begin(float(estimate.state[2]), estimate)
            self._nearest = estimate.door_angle
        elif phase is Phase.RELEASE:
            self._leaf.begin(float(estimate.state[2]), estimate)
            self._letting_go = LettingGo(
                self._model, self._leaf, None if self._grips else estimate.push, estimate, closed
            )
        elif phase is Phase.RETREAT:
            self._way_out = Retreat(self._model, estimate)
        elif phase is Phase.DONE:
            self._way_out = self._way_out or Retreat(self._model, estimate)
            self._way_out.stay(estimate)
            if self.opened and abs(estimate.door_angle - float(self._model.goal_state[3])) > OPEN_ENOUGH:
                self.opened = False
                self.seen = f"by its own estimate the door is at {np.degrees(estimate.door_angle):.0f}°"
        self._on_change(estimate.time, phase, reason)

    def _hover(self, estimate: Estimate, body_rates: Array, time_step: float) -> Setpoint:
        setpoint, ready = self._approaching.to_hover(estimate, time_step)
        if ready:
            self._enter(Phase.APPROACH, estimate, "")
        return setpoint

    def _approach(self, estimate: Estimate, body_rates: Array, time_step: float) -> Setpoint:
        setpoint, arrived, reason = self._approaching.to_leaf(estimate, time_step)
        if arrived:
            self._enter(Phase.TOUCH, estimate, reason)
        return setpoint

    def _touch(self, estimate: Estimate, body_rates: Array, time_step: float) -> Setpoint:
        """Along the normal at a gentle speed until the tip is stopped; then press."""
        if self._since is None and (estimate.touching or self._leaf.blunted(estimate)):
            self._since = estimate.time
            self._estimator.contact.declare(True)
        if self._since is None and self._leaf.blocked(estimate):
            self._since = estimate.time
            self._estimator.meet_leaf(estimate.tip_angle, self._leaf.free_wind)
        if self._since is not None:
            pressed = estimate.time - self._since >= _PRESSING
            if pressed and self._grips and estimate.time - self._since < _PRESSING + _TUGGING:
                return self._leaf.push(estimate, -self._tug)
            if pressed and (estimate.touching or self._grips):
                self._unsure = float(self._model.start_state[3]) - estimate.door_angle > _MISSING
                self._enter(Phase.OPEN, estimate, "")
            elif pressed:  # the leaf stands a little farther away than was believed
                self._since = None
            if estimate.touching or self._grips:
                return self._leaf.push(estimate, self._settings.touch_force)
        if self._model.travel.left(estimate.door_angle) <= -_OPENED_ALREADY:
            self.abort(estimate, f"the leaf has opened by itself: none before {np.degrees(estimate.door_angle):.0f}°")
            return self._leaf.push(estimate, 0.0)
        if float(self._model.start_state[3]) - estimate.door_angle > _MISSING:
            return self._leaf.search(estimate, _SEARCH_SPEED)
        return self._leaf.move(estimate, self._settings.touch_speed)

    def _open(self, estimate: Estimate, body_rates: Array, time_step: float) -> Setpoint:
        setpoint = self._opening.step(estimate, body_rates)
        if self._opening.done(estimate.time):
            self.opened = True
            if self._settings.then == "stay":
                self._stay(estimate)
            elif self._opening.keeps_the_door(estimate):
                self._enter(Phase.RELEASE, estimate, "")
            else:
                self._enter(Phase.HOLD, estimate, "the door would not stay by itself")
        elif stuck := self._opening.stuck(estimate):
            (self._give_up if self._opening.may_go_on(estimate) else self.abort)(estimate, stuck)
        elif not estimate.touching and not self._opening.held:
            assert self._entered is not None
            self._unsure = self._unsure and estimate.time - self._entered < _SURE
            self._recoveries += 1
            if self._recoveries > self._settings.recoveries:
                self._give_up(estimate, f"contact was lost {self._recoveries} times")
            else:
                self._enter(Phase.RECOVER, estimate, f"contact lost at {np.degrees(estimate.door_angle):.1f}°")
        return setpoint

    def _stay(self, estimate: Estimate) -> None:
        """End with the tip on the leaf; a vehicle that has to land holds the door until somebody takes it."""
        if self.comes_back:
            self._enter(Phase.HOLD, estimate, "the tip is to stay")
            return
        self._keeps_hold = True
        self._enter(Phase.DONE, estimate, "")

    def _hold(self, estimate: Estimate, body_rates: Array, time_step: float) -> Setpoint:
        """Go on holding a door that would not stay by itself; a mission that need not come back ends so, the tip on the leaf."""
        assert self._held_door is not None
        after, reason = self._held_door.judge(estimate, time_step)
        if after is After.OPEN:
            self._keeps_hold = True
            self._enter(Phase.DONE, estimate, "")
        elif after is After.LOST:
            self._give_up(estimate, reason)
        elif after is After.LEAVE:
            self.abort(estimate, reason)
        return self._opening.step(estimate, body_rates)

    def _recover(self, estimate: Estimate, body_rates: Array, time_step: float) -> Setpoint:
        if estimate.door_angle < self._nearest - _PROGRESS:
            self._nearest, self._progress_at = estimate.door_angle, estimate.time
        if estimate.touching:
            self._enter(Phase.OPEN, estimate, "contact regained")
        return self._leaf.push(estimate, self._settings.touch_force)

    def _release(self, estimate: Estimate, body_rates: Array, time_step: float) -> Setpoint:
        """Let go; a door that comes back meanwhile is held instead."""
        assert self._letting_go is not None
        gripped = self._letting_go.unloads
        parting = self._letting_go.step(estimate, bool(self.failure))
        if gripped and not (self._letting_go.unloads or self.failure):
            self._estimator.door.stays()
        if parting.then is Then.HELD:
            self._opening.hold_again(estimate, parting.push)
            moved = "moved as the load was taken off it" if self._grips else "came back as the push faded"
            self._enter(Phase.HOLD, estimate, f"the door {moved}")
        elif parting.then is not Then.MORE:
            if parting.then is Then.GONE:
                self.failure = f"the leaf has gone past the goal, to {np.degrees(estimate.tip_angle):.0f}° or farther"
            self._enter(Phase.RETREAT, estimate, self.failure)
        return parting.setpoint

    def _retreat(self, estimate: Estimate, body_rates: Array, time_step: float) -> Setpoint:
        assert self._way_out is not None
        setpoint, arrived = self._way_out.step(estimate, time_step)
        if arrived and self.phase is Phase.RETREAT:
            if self._again:
                self._begin_anew(estimate)
            else:
                self._enter(Phase.DONE, estimate, self.failure)
        return setpoint

    def _begin_anew(self, estimate: Estimate) -> None:
        """Another attempt, as the first one: what was learnt of leaf and hinge is forgotten."""
        self._attempt, self._again = self._attempt + 1, False
        reason, self.failure = f"attempt {self._attempt}, after: {self.failure}", ""
        self._recoveries = 0
        self.opened = self._unsure = False
        self._opening = self._make_opening()
        assert self._way_out is not None
        self._approaching = Approach(self._model, self._leaf, self._way_out.glide)
        self._estimator.lose_leaf()
        self._enter(Phase.HOVER, estimate, reason)
