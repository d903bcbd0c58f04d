"""Findings from the rehearsal: where the door ends, and what the motion asks of arm, rotors, contact and clearance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from doorman.arrays import Array
from doorman.collision.audit import TOLERANCE, clearances_at
from doorman.collision.scene import CollisionScene
from doorman.feasibility.inputs.setup import joint_margin
from doorman.feasibility.lift import weight_on_joints
from doorman.feasibility.report import Finding, Severity, found, near, warning_if
from doorman.feasibility.swing.geometry import inertia_in_words, shortest_swing
from doorman.feasibility.swing.rehearsal import STANDS, Rehearsal, least_resistance
from doorman.feasibility.swing.room import ACTIVE
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.planning.grip.push import rotor_force
from doorman.planning.pace import LONGEST, OPEN, Pace, duration_held
from doorman.planning.whole_body.references import BRAKES

LARGEST_ERROR = math.radians(1.2)
"""Largest error of the door's angle at the end of a rehearsal [rad]: flights end within 0.3° of their rehearsals."""

_JOINT_SLACK = 0.02
_PULL_SLACK = 0.05
_EVERY, _EVERY_TENTH = 0.05, 10
_HEIGHT, _HEIGHT_TIED = 0.01, 0.05
"""By which a vehicle is higher or lower than planned, by flight: a tied tip lifts and lowers it [m]."""


