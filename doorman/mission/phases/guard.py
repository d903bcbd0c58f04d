"""Where going on at the leaf would do harm: rotors near leaf or jamb, a silent planner, a leaf beyond the goal, sinking."""

from __future__ import annotations

import math

from doorman.control.estimation.estimator import Estimate
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.phase import GiveUp, MissionPhase, Phase
from doorman.planning.pace import OPEN

_DOUBT = 0.1
"""For which rotors must seem to meet something [s]."""
_PAST = math.radians(10.0)
"""A leaf that is so far beyond the goal cannot be brought back by a push [rad]."""
_SUNK = 0.1
"""By which the shipped vehicle's tip may be lower on the leaf than at its touch [m]: plans keep it there. What sinks has no
thrust left, or no hold of its attitude."""


class Guard:
    """Watches the phases at the leaf."""

    def __init__(self, attempt: Attempt) -> None:
        self._attempt = attempt
        self._clear_at = self._high_at = 0.0
        self._above: tuple[int, float] | None = None

    def begin(self, now: float) -> None:
        """Begin, with the rotors clear of leaf and jambs."""
        self._clear_at = self._high_at = now

    def judge(self, phase: MissionPhase, estimate: Estimate) -> GiveUp | None:
        """Whether the attempt must end now; once per tick."""
        near, beside = self._nearness(estimate, phase.tied)
        self._clear_at = self._clear_at if near or beside else estimate.time
        if estimate.time - self._clear_at > _DOUBT:
            what = "the leaf" if near else "a jamb"
            reason = f"the rotors come too near to {what} at {self._stands(estimate)}"
            return GiveUp(reason, for_good=False, at_once=not phase.tied)
        if self._attempt.schedule.is_silent(estimate.time):
            return GiveUp(f"the planner is silent for {self._attempt.schedule.overdue(estimate.time):.1f} s")
        sunk = self._sunk(estimate)
        borne = (
            phase.tied or sunk < _SUNK * self._attempt.model.scale.length
        )  # a tied tip bears what thrust does not lift
        self._high_at = estimate.time if borne else self._high_at
        if estimate.time - self._high_at > _DOUBT:
            return GiveUp(f"the vehicle has sunk by {1e2 * sunk:.0f} cm at {self._stands(estimate)}")
        past = OPEN if phase.phase is Phase.RECOVER else _PAST
        model = self._attempt.model
        if model.contact.pull == 0.0 and model.travel.left(estimate.door_angle) < -past:  # nothing brings it back
            return GiveUp(f"the leaf has gone past the goal, to {self._stands(estimate)}")
        return None

    def _stands(self, estimate: Estimate) -> str:
        """Where the door is, in words."""
        return self._attempt.model.door.in_words(estimate.door_angle, 0)

    def _sunk(self, estimate: Estimate) -> float:
        """By how much the tip is lower on the leaf than when this attempt touched [m]: a vehicle that leans is higher itself."""
        attempt = self._attempt
        _, upwards = attempt.model.door.level_first(estimate.along)
        above = float(upwards @ (estimate.tip - estimate.contact_point))
        if self._above is None or self._above[0] != attempt.number:
            self._above = attempt.number, above
        return self._above[1] - above

    def _nearness(self, estimate: Estimate, tied: bool) -> tuple[bool, bool]:
        """Whether the rotors come near the leaf, and near a jamb."""
        leaf = self._attempt.leaf
        if tied and not estimate.rests:
            return False, False  # a leaf that swings meets a vehicle that lets go
        near = leaf.hits_the_rotors(estimate)
        beside = leaf.levels_into_a_jamb(estimate) if tied else leaf.meets_a_jamb(estimate)
        return near, beside
