"""What a phase of the mission is: entry, step, what follows, time-out."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate, Tie
from doorman.control.motion import Glide
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt


class Phase(Enum):
    """Where a mission is."""

    HOVER = "hover"
    TOUCH_FRAME = "touch_frame"
    APPROACH = "approach"
    TOUCH = "touch"
    OPEN = "open"
    HOLD = "hold"
    RECOVER = "recover"
    TAKE_BACK = "take_back"
    RELEASE = "release"
    RETREAT = "retreat"
    THROUGH = "through"
    DONE = "done"


_LONGEST = {
    Phase.HOVER: 15.0, Phase.TOUCH_FRAME: 90.0, Phase.TOUCH: 30.0, Phase.RECOVER: 6.0, Phase.TAKE_BACK: 20.0, Phase.RELEASE: 8.0,
    Phase.RETREAT: 30.0, Phase.THROUGH: 60.0,
}  # fmt: skip
"""Time-outs of phases that take as long wherever they are flown: about three times what the slowest shipped task needs [s]."""


@dataclass(frozen=True)
class Next:
    """Another phase begins."""

    phase: Phase
    reason: str = ""
    """Why, where it is not what the phase was for."""


@dataclass(frozen=True)
class GiveUp:
    """The attempt ends: let go of the door, retreat and hover."""

    reason: str
    for_good: bool = True
    """Whether no other attempt may follow."""
    at_once: bool = False
    """Whether the vehicle leaves without letting go gently."""
    takes_back: bool = True
    """Whether a door in the gripper is first taken back to where it was found."""


Then = Next | GiveUp | None
"""What follows a tick: a phase, the end of the attempt, or more of the same."""


class MissionPhase(ABC):
    """One phase, made anew each time that it begins.

    Args:
        attempt: What the phases share.
        estimate: What is known as it begins.
        before: The phase before; None at the mission's start.
    """

    phase: ClassVar[Phase]
    """What it counts as: time-out, words of the flight."""
    name: ClassVar[str] = ""
    """As recorded; that of `phase` if not given."""
    before: ClassVar[Phase | None] = None
    """For a phase of your own: it is flown where this one would begin, and goes on with that."""
    at_the_leaf: ClassVar[bool] = False
    """Whether the tip is to touch the leaf."""
    leaves: ClassVar[bool] = False
    """Whether the vehicle lets go of the leaf, or goes out."""
    guarded: ClassVar[bool] = False
    """Whether a leaf or jamb near the rotors ends the attempt."""

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        self.attempt, self.entered = attempt, estimate.time
        self._longest = _LONGEST.get(self.phase) or float(
            getattr(attempt.settings.time_out, self.phase.value, math.inf)
        )
        self.glide: Glide | None = None
        """Reference of free flight, for the phase that follows."""

    @abstractmethod
    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """One tick."""

    @property
    def tie(self) -> Tie:
        """What is known of tip and leaf."""
        return self.attempt.tie if self.at_the_leaf else Tie.FREE

    @property
    def follows(self) -> bool:
        """Whether a plan is followed: where the tip is what plans take it for."""
        return self.at_the_leaf and self.tie is self.attempt.tie

    @property
    def goal(self) -> float | None:
        """Where a plan brings the leaf, if not to the mission's goal [rad]."""
        return None

    @property
    def closes_gripper(self) -> bool:
        """Whether a gripper is to be closed, if there is one."""
        return self.at_the_leaf

    @property
    def tied(self) -> bool:
        """Whether the tip is to be tied to the leaf now."""
        return self.closes_gripper and self.attempt.model.contact.tied > 0.0

    @property
    def gives_way(self) -> bool:
        """Whether the vehicle gives way to a slammed door."""
        return False

    def holds(self, now: float) -> bool:
        """Whether a gripper should hold the leaf by now, and is no longer pressed onto it."""
        return self.tied

    def speed_back(self, estimate: Estimate) -> float:
        """Speed with which the phase itself, or its plan, draws the tip back from the leaf [m/s].

        A plan begins with the speed that was measured: of a tip that is thrown back, no more than plans make is its own.
        """
        plan, attempt = self.attempt.schedule.current, self.attempt
        if not self.follows or plan is None:
            return 0.0
        rate = attempt.converter.door_rate(plan.plan, estimate.time - plan.start)
        return min(max(0.0, rate), attempt.fastest) * attempt.model.coupling.lever_length

    def without_hold(self, estimate: Estimate) -> GiveUp:
        """What follows where a closed gripper feels no leaf: one that had to be looked for moves, and the vehicle comes again."""
        if self.attempt.unsure:
            return GiveUp("the gripper finds no hold on a leaf that moves", for_good=False, at_once=True)
        return GiveUp("the gripper does not hold the leaf", at_once=True)

    def expired(self, now: float) -> bool:
        """Whether the phase has lasted too long."""
        return now - self.entered > self.longest

    @property
    def longest(self) -> float:
        """Time-out [s]."""
        return self._longest

    def ends_here(self) -> Next:
        """The mission's end where the vehicle is: there is nothing left to let go of."""
        reason = f"the phase {self.phase.value} took longer than {self.longest:g} s"
        self.attempt.failure = self.attempt.failure or reason
        return Next(Phase.DONE, reason)

    def time_out(self, estimate: Estimate) -> Next | GiveUp:
        """The phase that follows one that has lasted too long, or the end of the attempt."""
        return GiveUp(f"the phase {self.phase.value} took longer than {self.longest:g} s")
