"""Truth: what a simulated flight really did, as no sensor sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from doorman.arrays import Array
from doorman.one_line import OneLine
from doorman.stored_at_once import stored_at_once


@stored_at_once
@dataclass(frozen=True, eq=False, repr=False)
class Truth(OneLine):
    """State and contact of the simulated plant at one tick of the controller."""

    time: float
    """[s]."""
    position: Array
    """P of O_B, shape (3,), world frame [m]."""
    velocity: Array
    """Ṗ, shape (3,), world frame [m/s]."""
    attitude: Array
    """Φ = [φ, θ, ψ], shape (3,) [rad]."""
    body_rates: Array
    """Ω, shape (3,), body frame [rad/s]."""
    door_angle: float
    """α [rad]."""
    door_rate: float
    """α̇ [rad/s]."""
    arm_angles: Array
    """H, shape (n,) [rad]."""
    arm_rates: Array
    """Ḣ, shape (n,) [rad/s]."""
    tip_force: Array
    """Force of the tip on the door in the last physics step, shape (3,), world frame [N]."""
    tip_normal_force: float
    """Its share along n_D: positive when it opens the door [N]."""
    touching: bool
    """Whether the tip exerts a force on the leaf; always, where it grips."""
    max_pull: float
    """Largest pull on the door, against n_D, in any physics step since the last tick [N]."""
    collisions: int
    """Largest number of contacts other than tip and leaf in any physics step since the last tick."""
    collision_pairs: tuple[str, ...]
    """What these contacts were between."""
    only_tip_on_frame: bool
    """Whether all of them were the tip on what does not move."""
    rotor_thrusts: Array
    """Shape (m,) [N]."""
    max_push: float = 0.0
    """Largest push on the door, along n_D, in any physics step since the last tick [N]."""
    gripping: bool = False
    """Whether the gripper holds the leaf."""
    grip_slips: int = 0
    """How often it was torn off the leaf since the flight began."""
    outer_force: float = 0.0
    """Force of wind and of whatever acts on the vehicle besides rotors, air and leaf [N]."""

    def fields(self) -> dict[str, Any]:
        """Everything but the time, for a recorder; the pairs of collisions as one text."""
        values = vars(self).copy()
        del values["time"]
        values["collision_pairs"] = ", ".join(self.collision_pairs)
        return values
