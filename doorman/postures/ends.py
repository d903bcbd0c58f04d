"""Start and goal of a task: what the scenario pins down of their postures, and the paper's rule for the rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.kinematics.coupling import BESIDE
from doorman.kinematics.doors.door import Door
from doorman.postures.room import Room
from doorman.postures.search import YAW
from doorman.scenario import GoalSection, Scenario, StartSection

PAPER_POSTURES: dict[str, tuple[float, ...]] = {
    "start.attitude": (0.0, 0.0, 0.0),
    "start.arm": (0.0, 1.0, -0.6, -0.4),
    "goal.attitude": (0.0, 0.0, -7 * math.pi / 18),
    "goal.arm": (0.0, math.pi / 2, -math.pi / 2, 0.0),
}
"""The paper's, by key of the scenario, for an arm of four joints [rad]."""

_RESERVE = 0.04
"""Beyond the margin, between disc and jamb at the goal of a tip that only presses: it may have slipped, and gusts blow [m]."""


@dataclass(frozen=True)
class End:
    """Start or goal."""

    name: str
    """`start` or `goal`."""
    door_angle: float
    """α [rad]."""
    attitude: tuple[float, ...] | None
    """Φ where the scenario pins it down [rad]."""
    arm: tuple[float, ...] | None
    """H where the scenario pins it down [rad]."""
    n_arm: int
    """Number of joints."""
    normal: float
    """Heading along the leaf's normal [rad]."""
    paper_arm: tuple[float, ...]
    """The paper's H, for four joints [rad]."""

    @classmethod
    def of(
        cls, name: str, section: StartSection | GoalSection, angle: float, door: Door, n_arm: int, share: float = 1.0
    ) -> End:
        """End of a scenario's section."""
        first, last = (np.array(PAPER_POSTURES[f"{end}.arm"]) for end in ("start", name))
        arm = tuple(((1.0 - share) * first + share * last).tolist())
        return cls(name, angle, section.attitude, section.arm, n_arm, door.heading(angle), arm)

    @property
    def free(self) -> NDArray[np.int64]:
        """Indices of x = [Φ, α, α̇, H] that a search may change: a vehicle that is free to turn stays level."""
        yaw = [] if self.attitude is not None else [YAW]
        return np.array([*yaw, *(range(5, 5 + self.n_arm) if self.arm is None else ())], dtype=np.int64)

    def state(self, arm: tuple[float, ...] | Array) -> Array:
        """Posture at rest with what is pinned down, along the leaf's normal where the attitude is not."""
        attitude = (0.0, 0.0, self.normal) if self.attitude is None else self.attitude
        return np.array([*attitude, self.door_angle, 0.0, *(arm if self.arm is None else self.arm)])

    def paper_state(self) -> Array | None:
        """Posture with the paper's arm; None for an arm with another number of joints that is not pinned down."""
        arm = self.paper_arm
        return None if self.arm is None and self.n_arm != len(arm) else self.state(arm)


def beside_the_normal(goal: Array, start: float, room: Room, scenario: Scenario, door: Door) -> Array:
    """Goal of a tip that may slip: in a narrow doorway its heading lies beside the normal, as on the way there."""
    goal, yaw = goal.copy(), float(goal[YAW])
    for beside in np.linspace(0.0, BESIDE, 15):
        goal[YAW] = yaw + door.hand * math.copysign(beside, start - goal[3])
        if room.to_latch(goal) < -(scenario.planner.margin + _RESERVE):
            break
    return goal
