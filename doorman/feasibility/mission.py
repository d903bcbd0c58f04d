"""Findings about the mission around the swing: what would make it give up before the leaf, at it, or as it lets go."""

from __future__ import annotations

import math

import numpy as np

from doorman.collision.audit import TOLERANCE
from doorman.collision.scene import CollisionScene
from doorman.control.doorway import NO_GAP, Doorway
from doorman.feasibility.lift import FIRST_TURN
from doorman.feasibility.report import SPARE, Finding, found, near, warning_if
from doorman.feasibility.resting import torques_at_rest
from doorman.feasibility.swing.rehearsal import STANDS, Rehearsal
from doorman.kinematics.coupling import ROOM_TO_LEVEL
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.planning.limits import largest_push

_LEAST_WAY = math.radians(1.5)
"""A shorter way is none: the mission takes such a door for one that is open [rad]."""
_LENIENCE = 0.003
"""By which a flight ends farther from a jamb than its rehearsal: it passes the goal by some tenths of a degree [m]."""
_BETWEEN = 0.02
"""Between places on the way to the leaf at which the clearance is measured [m]."""


def mission_findings(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """Whether the mission comes to the leaf, stays at it and lets go of it."""
    return [
        _direction(model),
        _approach(model),
        _room_at_touch(model),
        *_room_to_level(model, rehearsal),
        *stays_at_the_start(model),
        _true_hinge(model),
    ]


def _direction(model: Model) -> Finding:
    """Towards the vehicle the leaf moves only where the tip can pull."""
    travel, door = model.travel, model.door
    away, opens = -travel.sense * travel.length, door.opening_of(travel.goal) > door.opening_of(travel.start)
    far, towards = travel.length > _LEAST_WAY, away < 0.0 and model.contact.pull <= 0.0
    message = (
        f"from {door.in_words(travel.start)} to {door.in_words(travel.goal)} the task {'opens' if opens else 'closes'} the "
        f"door by {door.way_in_words(travel.length)}"
    )
    other = "pull" if door.side == "push" else "push"
    advice = (
        f'set contact.side = "{other}", from where a push {"opens" if opens else "shuts"} it, or contact.kind = "grip"'
    )
    if not far:
        message += f"; the mission counts the last {door.way_in_words(_LEAST_WAY)} as done"
        advice = "set a goal farther from the start: goal.opening or goal.door_angle"
    elif towards:
        message += ", towards the vehicle; a tip that only presses cannot pull"
    ok = far and not towards
    return found("direction", ok, message, travel.length if ok else away, _LEAST_WAY, "rad", advice)


def _approach(model: Model) -> Finding:
    """Exact clearance at the hover before the door and on the straight way from there to the leaf."""
    if model.scenario.mission.start != "hover":
        return found("approach", True, "0 m long: the flight begins at the leaf", 0.0, -TOLERANCE, "m")
    state, far = model.start_state, float(np.linalg.norm(model.hover_offset))
    steps = np.linspace(far, _BETWEEN, max(2, math.ceil(far / _BETWEEN)))
    states = np.tile(state, (len(steps), 1))
    clearances = CollisionScene(model.vehicle, model.door).min_clearance_along(
        model.coupling.vehicle_position(state[:3], float(state[3]), state[5:]) + steps[:, None] / far * model.hover_offset,
        np.tile(rotation_body_to_world(state[:3]), (len(steps), 1, 1)), states[:, 5:], states[:, 3],
    )  # fmt: skip
    worst, where = clearances.worst, float(steps[int(np.argmin(clearances.distances))])
    return found(
        "approach", worst.distance > -TOLERANCE,
        f"on the way from the hover, {far:.2f} m before the leaf, {near(worst)}, {where:.2f} m before it",
        worst.distance, -TOLERANCE, "m",
        "choose a start.door_angle at which the way along the leaf's normal is free, or another contact.height or "
        "mission.hover_distance",
    )  # fmt: skip


def _room_at_touch(model: Model) -> Finding:
    """Gap between rotor disc and leaf, level with the tip on the leaf: the mission gives up where it is too small."""
    state = model.start_state
    angle, attitude = float(state[3]), np.array([0.0, 0.0, state[2]])
    gap = Doorway(model).gap(model.coupling.vehicle_position(attitude, angle, state[5:]), attitude, angle)
    nearer = abs(float(model.vehicle.tip_position(state[5:])[2])) * FIRST_TURN
    return found(
        "room at the touch", gap >= NO_GAP + nearer + SPARE,
        f"with the tip on the leaf at {model.door.in_words(angle)} the rotor disc is {1e2 * gap:.1f} cm from it; the mission "
        f"gives up below {1e2 * NO_GAP:.1f} cm, and the first push tilts it {1e2 * nearer:.1f} cm nearer",
        gap, NO_GAP + nearer, "m",
        "choose a start.arm that reaches farther ahead, or a start.door_angle nearer to 90°, where the arm points at the leaf",
        warning_if(gap >= NO_GAP + nearer),
    )  # fmt: skip


def _room_to_level(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """A door that stands, or turns round, is let go of where the vehicle, levelling about a tied tip, would come near a jamb."""
    if model.contact.tied == 0.0 or rehearsal.failure or model.door.slides or model.door.lies:
        return []
    doorway, standing = Doorway(model), rehearsal.states[np.abs(rehearsal.states[:, 4]) < STANDS]
    after = standing[:: max(1, len(standing) // 100)] if len(standing) else rehearsal.states[-1:]
    gaps = []
    for state, needed in [(model.start_state, ROOM_TO_LEVEL), *((state, ROOM_TO_LEVEL - _LENIENCE) for state in after)]:
        level = model.coupling.vehicle_position([0.0, 0.0, state[2]], float(state[3]), state[5:])
        gap = doorway.gap_to_jambs(level, np.zeros(3))
        gaps.append((gap - needed, gap, needed, float(state[3])))
    _, gap, needed, angle = min(gaps)
    return [found(
        "room to let go", gap >= needed + SPARE,
        f"where the door stands at {math.degrees(angle):.1f}°, a level vehicle is {1e2 * gap:.1f} cm from a jamb; the "
        f"mission gives up below {1e2 * ROOM_TO_LEVEL:.1f} cm",
        gap, needed, "m",
        "choose arm and yaw of start or goal that keep the disc farther from the jambs there, a smaller "
        "contact.distance_from_hinge or a larger planner.margin",
        warning_if(gap >= needed),
    )]  # fmt: skip


def stays_at_the_start(model: Model) -> list[Finding]:
    """A leaf whose own weight moves it is not where the vehicle comes to it; nothing for a vertical hinge."""
    door, angle = model.true_door, model.travel.start
    if door.vertical:
        return []
    torque, friction = torques_at_rest(model, angle)
    shuts = door.opening_of(angle - math.copysign(_LEAST_WAY, torque)) < door.opening_of(angle)
    rests = shuts and abs(angle - door.stop) < _LEAST_WAY
    way = "presses it shut" if rests else "shuts it" if shuts else "opens it"
    return [found(
        "leaf at the start", rests or abs(torque) <= friction,
        f"the leaf's weight {way} with {door.torque_in_words(abs(torque))}, against {door.torque_in_words(friction)} of friction",
        0.0 if rests else abs(torque), friction, "N m",
        "choose a start where the leaf rests (start.opening), or more friction: the leaf moves by itself",
    )]  # fmt: skip


def _true_hinge(model: Model) -> Finding:
    """The simulated hinge, unknown to the planner: what it resists with against the push and what is observed."""
    control, door, ahead = model.scenario.control, model.true_door, model.travel.ahead
    ends = model.start_angle, model.goal_angle
    resists = max(ahead(torque) + friction for torque, friction in (torques_at_rest(model, end) for end in ends))
    expected = model.door.friction + max(ahead(model.door.hinge_torque(end, 0.0)) for end in ends)
    push = largest_push(model, control.max_tilt) * model.coupling.lever_length
    most = push if model.scenario.planner.model == "whole_body" else control.max_door_disturbance
    observed = expected + (most if control.door_observer_rate > 0.0 else 0.0)
    limit = min(push, observed)
    why, key = (
        ("tilt and thrust make", "max_tilt")
        if push <= observed
        else ("the door observer finds", "max_door_disturbance")
    )
    return found(
        "simulated hinge", resists <= limit,
        f"the simulated joint resists with {door.torque_in_words(resists)} at most; {why} {door.torque_in_words(limit)}",
        resists, limit, "N m",
        f"lower simulation.door_friction or simulation.door_stiffness, or raise control.{key}",
    )  # fmt: skip
