"""Rehearsal: the planner in closed loop with a model of the swing, without noise, delay or tracking error.

What the planner makes of a task is more than geometry: its weights pull towards the goal's posture, and where the goal itself
is out of bounds it settles on a compromise. Whether the compromise still opens the door is a property of weights and
constraints together; running the loop answers it. The motion is that of `PlanningModel.swing`: of the planner's own model,
with the inertia that the push really moves. The hinge's friction is a torque against the swing that the planner knows of, as
in flight, where an observer finds it: what it costs in force, and so in tilt and in room beside the leaf, is in the answer.
A tip that can only push needs resistance: where no file names a friction, rehearsal and plant have that of a usual hinge. A grip
begins where the tug by which it is tried leaves the leaf.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.control.tug import drawn_by_the_tug
from doorman.exceptions import SingularityError
from doorman.feasibility.resting import torques_at_rest
from doorman.model import Model
from doorman.planning.grip.push import push_state
from doorman.planning.planner import Planner
from doorman.planning.planning_model import planning_model
from doorman.scenario.sections.estimation import USUAL_HINGE

DURATION, LONGEST = 12.0, 30.0
"""Shortest rehearsal, and longest; in between it ends when the door rests at the goal [s]."""

STANDS = 0.03
"""A leaf that is slower stands [rad/s]."""
_AJAR, _HOLDS = 0.02, 1.1
"""A leaf that begins farther open [rad] has so many times the friction that holds it there."""
_ALONG_THE_WAY = 20
"""Angles of the way at which the least resistance is looked for."""
_AT_GOAL, _RESTS = math.radians(1.0), 5e-4
"""A door so near to the goal is at rest there if it is slower [rad], [rad/s]: it moves on by some tenths of a degree."""
_FASTEST_DOOR = 20.0
"""Door rate at which a rehearsal is given up [rad/s]."""


def scaled(duration: float, model: Model) -> float:
    """A duration for a vehicle that may be larger, and slower by that, than the shipped one."""
    return duration * max(model.scale.time, 1.0)


@dataclass(frozen=True)
class Rehearsal:
    """Motion of the rehearsal; m states."""

    times: Array  # shape (m,) [s]
    states: Array  # reduced, [Φ, α, α̇, H], shape (m, 5 + n)
    inputs: Array  # reduced, [f_t, Ω, Ḣ_d], at each state, shape (m, 4 + n); the last is repeated
    normal_forces: Array
    """Force of the tip on the leaf along its normal, by the planner's model, at each state, shape (m,) [N]."""
    failure: str  # why the rehearsal broke off; empty if it ran to its end

    @property
    def final_door_angle(self) -> float:
        """α at the end [rad]."""
        return float(self.states[-1, 3])

    def time_within(self, target: float, tolerance: float) -> float | None:
        """First time after which α stays within a tolerance of a target."""
        off = np.flatnonzero(np.abs(self.states[:, 3] - target) > tolerance)
        if len(off) == 0:
            return 0.0
        return float(self.times[off[-1] + 1]) if off[-1] + 1 < len(self.times) else None


def resistance(model: Model) -> float:
    """Friction that a rehearsal assumes in the joint: that of the plant, where the planner knows none [N m]."""
    return _assumed(model, model.door.friction or model.hinge_scale * USUAL_HINGE["friction"][0])


def stopping_friction(model: Model) -> float:
    """Friction on which a stop can count [N m]."""
    return _assumed(model, min(model.friction.least, model.door.friction or math.inf))


def _assumed(model: Model, friction: float) -> float:
    """Friction that a tip which cannot pull counts on where no file names one; a leaf that begins ajar is held by what it has."""
    if model.contact.pull > 0.0:
        return model.door.friction
    ajar = model.door.opening_of(model.travel.start) > model.door.per_angle * _AJAR and not model.door.friction
    return max(friction, _HOLDS * abs(model.door.hinge_torque(model.travel.start, 0.0)) if ajar else 0.0)


def least_resistance(model: Model) -> float:
    """Least torque that friction, closer and weight make against the way to the goal, negative where they drive the leaf on."""
    travel = model.travel
    way = np.linspace(travel.start, travel.goal, _ALONG_THE_WAY)
    return stopping_friction(model) + min(travel.ahead(model.door.hinge_torque(float(angle), 0.0)) for angle in way)


def _begun(model: Model) -> Array:
    """The start, with the attitude that presses on a leaf which the tip may not pull, and where a tug leaves one that it may."""
    press = (1.0 - model.contact.tied) * resistance(model) / model.coupling.lever_length
    state = push_state(model, model.start_state, press).copy()
    state[3:5] += drawn_by_the_tug(model, *torques_at_rest(model, model.start_angle))
    return state


def rehearse(model: Model, duration: float | None = None) -> Rehearsal:
    """Run the planner on a model of the swing, one plan each time step."""
    # As in flight, a plan that may not be flown is dropped, and the last good one followed to its end.
    planner = Planner(model)
    against = math.copysign(resistance(model), model.goal_angle - model.start_angle)
    against += model.door.closing_torque
    planner.update_door(friction=0.0, disturbance=against)
    planning = planning_model(model)
    swing = planning.swing(against)
    time_step = model.scenario.planner.time_step
    least = scaled(DURATION, model) if duration is None else duration
    duration = scaled(LONGEST, model) if duration is None else duration
    states, inputs = [planning.state(_begun(model), np.zeros(3))], []
    flown, ahead, failure = None, 0, ""
    for _ in range(max(1, math.ceil(duration / time_step))):
        try:
            plan = planner.plan(states[-1]) if flown is None else planner.replan(states[-1], elapsed=time_step)
        except SingularityError as error:
            failure = str(error)
            break
        flown, ahead = (plan, 0) if plan.flyable else (flown, ahead + 1)
        if flown is None or ahead >= len(flown.inputs):
            failure = f"no plan that may be flown ({plan.status.value})"
            break
        following = swing(states[-1], flown.inputs[ahead])
        door_angle, door_rate = planning.reduced(following, flown.inputs[ahead])[0][3:5]
        if not np.isfinite(following).all() or abs(door_rate) > _FASTEST_DOOR:
            failure = "the motion diverges"
            break
        states.append(following)
        inputs.append(flown.inputs[ahead])
        rests = abs(door_angle - model.goal_angle) < _AT_GOAL and abs(door_rate) < _RESTS
        if rests and len(inputs) * time_step >= least - 0.5 * time_step:
            break
    inputs.append(inputs[-1] if inputs else planning.hover_input)
    times = np.arange(len(states), dtype=np.float64) * time_step
    moved, acted = np.array(states), np.array(inputs)
    forces = planning.normal_forces(planning.numbers, moved, acted)
    return Rehearsal(times, *planning.reduced(moved, acted), forces, failure)
