"""Findings about the mission around the swing: what would make it give up before the leaf, at it, or as it lets go."""

from __future__ import annotations

import math

import numpy as np

from doorman.collision.audit import TOLERANCE
from doorman.collision.scene import CollisionScene
from doorman.control.doorway import NO_GAP, Doorway
from doorman.feasibility.lift import FIRST_TURN
from doorman.feasibility.report import Finding, Severity, graded
from doorman.feasibility.resting import torques_at_rest
from doorman.feasibility.swing.rehearsal import Rehearsal
from doorman.kinematics.coupling import ROOM_TO_LEVEL
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.planning.limits import largest_push

_LEAST_WAY = math.radians(1.5)
"""A shorter way is none: the mission takes such a door for one that is open [rad]."""
_STANDS = 0.03
"""A leaf that is slower stands [rad/s]."""
_LENIENCE = 0.003
"""By which a flight ends farther from a jamb than its rehearsal: it passes the goal by some tenths of a degree [m]."""
_NEAR = 0.01
"""Room beyond a limit below which gusts or a slip can make the mission give up [m]."""
_BETWEEN = 0.02
"""Between places on the way to the leaf at which the clearance is measured [m]."""


def mission_findings(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """Whether the mission comes to the leaf, stays at it and lets go of it."""
    return [
        _direction(model),
        _approach(model),
        _room_at_touch(model),
        *_room_to_level(model, rehearsal),
        *_stays_at_the_start(model),
        _true_hinge(model),
    ]


def _direction(model: Model) -> Finding:
    """Towards the vehicle the leaf moves only where the tip can pull."""
    travel, door = model.travel, model.door
    away, opens = -travel.sense * travel.length, door.opening_of(travel.goal) > door.opening_of(travel.start)
    far, pulls = travel.length > _LEAST_WAY, away < 0.0
    ok = far and (not pulls or model.contact.pull > 0.0)
    ends = f"from {door.in_words(travel.start)} to {door.in_words(travel.goal)}"
    message = f"{ends} the task {'opens' if opens else 'closes'} the door by {door.way_in_words(travel.length)}"
    advice = ""
    if not far:
        message += f"; the mission counts the last {door.way_in_words(_LEAST_WAY)} as done"
        advice = "set a goal farther from the start: goal.opening or goal.door_angle"
    elif not ok:
        message += ", towards the vehicle; a tip that only presses cannot pull"
        other = "pull" if door.side == "push" else "push"
        advice = f'set contact.side = "{other}", from where a push {"opens" if opens else "shuts"} it, or contact.kind = "grip"'
    return Finding("direction", graded(ok), message, travel.length if ok else away, _LEAST_WAY, "rad", advice)


def _approach(model: Model) -> Finding:
    """Exact clearance at the hover before the door and on the straight way from there to the leaf."""
    if model.scenario.mission.start != "hover":
        return Finding("approach", Severity.OK, "0 m long: the flight begins at the leaf", 0.0, -TOLERANCE, "m")
    start = model.start_state
    angle, far = float(start[3]), float(np.linalg.norm(model.hover_offset))
    at_leaf = model.coupling.vehicle_position(start[:3], angle, start[5:])
    steps = np.linspace(far, _BETWEEN, max(2, math.ceil(far / _BETWEEN)))
    positions = at_leaf + steps[:, None] / far * model.hover_offset
    rotations = np.tile(rotation_body_to_world(start[:3]), (len(steps), 1, 1))
    arms, angles = np.tile(start[5:], (len(steps), 1)), np.full(len(steps), angle)
    scene = CollisionScene(model.vehicle, model.door)
    clearances = scene.min_clearance_along(positions, rotations, arms, angles)
    worst, where = clearances.worst, float(steps[int(np.argmin(clearances.distances))])
    ok = worst.distance > -TOLERANCE
    how = "come as near as" if worst.distance > 0.0 else "overlap by"
    return Finding(
        "approach", graded(ok),
        f"on the way from the hover, {far:.2f} m before the leaf, {worst.first} and {worst.second} {how} "
        f"{1e3 * abs(worst.distance):.1f} mm, {where:.2f} m before it",
        worst.distance, -TOLERANCE, "m",
        "" if ok else "choose a start.door_angle at which the way along the leaf's normal is free, or another contact.height or "
        "mission.hover_distance",
    )  # fmt: skip


def _room_at_touch(model: Model) -> Finding:
    """Gap between rotor disc and leaf, level with the tip on the leaf: the mission gives up where it is too small."""
    start = model.start_state
    angle, attitude = float(start[3]), np.array([0.0, 0.0, start[2]])
    place = model.coupling.vehicle_position(attitude, angle, start[5:])
    gap = Doorway(model).gap(place, attitude, angle)
    needed = NO_GAP + abs(float(model.vehicle.tip_position(start[5:])[2])) * FIRST_TURN
    severity = graded(gap >= needed + _NEAR, Severity.WARNING if gap >= needed else Severity.ERROR)
    return Finding(
        "room at the touch", severity,
        f"with the tip on the leaf at {model.door.in_words(angle)} the rotor disc is {1e2 * gap:.1f} cm from it; the mission "
        f"gives up below {1e2 * NO_GAP:.1f} cm, and the first push tilts it {1e2 * (needed - NO_GAP):.1f} cm nearer",
        gap, needed, "m",
        "" if severity is Severity.OK else "choose a start.arm that reaches farther ahead, or a start.door_angle nearer to 90°, "
        "where the arm points at the leaf",
    )  # fmt: skip


def _room_to_level(model: Model, rehearsal: Rehearsal) -> list[Finding]:
    """A door that stands, or turns round, is let go of where the vehicle, levelling about a tied tip, would come near a jamb."""
    if model.contact.tied == 0.0 or rehearsal.failure or model.door.slides or model.door.lies:
        return []
    doorway, standing = Doorway(model), rehearsal.states[np.abs(rehearsal.states[:, 4]) < _STANDS]
    after = standing[:: max(1, len(standing) // 100)] if len(standing) else rehearsal.states[-1:]
    gaps = []
    for state, needed in [(model.start_state, ROOM_TO_LEVEL), *((state, ROOM_TO_LEVEL - _LENIENCE) for state in after)]:
        level = model.coupling.vehicle_position([0.0, 0.0, state[2]], float(state[3]), state[5:])
        gap = doorway.gap_to_jambs(level, np.zeros(3))
        gaps.append((gap - needed, gap, needed, float(state[3])))
    _, gap, needed, angle = min(gaps)
    severity = graded(gap >= needed + _NEAR, Severity.WARNING if gap >= needed else Severity.ERROR)
    return [
        Finding(
            "room to let go", severity,
            f"where the door stands at {math.degrees(angle):.1f}°, a level vehicle is {1e2 * gap:.1f} cm from a jamb; the "
            f"mission gives up below {1e2 * ROOM_TO_LEVEL:.1f} cm",
            gap, needed, "m",
            "" if severity is Severity.OK else "choose arm and yaw of start or goal that keep the disc farther from the jambs "
            "there, a smaller contact.distance_from_hinge or a larger planner.margin",
        )
    ]  # fmt: skip


def _stays_at_the_start(model: Model) -> list[Finding]:
    """A leaf whose own weight moves it is not where the vehicle comes to it; nothing for a vertical hinge."""
    door, angle = model.true_door, model.travel.start
    if door.vertical:
        return []
    torque, friction = torques_at_rest(model, angle)
    shuts = door.opening_of(angle - math.copysign(_LEAST_WAY, torque)) < door.opening_of(angle)
    rests = shuts and abs(angle - door.stop) < _LEAST_WAY
    ok, words = rests or abs(torque) <= friction, door.torque_in_words
    way = "presses it shut" if rests else "shuts it" if shuts else "opens it"
    return [
        Finding(
            "leaf at the start", graded(ok),
            f"the leaf's weight {way} with {words(abs(torque))}, against {words(friction)} of friction",
            0.0 if rests else abs(torque), friction, "N m",
            "" if ok else "choose a start where the leaf rests (start.opening), or more friction: the leaf moves by itself",
        )
    ]  # fmt: skip


def _true_hinge(model: Model) -> Finding:
    """The simulated hinge, unknown to the planner: what it resists with against the push and what is observed."""
    control, door = model.scenario.control, model.true_door
    ends = model.start_angle, model.goal_angle
    sense = math.copysign(1.0, ends[1] - ends[0])
    resists = max(sense * torque + friction for torque, friction in (torques_at_rest(model, end) for end in ends))
    expected = model.door.friction + max(sense * model.door.hinge_torque(end, 0.0) for end in ends)
    push = largest_push(model, control.max_tilt) * model.coupling.lever_length
    most = push if model.scenario.planner.model == "whole_body" else control.max_door_disturbance
    observed = expected + (most if control.door_observer_rate > 0.0 else 0.0)
    limit = min(push, observed)
    ok = resists <= limit
    why = "tilt and thrust make" if push <= observed else "the door observer finds"
    return Finding(
        "simulated hinge", graded(ok),
        f"the simulated joint resists with {door.torque_in_words(resists)} at most; {why} {door.torque_in_words(limit)}",
        resists, limit, "N m",
        "" if ok else "lower simulation.door_friction or simulation.door_stiffness, or raise "
        + ("control.max_tilt" if push <= observed else "control.max_door_disturbance"),
    )  # fmt: skip
