"""Opening: following plans until the door stands at the goal, and holding it there."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.push_control import PushController
from doorman.control.state_converter import StateConverter
from doorman.control.turning_aid import TurningAid
from doorman.mission.schedule import PlanSchedule
from doorman.model import GRAVITY, Model
from doorman.ocp.hinge import Hinge
from doorman.ocp.quasi_static_planning import push_state

Array = NDArray[np.float64]

_NEAR = math.radians(2.0)
"""A door that swings about the goal and no farther is near enough after a while [rad]."""
_AT_GOAL = math.radians(0.9)
_SLOW = 0.005
"""A gripped door that is this near to the goal and this slow, for a while, is taken to stay there [rad], [rad/s]."""
_LENIENCE = math.radians(0.35)
"""By which that is more with every time that it passed the goal but the first, up to `_NEAR`: it sticks and slips [rad]."""
_ARRIVED = math.radians(0.5)
_ARRIVING = 0.05
"""A gripped door that comes this near to the goal, and is no faster, is left to its friction [rad], [rad/s]."""
_NO_FRICTION = 0.1
"""A gripped door with less, by estimate, does not rest by itself [N m]."""
_LEFT_TO_FRICTION = 0.7
"""Share of its friction that is then counted on."""
_SETTLING = 4.0
"""Hold times after which it is."""
_CLOSE = math.radians(0.8)
"""A pushed door that stands this near to the goal is held: to move it on would take a jerk that friction turns into more."""
_PAST = math.radians(0.5)
_STIFFNESS, _DAMPING = 40.0, 12.0
"""A tip that is farther past the goal is held back: the door stays there by its friction, or comes back [rad], [N/m], [N s/m]."""
_DAMPED = 0.005
"""Way in which that damping sets in [m]."""
_EASING = 0.8
_BRAKING = 8.0
"""Change of the push where holding begins, on a door that stands and on one that moves: a step throws the tip off [N/s]."""
STILL_OPEN = math.radians(1.5)
"""A held door that is farther off is pushed again, if it is not open enough."""
_BEYOND = math.radians(2.0)
"""One that is so far past the goal has not been opened as asked."""
_STANDS = 0.01
"""A door whose average rate is smaller stands [rad/s]."""
_AVERAGED = 0.5
"""Over this time [s]."""
_SWINGS = 0.02
"""A door that opens faster teaches its resistance [rad/s],"""
_LEARNT = 1.0
"""within this time [s]."""
_STICKS = 0.01
"""A slower gripped door sticks [rad/s]."""
_NUDGE = 0.8
_PUSHED_NUDGE = 0.6
"""Growth of the friction that plans are told of while a door sticks, with a grip and with a push [N m/s]."""
_FAR = math.radians(4.0)
"""Nearer to the goal, nudges are smaller in proportion: what comes loose with a jerk would pass the goal."""
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
"""A door that has stood before the goal, within `_FAR` of it, for longer [s] is pushed more and more [N m/s]."""
_SHARE_MORE = 0.5
"""A door that resists much may resist more by this share anywhere: it also stops the sooner."""
_HELD = 1.0
"""A door that stood for so long in its swing may have been held, [s],"""
_LOOSE = 2.0
"""and is taken to resist by no more than before for this long when it moves on [s]."""
_STOPPED = 0.3
"""A door that stands for so long meanwhile has stopped again [s]."""
_PROGRESS = math.radians(0.5)
_STUCK = 10.0
"""Time without progress after which an opening is given up [s]."""
_STUCK_IN_SWING = 6.0
"""The same for a pushed door that has swung: somebody holds it, and pushing harder tilts the disc onto the leaf [s]."""
_SWINGING = 4
"""Steps of progress after which a door has swung."""
_SILENT = 0.5
"""A planner that makes one plan for so long is given up; what is flown meanwhile is the last plan, which is longer [s]."""
_AHEAD = math.radians(16.0)
"""No heading is asked for that is farther ahead of a gripped door; where the door gives way, it is 15° at most [rad]."""
_TOO_FAR_AHEAD = math.radians(22.0)
_GIVES_WAY = 0.05
"""A gripping vehicle that is turned farther ahead of a door that is slower leans on it, and is turned on [rad], [rad/s]."""
_HEADING_LOST = math.radians(55.0)
"""A vehicle that is turned so far from the heading that keeps step with the door does not find back [rad]."""
_PATIENCE = 12.0
"""Hold times after which a door that swings about the goal is near enough."""


class Opening:
    """Setpoints from the touch until the door is open.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        schedule: Plans.
        push: Controller of a tip that can only push; None if it grips.
    """

    def __init__(
        self, model: Model, converter: StateConverter, schedule: PlanSchedule, push: PushController | None
    ) -> None:
        self._converter, self._schedule, self._push = converter, schedule, push
        self._settings, self._hold_time = model.scenario.push, model.scenario.mission.hold_time
        self._model = model
        self._goal, self._lever = float(model.goal_state[3]), model.coupling.distance_from_hinge
        self._sense = math.copysign(1.0, float(model.goal_state[2] - model.start_state[2]))
        self._weight = model.vehicle.mass * GRAVITY
        self._tip_position = model.vehicle.tip_position
        self._turning_aid = TurningAid(model)
        self._nearest = math.inf
        self._way = abs(float(model.start_state[3]) - self._goal)
        self._progress_at = 0.0
        self._steps_nearer = 0
        self._rate = 0.0
        self._good_since: float | None = None
        self._slow_since: float | None = None
        self._near_since: float | None = None
        self._held_since: float | None = None
        self._held: Setpoint | None = None
        self._waiting: Setpoint | None = None
        self._nudges = model.scenario.control.door_observer_rate > 0.0
        self._pressing = 0.0
        self._stiction = 0.0
        self._counted_on = 0.0
        self.resistance = 0.0
        """Torque against opening while the door swung last [N m]."""
        self._rest: float | None = None
        self._rested = False
        self._side = 0.0
        self._passes = -1
        self._stood = 0.0
        self._beside = 0.0
        self._loose = 0.0
        self._taught = 0.0
        self._most = model.scenario.control.max_door_disturbance
        self._last = 0.0

    @property
    def held(self) -> bool:
        """Whether the door is being held, and not moved."""
        return self._held is not None

    def may_go_on(self, estimate: Estimate) -> bool:
        """Whether another attempt may do better than one that is stuck: plans come and are flown, and the door has swung."""
        plans = self._schedule.overdue(estimate.time) <= _SILENT and not self._schedule.refusal
        return plans and self._steps_nearer > _SWINGING

    def resume(self, now: float, push: float) -> None:
        """Begin, or go on after contact was regained.

        Args:
            now: [s].
            push: F_n that the tip presses with [N].
        """
        self._schedule.forget()
        self._waiting, self._beside = None, 0.0
        self._held, self._progress_at, self._nearest, self._last = None, now, math.inf, now
        if self._push is not None:
            self._push.begin(push)

    def hold_again(self, estimate: Estimate, push: float) -> None:
        """Hold a door that was held before, from a push on that has faded meanwhile: it grows to what held the door then.

        Args:
            estimate: What is known now.
            push: F_n that the tip presses with [N].
        """
        self.resume(estimate.time, push)
        self._held = self._converter.hold(estimate.position, float(estimate.state[2]))

    def step(self, estimate: Estimate, body_rates: Array) -> Setpoint:
        """Setpoint for now.

        Args:
            estimate: What is known now.
            body_rates: Ω, shape (3,) [rad/s].
        """
        now, off = estimate.time, estimate.door_angle - self._goal
        time_step, self._last = now - self._last, now
        self._rate += min(time_step / _AVERAGED, 1.0) * (estimate.door_rate - self._rate)
        self._learn_resistance(estimate, time_step)
        stands = 0.0 < off < _FAR and abs(self._rate) < _STANDS and self._held is None
        self._beside = self._beside + time_step if stands else 0.0
        self._judge(now, off)
        if self._push is not None and self._holds(off, estimate):
            return self._hold(self._push, off, estimate, time_step)
        state = self._converter.planner_state(estimate.state, body_rates)
        if self._push is not None:
            state = push_state(state, self._push.push, self._weight)
        self._nudge(off, estimate.door_rate, time_step)
        disturbance = max(self._disturbance(off, estimate) - self._stiction, -self._most_now(off))
        current = self._schedule.update(now, state, self._hinge(estimate, disturbance), self._lean(estimate))
        if current is None:
            if self._waiting is None:
                self._waiting = self._converter.hold(estimate.position, float(estimate.state[2]))
            setpoint = self._waiting
            return setpoint if self._push is None else self._push.hold(setpoint, self._push.push, estimate)
        self._waiting = None
        if self._push is None:
            setpoint = self._converter.setpoint(current.plan, now - current.start, estimate.arm_angles)
            turning = self._converter.turning(current.plan, now - current.start)
            beyond = self._ahead(setpoint.yaw, estimate.door_angle) - _AHEAD
            if beyond > 0.0:  # plans turn with a door that should move, and one that is held does not
                setpoint, turning = replace(setpoint, yaw=setpoint.yaw - self._sense * beyond), 0.0
            aid = self._turning_aid.force(estimate.state, body_rates, turning, time_step, estimate.attitude_lag)
            return replace(setpoint, force=setpoint.force + aid)
        return self._push.follow(current.plan, now - current.start, estimate, -disturbance, time_step)

    def _disturbance(self, off: float, estimate: Estimate) -> float:
        """Torque of the hinge that plans are told: a door that stands resists by no more than it is pushed, but could."""
        if self._push is None:
            return self._at_rest(off, estimate)
        if abs(estimate.door_rate) > _STICKS:
            self._counted_on = estimate.door_disturbance
        else:
            self._counted_on = min(self._counted_on, estimate.door_disturbance)
        return self._counted_on

    @property
    def _in_swing(self) -> bool:
        """Whether a pushed door has swung for a while, and has shown what it resists with."""
        return self._push is not None and self._steps_nearer > _SWINGING and self._taught > _LEARNT

    def _most_now(self, off: float) -> float:
        """Largest resistance that plans are told of [N m].

        A door that has swung and stands is held by somebody, or sticks a little more than it slid. Whoever holds it will let
        it go, and a push that has grown meanwhile would throw it beyond the goal.
        """
        if not self._in_swing:
            return self._most
        least = max(self.resistance, 0.0)
        more = max(_HELD_MORE * min(max(off / _FAR_FROM_IT, _LEAST_MORE), 1.0), _SHARE_MORE * least)
        more += min(_GROWTH * max(0.0, self._beside - _STANDS_LONG), _HELD_MORE)
        return min(self._most, least + (0.0 if self._loose > 0.0 else more))

    def _learn_resistance(self, estimate: Estimate, time_step: float) -> None:
        """What the door resists with while it swings, and whether it has just been let go of.

        What it was pushed with while it was held is no resistance any more then. If it stops again it is, and was not held.
        """
        self._loose = max(0.0, self._loose - time_step)
        if abs(estimate.door_rate) < _STICKS:
            self._stood += time_step
            if self._loose > 0.0 and self._stood > _STOPPED:
                more = min(-estimate.door_disturbance, self.resistance + _HELD_MORE)
                self.resistance, self._loose = max(self.resistance, more), 0.0
        elif estimate.door_rate < -_SWINGS:
            if self._stood > _HELD and self._in_swing:
                self._loose, self._stiction = _LOOSE, 0.0
            self._stood = 0.0
            if self._loose == 0.0:
                self._taught += time_step
                self.resistance -= min(time_step / _LEARNT, 1.0) * (estimate.door_disturbance + self.resistance)

    def _at_rest(self, off: float, estimate: Estimate) -> float:
        """Torque of a gripped hinge, without its friction where the door should come to rest: it is what holds the door there.

        Else the push that overcomes the friction of a slow door carries it beyond the goal, by degrees. One without friction
        follows whatever it is pushed with: what is estimated brings it to the goal, and a torque of the moment away from it.
        """
        torque = estimate.door_disturbance
        if abs(off) > self._at_goal or estimate.hinge.friction < _NO_FRICTION:
            self._rest = None
        elif self._passes > 1 and abs(self._rate) < _SLOW:
            self._rest = torque if self._rest is None else self._rest
        elif not self._rested and abs(off) < _ARRIVED and abs(self._rate) < _ARRIVING:
            self._rested = True  # once: a door that does not stay so is held against its friction
            friction = _LEFT_TO_FRICTION * max(0.0, estimate.hinge.friction)
            if self._rate < 0.0:
                self._rest = min(torque + friction, max(torque, 0.0))
            else:
                self._rest = max(torque - friction, min(torque, 0.0))
        return torque if self._rest is None else self._rest

    @property
    def _at_goal(self) -> float:
        """Distance from the goal at which a gripped door may stay [rad]."""
        return min(_AT_GOAL + _LENIENCE * max(0, self._passes - 1), _NEAR)

    def _hinge(self, estimate: Estimate, torque: float) -> Hinge:
        """What plans are told: the estimated parameters, and a disturbance that makes their sum what it is now.

        Without an observer that finds that sum, it is the scenario's hinge.

        Args:
            estimate: Of door and hinge.
            torque: Of the hinge now beyond what the scenario names [N m].
        """
        hinge, door = estimate.hinge, self._model.door
        if self._model.scenario.control.door_observer_rate == 0.0:
            return Hinge.of(door, torque)
        torque += (door.damping - hinge.damping) * estimate.door_rate
        torque += (door.stiffness - hinge.stiffness) * (estimate.door_angle - door.rest_angle)
        return Hinge(0.0, torque, hinge.inertia, hinge.damping, hinge.stiffness)

    def _lean(self, estimate: Estimate) -> float:
        """How much nearer to the leaf a vehicle comes that leans into the wind about its tip [m]."""
        if self._push is None:
            return 0.0
        depth = abs(float(self._tip_position(estimate.arm_angles)[2]))
        return depth * float(np.hypot(estimate.wind[0], estimate.wind[1])) / self._weight

    def _nudge(self, off: float, rate: float, time_step: float) -> None:
        """Tell plans of more and more friction while the door sticks beside the goal: they push, or pull, harder."""
        nudge, forgotten = (_NUDGE, _FORGOTTEN) if self._push is None else (_PUSHED_NUDGE, _PUSHED_FORGOTTEN)
        stays = self._rest is not None and self._passes > 1
        if self._nudges and not stays and abs(rate) < _STICKS and abs(off) > self._settings.hold_tolerance:
            stiction = self._stiction + math.copysign(nudge * min(abs(off) / _FAR, 1.0) * time_step, off)
            self._stiction = min(max(stiction, -_MOST_STICTION), _MOST_STICTION)
        else:
            self._stiction *= math.exp(-time_step / forgotten)

    def done(self, now: float) -> bool:
        """Whether the door has stood at the goal for long enough, and stands still right now."""
        if self._push is not None:
            return self._held_since is not None and now - self._held_since >= self._hold_time
        good = self._good_since is not None and now - self._good_since >= self._hold_time
        slow = self._slow_since is not None and now - self._slow_since >= _SETTLING * self._hold_time
        near = self._near_since is not None and now - self._near_since >= _PATIENCE * self._hold_time
        return ((good or slow) and abs(self._rate) < 0.4 * _SLOW) or near

    def stuck(self, estimate: Estimate) -> str:
        """Why the opening should be given up; empty if it should not."""
        if (late := self._schedule.overdue(estimate.time)) > _SILENT:
            return f"the planner is silent for {late:.1f} s"
        angle = math.degrees(estimate.door_angle)
        ahead = self._ahead(float(estimate.state[2]), estimate.door_angle)
        if self._push is None and ahead > _TOO_FAR_AHEAD and abs(self._rate) < _GIVES_WAY:
            return f"the door does not give way: {math.degrees(ahead):.0f}° ahead of it at {angle:.1f}°"
        if abs(ahead) > _HEADING_LOST:
            turned = math.degrees(abs(ahead))
            return f"the heading is lost: {turned:.0f}° beside where it should be at {angle:.1f}°"
        held = self._in_swing and estimate.door_angle - self._goal > _FAR  # nearer, it has come back
        patience = _STUCK_IN_SWING if held else _STUCK
        if estimate.time - self._progress_at < patience or self._near_since is not None:
            return ""
        return f"the door does not move on from {angle:.1f}° against {max(0.0, -estimate.door_disturbance):.2f} N m" + (
            f"; the last plan: {self._schedule.refusal}" if self._schedule.refusal else ""
        )

    def _ahead(self, yaw: float, door_angle: float) -> float:
        """By how much a heading is ahead of the one that keeps step with the door [rad]."""
        return self._sense * math.remainder(yaw - float(self._model.on_the_way(door_angle)[2]), 2.0 * math.pi)

    def _judge(self, now: float, off: float) -> None:
        """Note how long the door has been at the goal, and when it last came nearer."""
        if abs(off) < self._nearest - _PROGRESS:
            self._steps_nearer += math.isfinite(self._nearest) and abs(off) < self._way  # where it begins is no step
            self._nearest, self._progress_at = abs(off), now
        if abs(off) > self._settings.hold_tolerance and math.copysign(1.0, off) != self._side:
            self._side, self._passes = math.copysign(1.0, off), self._passes + 1
        good = abs(off) < self._settings.hold_tolerance and abs(self._rate) < 2.0 * _SLOW
        slow = abs(off) < self._at_goal and abs(self._rate) < _SLOW
        held = self._held is not None and -_BEYOND < off < STILL_OPEN and abs(self._rate) < _STANDS
        self._good_since = (self._good_since if self._good_since is not None else now) if good else None
        self._slow_since = (self._slow_since if self._slow_since is not None else now) if slow else None
        near = abs(off) < _NEAR
        self._near_since = (self._near_since if self._near_since is not None else now) if near else None
        self._held_since = (self._held_since if self._held_since is not None else now) if held else None

    def _holds(self, off: float, estimate: Estimate) -> bool:
        """Whether the door is to be held where it is."""
        if self._held is not None and off > STILL_OPEN:
            self._held = None
            self._schedule.forget()
        elif self._held is None and (off < 0.0 or (off < _CLOSE and abs(self._rate) < _STANDS)):
            self._held = self._converter.hold(estimate.position, float(estimate.state[2]))
            friction = max(0.0, estimate.hinge.friction)
            resistance = max(0.0, -estimate.door_disturbance)
            self._pressing = (resistance - (1.0 - self._settings.hold_share) * min(friction, resistance)) / self._lever
        return self._held is not None

    def _hold(self, push: PushController, off: float, estimate: Estimate, time_step: float) -> Setpoint:
        """Press less than moves the door, and more than lets it back; change that slowly where it moves nevertheless.

        What it was pushed with until now is eased to that.
        """
        settings = self._settings
        beyond = off - min(max(off, -_CLOSE), _CLOSE)
        self._pressing += time_step * settings.hold_gain * beyond / settings.hold_tolerance
        self._pressing = max(self._pressing, settings.least_force)
        assert self._held is not None
        most = time_step * (_EASING if abs(self._rate) < _STANDS else _BRAKING)
        eased = push.push + min(max(self._pressing - push.push, -most), most)
        past = max(self._lever * (self._goal - _PAST - estimate.tip_angle), 0.0)
        back = _STIFFNESS * past + _DAMPING * min(past / _DAMPED, 1.0) * max(estimate.tip_speed, 0.0)
        setpoint = push.hold(self._held, eased - back, estimate)
        push.push = eased  # what comes next is eased from that
        return setpoint
