"""Findings from geometry and statics along the swing: reach, room between the constraints, force on the door."""

from __future__ import annotations

import math

import numpy as np

from doorman.collision.rows.jambs import JAMBS
from doorman.collision.rows.plane import LEAF, WALL
from doorman.feasibility.report import Finding, Severity, graded
from doorman.feasibility.swing.room import Swing, best_swing
from doorman.model import Model
from doorman.planning.limits import largest_push
from doorman.planning.whole_body.numbers import yaw_torque

_FORCE_RESERVE = 0.7
_TRACKING = 0.01
"""Room beyond the planner's margin for tracking errors, of the shipped vehicle [m]."""


def geometry_findings(model: Model, duration: float) -> list[Finding]:
    without_jambs = np.arange(len(model.vehicle.point_names) + 1)
    return [
        _reach(model, best_swing(model, without_jambs)),
        _room(model, best_swing(model)),
        _force(model, duration),
        _time(model),
    ]


def shortest_swing(model: Model) -> float:
    r"""Time of the swing at the largest push, to the middle and back to rest: :math:`2\sqrt{I\,|\Delta\alpha| / (F D_V)}`."""
    lever, way = model.coupling.lever_length, abs(model.goal_angle - model.start_angle)
    torque = largest_push(model, model.scenario.control.max_tilt) * lever
    moving = model.door.inertia + model.vehicle.mass * lever**2
    return 2.0 * math.sqrt(moving * way / torque) if torque > 0.0 else math.inf


def force_needed(model: Model, duration: float) -> float:
    """Force at the tip that moves the door steadily from start to goal, by the hinge that the planner knows [N].

    Unknown friction may be the largest. A grip also holds a leaf that its weight drives on, as far as its friction does
    not.
    """
    travel, door = model.travel, model.door
    rate, way = travel.ahead(travel.length) / duration, np.linspace(travel.start, travel.goal, 30)
    unknown = 0.0 if model.friction.known else model.friction.largest
    torques = [travel.ahead(door.hinge_torque(angle, rate)) + unknown for angle in way]
    driven = -min(travel.ahead(door.weight_torque(angle)) for angle in way) - door.friction
    held = model.contact.tied * driven
    if door.in_plane:
        return max(
            _force_in_plane(model, angle, torque + door.stiction) for angle, torque in zip(way, torques, strict=True)
        )
    return max(0.0, max(torques) + door.stiction, held) / model.coupling.lever_length


def _force_in_plane(model: Model, door_angle: float, torque: float) -> float:
    """Force up or down that makes a torque in a lever's joint: one to the side turns a vehicle whose tip is ahead of it [N]."""
    lever = model.door.lever(door_angle, model.coupling.distance_from_hinge)
    aside = yaw_torque(model) / math.hypot(*model.vehicle.tip_position(model.start_arm)[:2])
    left = abs(torque) - aside * math.hypot(float(lever[0]), float(lever[1]))
    if left <= 0.0:
        return 0.0
    return left / abs(float(lever[2])) if lever[2] else math.inf


def _reach(model: Model, swing: Swing) -> Finding:
    """Whether the arm, hanging below the rotors, holds the disc off the leaf; `swing` over rows without the jambs."""
    margin, room = model.scenario.planner.margin, float(swing.room[swing.narrowest])
    ok = room >= margin
    return Finding(
        "reach", graded(ok),
        f"with the arm below the rotors, the tip reaches {1e2 * abs(room):.1f} cm {'beyond' if room >= 0 else 'less than'} "
        f"the rim of the disc of {model.vehicle.radius:.2f} m radius; planner.margin is {1e2 * margin:.1f} cm",
        room, margin, "m",
        "" if ok else f"use an arm longer by at least {1e2 * (margin - room):.1f} cm, a smaller disc (vehicle.radius) "
        "or a smaller planner.margin",
    )  # fmt: skip