def flight_findings(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """What a rehearsed motion shows."""
    return [
        _goal(model, rehearsal),
        *(_arm(model, rehearsal) if model.n_arm else []),
        *_attitude(model, rehearsal),
        _pull(model, rehearsal),
        *stopping_findings(model),
        *duration_findings(model),
        *_clearances(model, rehearsal),
    ]


def _goal(model: Model, rehearsal: Rehearsal) -> Finding:
    """Where the planner takes the door."""
    door, target, final = model.door, model.goal_angle, rehearsal.final_door_angle
    error, limit = abs(final - target), OPEN if door.in_plane else LARGEST_ERROR
    ok = not rehearsal.failure and error <= limit
    message = (
        f"rehearsed without noise or tracking error for {rehearsal.times[-1]:.1f} s, the door ends at {door.in_words(final)}, "
        f"{door.way_in_words(error)} from the goal"
    )
    within = rehearsal.time_within(target, OPEN)
    if rehearsal.failure:
        message += f"; the motion ends there: {rehearsal.failure}"
    elif within is not None:
        message += f", and is within {door.way_in_words(OPEN)} of it from {within:.1f} s on"
    return found("goal reached", ok, message, error, limit, "rad", "" if ok else _why_not_reached(model, rehearsal))


def _why_not_reached(model: Model, rehearsal: Rehearsal) -> str:
    """What to change: the constraints that are active at the end, what the hinge resists with, the leaf's inertia, or weights."""
    door, state = model.door, rehearsal.states[-1]
    h = model.constraints(state) + model.scenario.planner.margin
    active = [f"'{model.constraint_names[k]}'" for k in np.flatnonzero(h > -ACTIVE)]
    if active:
        return (
            f"the motion ends at {' and '.join(active)}: change goal.attitude, goal.arm or goal.door_angle to keep them"
        )
    least = shortest_swing(model)
    if least > 0.5 * rehearsal.times[-1]:
        return (
            f"the leaf's {inertia_in_words(model)} take {least:.0f} s at the largest push: use a lighter leaf, "
            "a larger contact.distance_from_hinge or a larger control.max_tilt"
        )
    if abs(state[4]) > STANDS:
        return (
            "the door still moves: raise the weight of the door angle in planner.weights, or lower those of the inputs"
        )
    sense = math.copysign(1.0, model.goal_angle - float(state[3]))
    torques = {"friction": door.friction, "spring": sense * door.stiffness * (float(state[3]) - door.rest_angle)}
    resists = " and ".join(
        f"{name} of {door.torque_in_words(torque)}" for name, torque in torques.items() if torque > 0.0
    )
    against = f" against the hinge's {resists}" if resists else ""
    return (
        f"the door stands still{against}: raise the weight of the door angle in planner.weights.state, or lower those of "
        "roll, pitch and yaw"
    )


def _arm(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """Joint limits, which the planner does not know, rates and torques; a limit of 0 in the URDF means none is given."""
    vehicle, margin = model.vehicle, joint_margin(model, rehearsal.states[:, 5:])
    rates = np.abs(rehearsal.inputs[:, 4 : 4 + model.n_arm]).max(axis=0)
    torques = np.max([_joint_torques(model, *moment) for moment in _every(model, rehearsal)], axis=0)
    torque_units = ["N" if slides else "N m" for slides in vehicle.slides]
    return [
        found(
            "joint limits along the swing", margin.inside >= -_JOINT_SLACK,
            f"joint {margin.joint} comes nearest to its limits: {margin.size} {'inside' if margin.inside >= 0.0 else 'outside'}",
            margin.inside, 0.0, margin.unit, f"move start.arm and goal.arm of joint {margin.joint} farther from its limits",
        ),
        _largest(
            model, "servo rates", rates, vehicle.rate_limits, [f"{unit}/s" for unit in vehicle.angle_units],
            "joint {0} moves at up to {1}",
            "choose a start that keeps the constraints, or raise planner.weights.input of the joints",
        ),
        _largest(
            model, "servo torques", torques, vehicle.torque_limits, torque_units,
            "the force on the door and the arm's weight load joint {0} with up to {1}",
            "use stronger servos, or raise planner.weights on roll, pitch and thrust",
        ),
    ]  # fmt: skip


def _largest(
    model: Model, name: str, values: Array, given: Array, units: Sequence[str], words: str, advice: str
) -> Finding:
    """The joint that comes nearest to a limit of its servo, or passes it."""
    limits = np.where(given > 0.0, given, np.inf)
    k = int(np.argmax(values / limits))
    value, limit, joint = float(values[k]), float(limits[k]), model.vehicle.joint_names[k]
    message = words.format(joint, f"{value:.2f} {units[k]} of {limit:.2f}")
    return found(name, value <= limit, message, value, limit, units[k], advice, Severity.WARNING)


def _joint_torques(model: Model, state: Array, inputs: Array) -> Array:
    r"""Torques of the arm's own weight, and :math:`J_d^T R^T F_R` of the force on the door :math:`F_R = f_t R e_3 - m g e_3`."""
    rotation = rotation_body_to_world(state[:3])
    force = rotation @ rotor_force(inputs, model.n_arm) - np.array([0.0, 0.0, model.vehicle.weight])
    by_force = model.vehicle.tip_jacobian(state[5:]).T @ rotation.T @ force
    return np.asarray(np.abs(by_force) + np.abs(weight_on_joints(model, state)))


def _attitude(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """Tilt against the controller's limit, which the planner does not know, and thrust against what the rotors give."""
    roll, pitch = rehearsal.states[:, 0], rehearsal.states[:, 1]
    tilt = float(np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1.0, 1.0)).max())
    thrust, most, steepest = (
        float(rehearsal.inputs[:, 0].max()),
        model.vehicle.max_thrust,
        model.scenario.control.max_tilt,
    )
    return [
        found(
            "tilt", tilt <= steepest, f"the plan tilts by up to {math.degrees(tilt):.1f}° of {math.degrees(steepest):.1f}°",
            tilt, steepest, "rad", "raise control.max_tilt, or planner.weights on roll, pitch and door rate", Severity.WARNING,
        ),
        found(
            "thrust", thrust <= most, f"the plan asks for up to {thrust:.1f} N of {most:.1f} N", thrust, most, "N",
            "use stronger rotors (vehicle.max_thrust), or raise the weight on the thrust", Severity.WARNING,
        ),
    ]  # fmt: skip


def _pull(model: Model, rehearsal: Rehearsal) -> Finding:
    """Force that pulls the leaf towards the vehicle, against what the tip can pull with: one that only presses loses the door."""
    pull, most = max(0.0, -float(rehearsal.normal_forces.min())), model.contact.pull + _PULL_SLACK
    ok = pull <= most
    how = "the contact can do that" if ok else "the tip cannot, and loses the door there"
    return found(
        "pull on the door", ok, f"the plan pulls by up to {pull:.1f} N to brake the door; {how}", pull, most, "N",
        'set contact.kind = "grip", or use a hinge whose friction and damping brake the door',
    )  # fmt: skip


def stopping_findings(model: Model) -> list[Finding]:
    """A tip that cannot pull needs a joint that stops the leaf: the speed from which it does, at the start."""
    if model.contact.pull > 0.0:
        return []
    torque, door, longest = least_resistance(model), model.door, model.scenario.mission.time_out.open
    takes, known = _least_duration(model), model.friction.known
    usual = "" if known else " (unknown: the least of a usual hinge)"
    possible = takes <= longest or _ends_at_its_stop(model)
    message = f"against {door.torque_in_words(torque)}{usual} the door stops by itself at the goal, {takes:.0f} s after the touch"
    if torque <= 0.0:
        message = f"weight or spring drive it on with {door.torque_in_words(-torque)} beyond its friction{usual}"
    advice = 'set contact.kind = "grip": pushing cannot stop a door without resistance'
    if possible:
        advice = (
            f"write what the hinge has into door.friction [{'N' if door.slides else 'N m'}]: a leaf with less goes on"
        )
    ok = possible and known
    return [found("door can be stopped", ok, message, takes, longest, "s", advice, warning_if(possible))]


def _least_duration(model: Model) -> float:
    """Least time from the touch until a leaf is open, which the tip's pull or its own hinge stops [s]."""
    if model.scenario.planner.model != "whole_body":
        return duration_held(model)
    by_hinge = BRAKES * least_resistance(model) / model.door.inertia
    deceleration = math.inf if model.contact.pull > 0.0 else by_hinge
    return Pace.of(model, safe=True).duration(model.travel.length, deceleration) if deceleration > 0.0 else LONGEST


def duration_findings(model: Model) -> list[Finding]:
    """Whether a wanted duration is possible; nothing where the task is to be as fast as is safe."""
    wanted = model.scenario.goal.duration
    if wanted == "safe":
        return []
    least = _least_duration(model)
    ok = least <= wanted
    how = "possible" if ok else "not possible: the flight is as fast as is safe"
    return [found(
        "duration", ok, f"{wanted:.1f} s from the touch to the goal are {how}; the least is about {least:.1f} s", wanted,
        least, "s", f'set goal.duration to {math.ceil(least):d} or more, or to "safe"', Severity.WARNING,
    )]  # fmt: skip


def _ends_at_its_stop(model: Model) -> bool:
    """Whether the goal is where the joint ends, which stops the leaf there."""
    beyond = {-1.0: model.travel.goal - model.door.lower_limit, 1.0: model.door.upper_limit - model.travel.goal}
    return beyond[model.travel.sense] < LARGEST_ERROR


def _clearances(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """Exact distance of all shapes but tip and leaf along the rehearsal, there and a little higher and lower."""
    states = np.array([state for state, _ in _every(model, rehearsal)])
    scene = CollisionScene(model.vehicle, model.door)
    worst = clearances_at(scene, model.coupling, states).worst
    ok = worst.distance > -TOLERANCE
    finding = found(
        "clearance along the swing", ok, near(worst), worst.distance, -TOLERANCE, "m",
        "raise planner.margin; against elbow or sill, which the constraints do not know, change "
        "contact.height, start.arm or goal.arm",
    )  # fmt: skip
    return [finding, *([_height(model, scene, states[::_EVERY_TENTH])] if ok else [])]


def _height(model: Model, scene: CollisionScene, states: Array) -> Finding:
    """Room above and below: a vehicle that is tied to the leaf by its tip rises and sinks as it tilts."""
    positions = np.array([model.coupling.vehicle_position(x[:3], float(x[3]), x[5:]) for x in states])
    rotations = np.array([rotation_body_to_world(x[:3]) for x in states])
    height = model.contact.between(_HEIGHT, _HEIGHT_TIED)
    worst = min(
        (
            scene.min_clearance_along(positions + [0.0, 0.0, off], rotations, states[:, 5:], states[:, 3]).worst
            for off in (height, -height)
        ),
        key=lambda clearance: clearance.distance,
    )
    return found(
        "height in the doorway", worst.distance > -TOLERANCE,
        f"with the vehicle {1e2 * height:.0f} cm higher or lower, {near(worst)}", worst.distance, -TOLERANCE, "m",
        "choose another contact.height, or a start.arm and goal.arm that hold the tip lower or higher",
    )  # fmt: skip


def _every(model: Model, rehearsal: Rehearsal) -> list[tuple[Array, Array]]:
    """States and inputs of the rehearsal every 0.05 s."""
    stride = max(1, round(_EVERY / model.scenario.planner.time_step))
    return list(zip(rehearsal.states[::stride], rehearsal.inputs[::stride], strict=True))
