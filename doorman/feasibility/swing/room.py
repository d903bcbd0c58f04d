r"""Room along the swing: how far the best level posture at every door angle stays from the constraints.

At door angle α, with the vehicle level, the room is :math:`\max_{\psi, H}\ -\max_i h_i(\psi, \alpha, H)` over any yaw ψ and
every arm posture H within its joint limits. It is found by sequential quadratic programming on the minimax problem, started
from the best posture of the neighbouring door angle: so a swing with room everywhere is also connected. Where that finds no
room, other starting postures are tried.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.model import Model
from doorman.postures.minimax import minimise_largest

ACTIVE = 1e-3
_SPACING = math.radians(5.0)
_RELATIVE_YAWS = (0.0, 0.6, -0.6, 1.2, -1.2)
_SEARCHED = 4
"""Starting points that are searched from, of all that are tried: those that violate least."""


@dataclass(frozen=True)
class Swing:
    """Best level postures from start to goal; m door angles."""

    door_angles: Array  # α, shape (m,) [rad]
    room: Array
    """Distance of the best posture from the nearest constraint, shape (m,) [m]; negative: no posture is allowed."""
    states: Array  # best postures x = [0, 0, ψ, α, 0, H], shape (m, 5 + n)
    connected: bool  # whether all postures follow from the start posture without a jump
    binding: tuple[tuple[int, ...], ...]  # rows of h that bind at each door angle

    @property
    def narrowest(self) -> int:
        """Index of the door angle with the least room."""
        return int(np.argmin(self.room))


def best_swing(model: Model, rows: NDArray[np.int64] | None = None) -> Swing:
    """Follow the best level posture from the start's door angle to the goal's."""
    rows = np.arange(model.n_constraints) if rows is None else rows
    start, goal = model.start_angle, model.goal_angle
    angles = np.linspace(start, goal, max(2, math.ceil(abs(goal - start) / _SPACING) + 1))
    state = model.start_state.copy()
    state[5:] = np.clip(state[5:], model.vehicle.lower_limits, model.vehicle.upper_limits)
    states, room, binding, connected = [], [], [], True
    for k, angle in enumerate(angles):
        turned = state.copy()
        turned[2:4] += angle - state[3]  # the posture relative to the leaf stays
        state, found = widest_posture(model, turned, rows)
        if found < 0.0:
            other, better = _elsewhere(model, turned, rows)
            if better > found + ACTIVE:
                connected = connected and k == 0 and better < 0.0
                state, found = other, better
        h = model.constraints(state)[rows]
        states.append(state)
        room.append(found)
        binding.append(tuple(int(row) for row in rows[h >= h.max() - ACTIVE]))
    return Swing(angles, np.array(room), np.array(states), connected, tuple(binding))


def widest_posture(model: Model, state: Array, rows: NDArray[np.int64]) -> tuple[Array, float]:
    """Locally best yaw and arm posture at a state's door angle."""
    free = np.array([2, *range(5, model.nx)])
    lower = np.concatenate([[-np.inf], model.vehicle.lower_limits])
    upper = np.concatenate([[np.inf], model.vehicle.upper_limits])

    def moved(point: Array) -> Array:
        posture = state.copy()
        posture[free] = point
        return posture

    best, largest = minimise_largest(
        lambda point: model.constraints(moved(point))[rows],
        lambda point: model.constraint_jacobian(moved(point))[np.ix_(rows, free)],
        state[free], lower, upper,
    )  # fmt: skip
    return moved(best), -largest


def _elsewhere(model: Model, state: Array, rows: NDArray[np.int64]) -> tuple[Array, float]:
    """Best posture from other starting points: arms of start and goal and between, at several yaws to the leaf."""
    normal, starts = model.door.heading(float(state[3])), []
    for share in (0.0, 0.5, 1.0):
        for yaw in _RELATIVE_YAWS:
            other = state.copy()
            other[2] = normal + yaw
            arm = (1.0 - share) * model.start_arm + share * model.goal_arm
            other[5:] = np.clip(arm, model.vehicle.lower_limits, model.vehicle.upper_limits)
            starts.append(other)
    deepest = model.constraints_along(np.array(starts))[:, rows].max(axis=1)
    found = [widest_posture(model, starts[k], rows) for k in np.argsort(deepest, kind="stable")[:_SEARCHED]]
    return max(found, key=lambda each: each[1])
