"""Plans at the leaf from what is known, and follows them: references, first states, commands."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.ocp.solvers.hybrid import Hybrid
from doorman.ocp.solvers.options import SolverOptions
from doorman.planning.whole_body_problem import (
    depth_of,
    stick_place,
    whole_body_numbers,
    whole_body_problem,
    whole_body_state,
)  # fmt: skip
from doorman.signals import Command
from suite.whole_body.belief import Known

Array = NDArray[np.float64]

_PERIOD = 0.02
"""Between plans [s]."""
_ITERATIONS = 1
_RAMP = 0.06
"""Growth of the opening rate that is asked for [rad/s²]."""
_AT_GOAL = 0.014
"""Within about this the door is held, and not opened [rad]."""
_HOLD_LEAST, _HOLD_SLACK, _HOLD_OPENING = 0.3, 0.5, 0.4
"""Of a held door: least force as a share of what it resists with, the share of its friction by which the force is less than that,
and the weight of its speed."""
_BRAKED, _LONGEST = 0.77, 0.5
"""The way in which a leaf slows down before the goal is this times ω²I/τ, as half of what resists must do, and at most the second
[rad]: of ω tanh(s/l) the deceleration is at most 0.385 ω²/l. No more than the other half may push meanwhile."""
_FREE_AIR = -0.004
"""Depth of a tip that does not touch, at most [m]."""
_ROOM = np.array([0.0, 0.0, 0.0, 0.03, 0.03, 0.03, 1e3, 1.0, 1.0])
"""By which rows are widened: three of the arm, three planes, force, speed and stopping. Noise moves a start across rows that
are tight, and plans of one iteration do not converge there; residuals keep the distance instead."""
_AHEAD = 0.06
"""The onboard loop turns the vehicle at the rate that the plan has so much later [s]."""
_MOST_TURN = 0.25
"""Largest lead of the commanded heading [rad]."""
_YAW_LOOP = 4.0
"""Of the onboard loop: rate by heading error [1/s]."""
_TOO_FAR = 2.0
"""A plan that leads farther has diverged [m]."""


class Pilot:
    """Plans and commands of one flight.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._first = whole_body_numbers(model)
        self.numbers: Numbers = self._first
        options = SolverOptions(largest_multiplier=100.0, hessian="gauss-newton", feasibility=2e-3)
        self._solver = Hybrid(whole_body_problem(model, self._first), options)
        self._plan: tuple[Array, Array] | None = None
        self._planned_at = self._next = 0.0
        self.opening_rate = 0.0
        """Asked for now [rad/s]."""
        self.solve_times: list[float] = []
        """Of all plans but the first [s]."""
        self.rejected = 0
        """Plans that diverged."""

    def forget(self) -> None:
        """Begin anew."""
        self._plan, self._next, self.opening_rate = None, 0.0, 0.0

    def command(self, now: float, known: Known, time_step: float, measured_yaw: float) -> Command:
        """Plan if it is time to, and follow the plan.

        Args:
            now: [s].
            known: What is known now.
            time_step: Since the last call [s].
            measured_yaw: ψ as the vehicle knows it [rad].
        """
        opening, most = -known.door_rate, self._first.one("reference.opening_speed")
        if known.touching:
            self.opening_rate = min(max(self.opening_rate, opening) + _RAMP * time_step, most)
        elif opening < self.opening_rate:
            self.opening_rate = max(opening, 0.0)
        if now >= self._next - 1e-9:
            self._next = now + _PERIOD
            self._make_plan(now, known)
        assert self._plan is not None
        states, inputs = self._plan
        step = self._first.one("plan.time_step")
        node = min(int((now - self._planned_at) / step + 1e-6), len(inputs) - 1)
        later = min(int((now - self._planned_at + _AHEAD) / step), len(inputs) - 1)
        planned = inputs[node]
        lead = float(np.clip(states[later + 1, 11] / _YAW_LOOP, -_MOST_TURN, _MOST_TURN))
        attitude = _tilted(planned[1], planned[2], lead)
        attitude[2] += measured_yaw
        return Command(float(planned[0]), attitude, np.array(planned[4:]), False)

    def _make_plan(self, now: float, known: Known) -> None:
        state, self.numbers = self._start(known)
        self._solver.update_parameters(self.numbers.vector)
        began = time.perf_counter()
        if self._plan is None:
            self._solver.run(state)
        else:
            self._solver.replan(state, _PERIOD, max_iterations=_ITERATIONS)
            self.solve_times.append(time.perf_counter() - began)
        states, inputs = self._solver.trajectory()
        sane = np.isfinite(states).all() and np.isfinite(inputs).all()
        if sane and np.abs(states[:, :3] - state[:3]).max() < _TOO_FAR:
            self._plan, self._planned_at = (states, inputs), now
        else:
            self.rejected += 1
            self._solver.run(state)
            if self._plan is None:
                self._plan, self._planned_at = self._solver.trajectory(), now

    def _start(self, known: Known) -> tuple[Array, Numbers]:
        """First state, with the tip as deep in the leaf as the estimated force says, and the numbers of the problem."""
        model, numbers = self._model, self._first
        normal = model.door.normal(known.door_angle)
        tip = known.position + rotation_body_to_world(known.attitude) @ model.vehicle.tip_position(known.arm_angles)
        contact = model.coupling.contact_point(known.door_angle) - known.face_offset * normal
        depth = float(normal @ (tip - contact))
        wanted = depth_of(known.normal_force, numbers) if known.touching else min(depth, _FREE_AIR)
        state = whole_body_state(
            known.position + (wanted - depth) * normal, known.attitude, known.velocity, known.attitude_rates,
            known.door_angle, known.door_rate, known.arm_angles,
        )  # fmt: skip
        place = np.array([model.door.leaf_direction(known.door_angle) @ (tip - contact), tip[2] - contact[2]])
        if known.touching:
            place = stick_place(place, known.friction_force, max(known.normal_force, 0.1), numbers)
        face = numbers["mechanism.point"] + known.face_offset * numbers["mechanism.normal"]
        felt = {"contact.stick": place, "vehicle.wind": known.wind, "mechanism.point": face}
        return state, numbers.replaced({**self._references(known), **felt})

    def _references(self, known: Known) -> dict[str, Any]:
        """What a tip that is to open the door, or to hold it at the goal, aims for."""
        left = known.door_angle - self._first.one("reference.joint")
        holds = 1.0 / (1.0 + math.exp(min((left - _AT_GOAL) / (0.4 * _AT_GOAL), 50.0)))
        steady = known.resistance / self._model.coupling.distance_from_hinge
        least, depth = min(self._first.one("reference.least_force"), 0.5 * steady), self._first.one("reference.depth")
        fastest, length = self._first.one("reference.opening_speed"), self._first.one("reference.opening_length")
        braked = _BRAKED * fastest**2 * known.inertia / known.resistance
        touch = float(known.touching)
        return {
            "mechanism.friction": known.friction_share * known.resistance,
            "mechanism.torque": -(1.0 - known.friction_share) * known.resistance,
            "mechanism.damping": 0.0, "mechanism.stiffness": 0.0, "mechanism.inertia": known.inertia,
            "limits.widened": _ROOM,
            "reference.depth": depth * (1.0 - holds),
            "reference.opening_speed": self.opening_rate,
            "reference.opening_length": min(max(braked, length), _LONGEST),
            "reference.force": steady * (1.0 - holds * _HOLD_SLACK * known.friction_share),
            "reference.least_force": (1.0 - holds) * least + holds * min(least, _HOLD_LEAST * steady),
            "weight.approach": 1000.0 - 400.0 * touch,
            "weight.opening": 100.0 * (1.0 - touch * holds * (1.0 - _HOLD_OPENING)),
            "weight.force": 0.2 * touch,
            "weight.least_force": 2.0 * touch,
        }  # fmt: skip


def _tilted(roll: float, pitch: float, yaw: float) -> Array:
    """Attitude with the thrust's direction of [roll, pitch, 0], and another heading.

    Args:
        roll: φ at ψ = 0 [rad].
        pitch: θ at ψ = 0 [rad].
        yaw: ψ [rad].

    Returns:
        Φ, shape (3,) [rad].
    """
    up = np.array([math.sin(pitch) * math.cos(roll), -math.sin(roll), math.cos(pitch) * math.cos(roll)])
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, aside = c * up[0] + s * up[1], -s * up[0] + c * up[1]
    return np.array([-math.asin(min(max(aside, -1.0), 1.0)), math.atan2(ahead, up[2]), yaw])
