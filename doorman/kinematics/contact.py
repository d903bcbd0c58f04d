"""How the tip holds the leaf, in numbers: a grip and a push are two values of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from doorman.kinematics.coupling import BESIDE
from doorman.scenario import Scenario


@dataclass(frozen=True)
class Contact:
    """What a tip can do at the leaf that it opens."""

    tied: float
    """g: share by which the tip is tied to the leaf. A gripper ties it whole; 0: it can only press, and slips."""
    pull: float
    """Force with which it draws the leaf towards the vehicle at most, and brakes it [N]."""
    beside: float
    """Largest angle between the leaf's normal and the way from O_B to the tip; infinite where the tip bears any force [rad]."""
    fits: bool
    """Whether it may touch the leaf nearer to the hinge than is asked for, where the doorway is narrow."""

    @classmethod
    def of(cls, scenario: Scenario) -> Contact:
        """That of a scenario's contact."""
        section = scenario.contact
        if section.kind == "grip":
            return cls(1.0, scenario.control.max_push, math.inf, False)
        return cls(0.0, 0.0, BESIDE, True)

    def between(self, pressing: float, tied: float) -> float:
        """A number of the model, by those of a tip that presses and of one that is tied."""
        return (1.0 - self.tied) * pressing + self.tied * tied
