"""Holding a pushed door at the goal: the tip presses less than moves it, and more than lets it back."""

from __future__ import annotations

import math

from doorman.control.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.push_control import PushController
from doorman.control.state_converter import StateConverter
from doorman.mission.progress import STANDS, STILL_OPEN, Progress
from doorman.model import Model

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


class Holding:
    """Of the door in one opening.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        push: Controller of the push.
        progress: Of the opening.
    """

    def __init__(self, model: Model, converter: StateConverter, push: PushController, progress: Progress) -> None:
        self._converter, self._push, self._progress = converter, push, progress
        self._settings = model.scenario.push
        self._goal, self._lever = float(model.goal_state[3]), model.coupling.distance_from_hinge
        self._place: Setpoint | None = None
        self._pressing = 0.0

    @property
    def held(self) -> bool:
        """Whether the door is being held, and not moved."""
        return self._place is not None

    def begin(self, estimate: Estimate) -> None:
        """Hold the door from here; the push becomes what held it last, if that was so.

        Args:
            estimate: What is known now.
        """
        self._place = self._converter.hold(estimate.position, float(estimate.state[2]))

    def end(self) -> None:
        """Move the door again."""
        self._place = None

    def update(self, estimate: Estimate) -> None:
        """Decide whether the door is to be held where it is.

        Args:
            estimate: What is known now.
        """
        off = estimate.door_angle - self._goal
        if self.held and off > STILL_OPEN:
            self.end()
        elif not self.held and (off < 0.0 or (off < _CLOSE and abs(self._progress.rate) < STANDS)):
            self.begin(estimate)
            friction = max(0.0, estimate.hinge.friction)
            resistance = max(0.0, -estimate.door_disturbance)
            self._pressing = (resistance - (1.0 - self._settings.hold_share) * min(friction, resistance)) / self._lever

    def step(self, estimate: Estimate, time_step: float) -> Setpoint:
        """Setpoint that holds the door: what it was pushed with until now is eased to what holds it.

        That is changed slowly where the door moves nevertheless.

        Args:
            estimate: What is known now.
            time_step: Since the last tick [s].
        """
        assert self._place is not None
        off, settings, push = estimate.door_angle - self._goal, self._settings, self._push
        beyond = off - min(max(off, -_CLOSE), _CLOSE)
        self._pressing += time_step * settings.hold_gain * beyond / settings.hold_tolerance
        self._pressing = max(self._pressing, settings.least_force)
        most = time_step * (_EASING if abs(self._progress.rate) < STANDS else _BRAKING)
        eased = push.push + min(max(self._pressing - push.push, -most), most)
        past = max(self._lever * (self._goal - _PAST - estimate.tip_angle), 0.0)
        back = _STIFFNESS * past + _DAMPING * min(past / _DAMPED, 1.0) * max(estimate.tip_speed, 0.0)
        setpoint = push.hold(self._place, eased - back, estimate)
        push.push = eased  # what comes next is eased from that
        return setpoint
