"""The way out of the doorway, back to a hover before the door."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doorman.control.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.motion import Glide, arm_rates_to, in_the_doorway, way_out
from doorman.model import Model

_PRESSED = 0.3
"""A vehicle that a leaf follows, or keeps from a place on its way out, for so long [s] goes straight out."""


class Retreat:
    """Back from the leaf, out of the doorway, then into the start's posture.

    In the doorway heading and arm keep step with the leaf: one that shuts meets the tip, and not the rotors.

    Args:
        model: Model of the scenario.
        estimate: Where it begins.
    """

    def __init__(self, model: Model, estimate: Estimate) -> None:
        self._model = model
        self.glide = Glide(estimate.position, float(estimate.state[2]))
        """What the vehicle follows."""
        self._targets = way_out(model, estimate.position, estimate.door_angle)
        self._blocked_at: float | None = None

    def stay(self, estimate: Estimate) -> None:
        """Go no farther than the vehicle is now."""
        self._targets = [estimate.position]

    def speed_from_leaf(self, estimate: Estimate) -> float:
        """Speed with which the reference goes back from the leaf [m/s]."""
        return max(0.0, -float(self.glide.velocity @ self._model.door.normal(estimate.door_angle)))

    def step(self, estimate: Estimate, time_step: float) -> tuple[Setpoint, bool]:
        """Go on, once per tick.

        Args:
            estimate: What is known now.
            time_step: Since the last call [s].

        Returns:
            What to do, and whether the vehicle has arrived before the door.
        """
        target, outside = self._targets[0], len(self._targets) == 1
        within = in_the_doorway(self._model, estimate.position)
        meets = max(estimate.tip_angle, estimate.door_angle)
        near_wall = self._model.door.side == "pull"  # the arm, turned back, would sweep along it
        posture = self._model.on_the_way(meets) if within or near_wall else self._model.start_state
        rates = arm_rates_to(np.asarray(posture[5:]), estimate.arm_angles)
        speed = self._model.scenario.mission.retreat_speed
        setpoint = self.glide.to(target, float(posture[2]), speed, rates, time_step)
        followed = within and estimate.touching
        if followed:  # gives way backwards only: beside it are the jambs
            setpoint = replace(setpoint, force=np.array([0.0, float(estimate.tip_force[1]), 0.0]))
        near = self.glide.near(target, 0.02)
        if outside or not (near or followed):
            self._blocked_at = None
        elif self._blocked_at is None:
            self._blocked_at = estimate.time
        pressed = self._blocked_at is not None and estimate.time - self._blocked_at >= _PRESSED
        arrived = pressed or (near and bool(np.linalg.norm(estimate.position - target) < 0.1))
        if arrived and not outside:
            self._targets.pop(0)
        return setpoint, arrived and outside