def _room(model: Model, swing: Swing) -> Finding:
    """Whether a level posture inside the constraints exists at every door angle, connected to its neighbours."""
    margin, k = model.scenario.planner.margin, swing.narrowest
    room, angle = float(swing.room[k]), model.door.in_words(float(swing.door_angles[k]), 0)
    rows = " and ".join(f"'{model.constraint_names[row]}'" for row in swing.binding[k])
    missing = (
        f"breaks a constraint by {-1e2 * room:.1f} cm"
        if room < 0.0
        else f"keeps {1e2 * room:.1f} cm from all constraints"
    )
    message = (
        f"at {'' if model.door.slides else 'α = '}{angle}, the narrowest place of the way, the best posture {missing}, "
        f"where planner.margin is {1e2 * margin:.1f} cm; the narrowest {'are' if len(swing.binding[k]) > 1 else 'is'} {rows}"
    )
    ok, advice = room >= margin and swing.connected, ""
    if room < margin:
        advice = f"{1e2 * (margin - room):.1f} cm are missing: use {_where_to_gain(model, swing.binding[k])}"
    elif not ok:
        message += "; the way there from the start's posture has a jump"
        advice = "choose another start.arm"
    tracking = _TRACKING * model.scale.length
    tight = ok and room < margin + tracking
    if tight:
        message += f"; tracking errors of {1e2 * tracking:.1f} cm come on top of that"
        advice = f"fly it in simulation first, or use {_where_to_gain(model, swing.binding[k])}"
    severity = Severity.WARNING if tight else graded(ok)
    return Finding("room along the swing", severity, message, room, margin, "m", advice)


def _where_to_gain(model: Model, binding: tuple[int, ...]) -> str:
    names, (latch, hinge) = {model.constraint_names[row] for row in binding}, JAMBS
    ways = []
    if latch in names:
        ways.append("a smaller contact.distance_from_hinge")
    if hinge in names or WALL in names:
        ways.append("a larger contact.distance_from_hinge")
    if latch in names or hinge in names:
        ways.append("a wider doorway")
    if LEAF in names:
        ways.append("a longer arm")
    return ", ".join([*ways, "a smaller disc (vehicle.radius) or a smaller planner.margin"])


def _force(model: Model, duration: float) -> Finding:
    """Force that moves the door steadily through the swing in a given time, against what tilt and thrust can give."""
    needed, tilt = force_needed(model, duration), model.scenario.control.max_tilt
    available = largest_push(model, tilt)
    severity = graded(needed <= _FORCE_RESERVE * available, Severity.WARNING if needed < available else Severity.ERROR)
    by_tilt = available < largest_push(model, math.pi / 2)
    what = f"the tilt limit of {math.degrees(tilt):.0f}°" if by_tilt else "the largest thrust"
    return Finding(
        "force on the door", severity,
        f"friction, damping and spring of the hinge need {needed:.1f} N at the tip; {what} allows {available:.1f} N",
        needed, available, "N",
        "" if severity is Severity.OK else "raise contact.distance_from_hinge, control.max_tilt or the thrust, "
        "or an easier hinge",
    )  # fmt: skip


def inertia_in_words(model: Model) -> str:
    """Inertia of the leaf about its hinge, or mass on its slide."""
    return f"{model.door.mass:.3g} kg" if model.door.slides else f"{model.door.inertia:.3g} kg m²"


def _time(model: Model) -> Finding:
    """Time that the inertia of leaf and vehicle takes at least, against the mission's patience."""
    least, limit = shortest_swing(model), model.scenario.mission.time_out.open
    ok = least <= limit
    return Finding(
        "time for the swing", graded(ok),
        f"{inertia_in_words(model)} of leaf take {least:.1f} s at the largest push; the mission waits for {limit:g} s",
        least, limit, "s",
        "" if ok else "use a lighter leaf, a larger contact.distance_from_hinge or control.max_tilt, or a longer "
        "mission.time_out.open",
    )  # fmt: skip
