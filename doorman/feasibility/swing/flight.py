"""Findings from the rehearsal: where the door ends, and what the motion asks of arm, rotors, contact and clearance."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.collision.audit import TOLERANCE, clearances_at
from doorman.collision.scene import Clearance, CollisionScene
from doorman.feasibility.inputs.setup import joint_margin
from doorman.feasibility.lift import weight_on_joints
from doorman.feasibility.report import Finding, Severity, graded
from doorman.feasibility.swing.geometry import inertia_in_words, shortest_swing
from doorman.feasibility.swing.rehearsal import Rehearsal, least_resistance
from doorman.feasibility.swing.room import ACTIVE
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.planning.grip.push import rotor_force
from doorman.planning.pace import LONGEST, Pace, duration_held
from doorman.planning.whole_body.references import BRAKES

LARGEST_ERROR = math.radians(1.2)
"""Largest error of the door's angle at the end of a rehearsal [rad]: flights end within 0.3° of their rehearsals."""

_OPEN = math.radians(2.0)
_JOINT_SLACK = 0.02
_PULL_SLACK = 0.05
_EVERY, _EVERY_TENTH = 0.05, 10
_HEIGHT, _HEIGHT_TIED = 0.01, 0.05
"""By which a vehicle is higher or lower than planned, by flight: a tied tip lifts and lowers it [m]."""
_AT_REST = 0.01


def flight_findings(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """What a rehearsed motion shows."""
    return [
        _goal(model, rehearsal),
        *([_joints(model, rehearsal), _rates(model, rehearsal)] if model.n_arm else []),
        _tilt(model, rehearsal),
        _thrust(model, rehearsal),
        *_forces(model, rehearsal),
        *stopping_findings(model),
        *duration_findings(model),
        *_clearances(model, rehearsal),
    ]


def _goal(model: Model, rehearsal: Rehearsal) -> Finding:
    """Where the planner takes the door."""
    target = model.goal_angle
    error, limit = abs(rehearsal.final_door_angle - target), _OPEN if model.door.in_plane else LARGEST_ERROR
    ok = not rehearsal.failure and error <= limit
    door = model.door
    ends = f"the door ends at {door.in_words(rehearsal.final_door_angle)}, {door.way_in_words(error)} from the goal"
    message = f"rehearsed without noise or tracking error for {rehearsal.times[-1]:.1f} s, {ends}"
    within = rehearsal.time_within(target, _OPEN)
    if rehearsal.failure:
        message += f"; the motion ends there: {rehearsal.failure}"
    elif within is not None:
        message += f", and is within {door.way_in_words(_OPEN)} of it from {within:.1f} s on"
    return Finding(
        "goal reached", graded(ok), message, error, limit, "rad",
        "" if ok else _why_not_reached(model, rehearsal),
    )  # fmt: skip


def _why_not_reached(model: Model, rehearsal: Rehearsal) -> str:
    """What to change: the constraints that are active at the end, what the hinge resists with, the leaf's inertia, or weights."""
    state, target = rehearsal.states[-1], model.goal_angle
    h = model.constraints(state) + model.scenario.planner.margin
    active = [f"'{model.constraint_names[k]}'" for k in np.flatnonzero(h > -ACTIVE)]
    if active:
        return (
            f"the motion ends at {' and '.join(active)}: change goal.attitude, goal.arm or goal.door_angle to keep them"
        )
    least, pushed = shortest_swing(model), inertia_in_words(model)
    if least > 0.5 * rehearsal.times[-1]:
        return (
            f"the leaf's {pushed} take {least:.0f} s at the largest push: use a lighter leaf, "
            "a larger contact.distance_from_hinge or a larger control.max_tilt"
        )
    if abs(state[4]) > _AT_REST:
        return (
            "the door still moves: raise the weight of the door angle in planner.weights, or lower those of the inputs"
        )
    sense = math.copysign(1.0, target - float(state[3]))
    torques = {
        "friction": model.door.friction,
        "spring": sense * model.door.stiffness * (float(state[3]) - model.door.rest_angle),
    }
    against = [f"{name} of {model.door.torque_in_words(torque)}" for name, torque in torques.items() if torque > 0.0]
    reason = (
        f"the door stands still against the hinge's {' and '.join(against)}" if against else "the door stands still"
    )
    return (
        f"{reason}: raise the weight of the door angle in planner.weights.state, or lower those of roll, pitch and yaw"
    )


def _joints(model: Model, rehearsal: Rehearsal) -> Finding:
    """Arm along the rehearsal against the joint limits, which the planner does not know."""
    margin = joint_margin(model, rehearsal.states[:, 5:])
    joint, inside = margin.joint, margin.inside
    ok = inside >= -_JOINT_SLACK
    return Finding(
        "joint limits along the swing", graded(ok),
        f"joint {joint} comes nearest to its limits: {margin.size} {'inside' if inside >= 0.0 else 'outside'}",
        inside, 0.0, margin.unit, "" if ok else f"move start.arm and goal.arm of joint {joint} farther from its limits",
    )  # fmt: skip


def _rates(model: Model, rehearsal: Rehearsal) -> Finding:
    """Joint rates along the rehearsal against what the servos can do; a limit of 0 in the URDF means none is given."""
    rates, limits = np.abs(rehearsal.inputs[:, 4 : 4 + model.n_arm]).max(axis=0), _given(model.vehicle.rate_limits)
    worst = int(np.argmax(rates / limits))
    unit = f"{model.vehicle.angle_units[worst]}/s"
    ok = bool(rates[worst] <= limits[worst])
    return Finding(
        "servo rates", graded(ok, Severity.WARNING),
        f"joint {model.vehicle.joint_names[worst]} moves at up to {rates[worst]:.2f} {unit} of {limits[worst]:.2f}",
        float(rates[worst]), float(limits[worst]), unit,
        "" if ok else "choose a start that keeps the constraints, or raise planner.weights.input of the joints",
    )  # fmt: skip


def _tilt(model: Model, rehearsal: Rehearsal) -> Finding:
    """Tilt along the rehearsal against the controller's limit, which the planner does not know."""
    roll, pitch = rehearsal.states[:, 0], rehearsal.states[:, 1]
    tilt = float(np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1.0, 1.0)).max())
    limit = model.scenario.control.max_tilt
    ok = tilt <= limit
    return Finding(
        "tilt", graded(ok, Severity.WARNING),
        f"the plan tilts by up to {math.degrees(tilt):.1f}° of {math.degrees(limit):.1f}°", tilt, limit, "rad",
        "" if ok else "raise control.max_tilt, or planner.weights on roll, pitch and door rate",
    )  # fmt: skip


def _thrust(model: Model, rehearsal: Rehearsal) -> Finding:
    """Thrust along the rehearsal against what the rotors give."""
    thrust, limit = float(rehearsal.inputs[:, 0].max()), model.vehicle.max_thrust
    ok = thrust <= limit
    return Finding(
        "thrust", graded(ok, Severity.WARNING),
        f"the plan asks for up to {thrust:.1f} N of {limit:.1f} N", thrust, limit, "N",
        "" if ok else "use stronger rotors (vehicle.max_thrust), or raise the weight on the thrust",
    )  # fmt: skip


def _forces(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    r"""Force on the door: its pull, and of :math:`F_R = f_t R e_3 - m g e_3` the servo torques."""
    # These are :math:`J_d^T R^T F_R` and the torques of the arm's own weight.
    torques = []
    for state, inputs in _every(model, rehearsal):
        rotation = rotation_body_to_world(state[:3])
        force = rotation @ rotor_force(inputs, model.n_arm) - np.array([0.0, 0.0, model.vehicle.weight])
        by_force = model.vehicle.tip_jacobian(state[5:]).T @ rotation.T @ force
        torques.append(np.abs(by_force) + np.abs(weight_on_joints(model, state)))
    pull = _pull(model, max(0.0, -float(rehearsal.normal_forces.min())))
    return [_servo_torques(model, np.max(torques, axis=0)), pull] if model.n_arm else [pull]


def _servo_torques(model: Model, torques: Array) -> Finding:
    limits = _given(model.vehicle.torque_limits)
    worst = int(np.argmax(torques / limits))
    unit = "N" if model.vehicle.slides[worst] else "N m"
    ok = bool(torques[worst] <= limits[worst])
    return Finding(
        "servo torques", graded(ok, Severity.WARNING),
        f"the force on the door and the arm's weight load joint {model.vehicle.joint_names[worst]} with up to "
        f"{torques[worst]:.2f} {unit} of {limits[worst]:.2f}",
        float(torques[worst]), float(limits[worst]), unit,
        "" if ok else "use stronger servos, or raise planner.weights on roll, pitch and thrust",
    )  # fmt: skip


def _pull(model: Model, pull: float) -> Finding:
    """Force that pulls the leaf towards the vehicle, against what the tip can pull with: one that only presses loses the door."""
    most = model.contact.pull + _PULL_SLACK
    ok = pull <= most
    how = "the contact can do that" if ok else "the tip cannot, and loses the door there"
    return Finding(
        "pull on the door", graded(ok), f"the plan pulls by up to {pull:.1f} N to brake the door; {how}", pull, most, "N",
        "" if ok else 'set contact.kind = "grip", or use a hinge whose friction and damping brake the door',
    )  # fmt: skip


def stopping_findings(model: Model) -> list[Finding]:
    """A tip that cannot pull needs a joint that stops the leaf: the speed from which it does, at the start."""
    if model.contact.pull > 0.0:
        return []
    torque, door, longest = least_resistance(model), model.door, model.scenario.mission.time_out.open
    takes = _least_duration(model)
    ok = takes <= longest or _ends_at_its_stop(model)
    known = "" if model.friction.known else " (unknown: the least of a usual hinge)"
    words = f"against {door.torque_in_words(torque)}{known} the door stops by itself at the goal, {takes:.0f} s after the touch"
    if torque <= 0.0:
        words = f"weight or spring drive it on with {door.torque_in_words(-torque)} beyond its friction{known}"
    advice = "" if ok else 'set contact.kind = "grip": pushing cannot stop a door without resistance'
    if ok and known:
        advice = (
            f"write what the hinge has into door.friction [{'N' if door.slides else 'N m'}]: a leaf with less goes on"
        )
    return [
        Finding(
            "door can be stopped", graded(not advice, Severity.WARNING if ok else Severity.ERROR), words, takes, longest, "s",
            advice,
        )
    ]  # fmt: skip


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
    return [
        Finding(
            "duration", graded(ok, Severity.WARNING),
            f"{wanted:.1f} s from the touch to the goal are {how}; the least is about {least:.1f} s", wanted, least, "s",
            "" if ok else f'set goal.duration to {math.ceil(least):d} or more, or to "safe"',
        )
    ]  # fmt: skip


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
    finding = Finding(
        "clearance along the swing", graded(ok), _near(worst), worst.distance, -TOLERANCE, "m",
        "" if ok else "raise planner.margin; against elbow or sill, which the constraints do not know, change "
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
    ok = worst.distance > -TOLERANCE
    return Finding(
        "height in the doorway", graded(ok), f"with the vehicle {1e2 * height:.0f} cm higher or lower, {_near(worst)}",
        worst.distance, -TOLERANCE, "m",
        "" if ok else "choose another contact.height, or a start.arm and goal.arm that hold the tip lower or higher",
    )  # fmt: skip


def _near(worst: Clearance) -> str:
    how = "come as near as" if worst.distance > 0.0 else "overlap by"
    return f"{worst.first} and {worst.second} {how} {1e3 * abs(worst.distance):.1f} mm"


def _given(limits: Array) -> Array:
    return np.where(limits > 0.0, limits, np.inf)


def _every(model: Model, rehearsal: Rehearsal) -> list[tuple[Array, Array]]:
    """States and inputs of the rehearsal every 0.05 s."""
    stride = max(1, round(_EVERY / model.scenario.planner.time_step))
    return list(zip(rehearsal.states[::stride], rehearsal.inputs[::stride], strict=True))
