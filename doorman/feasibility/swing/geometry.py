"""Findings from geometry and statics along the swing: reach, room between the constraints, force on the door."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from doorman.collision.rows.jambs import JAMBS
from doorman.collision.rows.plane import LEAF, WALL
from doorman.feasibility.report import SPARE, Finding, Severity, found, warning_if
from doorman.feasibility.swing.rehearsal import DURATION, scaled
from doorman.feasibility.swing.room import Swing, best_swing
from doorman.model import Model
from doorman.planning.limits import largest_push
from doorman.planning.whole_body.numbers import yaw_torque

_FORCE_RESERVE = 0.7


def geometry_findings(model: Model) -> list[Finding]:
    """What needs no plan: reach, room, force and time."""
    without_jambs = np.arange(len(model.vehicle.point_names) + 1)
    return [
        _reach(model, best_swing(model, without_jambs)),
        _room(model, best_swing(model)),
        _force(model),
        _time(model),
    ]


def shortest_swing(model: Model) -> float:
    r"""Time of the swing at the largest push, to the middle and back to rest: :math:`2\sqrt{I\,|\Delta\alpha| / (F D_V)}`."""
    lever = model.coupling.lever_length
    torque = largest_push(model, model.scenario.control.max_tilt) * lever
    moving = model.door.inertia + model.vehicle.mass * lever**2
    return 2.0 * math.sqrt(moving * model.travel.length / torque) if torque > 0.0 else math.inf


def force_needed(model: Model) -> float:
    """Force at the tip that moves the door steadily from start to goal in `DURATION`, by the planner's hinge [N].

    Unknown friction may be the largest. A grip also holds a leaf that its weight drives on, as far as its friction does
    not.
    """
    travel, door = model.travel, model.door
    rate, way = travel.ahead(travel.length) / scaled(DURATION, model), np.linspace(travel.start, travel.goal, 30)
    unknown = door.stiction + (0.0 if model.friction.known else model.friction.largest)
    torques = [travel.ahead(door.hinge_torque(angle, rate)) + unknown for angle in way]
    if door.in_plane:
        return max(_force_in_plane(model, angle, torque) for angle, torque in zip(way, torques, strict=True))
    driven = -min(travel.ahead(door.weight_torque(angle)) for angle in way) - door.friction
    return max(0.0, *torques, model.contact.tied * driven) / model.coupling.lever_length


def yaw_force(model: Model) -> float:
    """Force to the side that the vehicle's yaw torque makes at the tip [N]."""
    return yaw_torque(model) / math.hypot(*model.vehicle.tip_position(model.start_arm)[:2])


def _force_in_plane(model: Model, door_angle: float, torque: float) -> float:
    """Force up or down that makes a torque in a lever's joint: one to the side turns a vehicle whose tip is ahead of it [N]."""
    lever = model.door.lever(door_angle, model.coupling.distance_from_hinge)
    left = abs(torque) - yaw_force(model) * math.hypot(float(lever[0]), float(lever[1]))
    if left <= 0.0:
        return 0.0
    return left / abs(float(lever[2])) if lever[2] else math.inf


def _reach(model: Model, swing: Swing) -> Finding:
    """Whether the arm, hanging below the rotors, holds the disc off the leaf; `swing` over rows without the jambs."""
    margin, room = model.scenario.planner.margin, float(swing.room[swing.narrowest])
    return found(
        "reach", room >= margin,
        f"with the arm below the rotors, the tip reaches {1e2 * abs(room):.1f} cm {'beyond' if room >= 0 else 'less than'} "
        f"the rim of the disc of {model.vehicle.radius:.2f} m radius; planner.margin is {1e2 * margin:.1f} cm",
        room, margin, "m",
        f"use an arm longer by at least {1e2 * (margin - room):.1f} cm, a smaller disc (vehicle.radius) or a smaller "
        "planner.margin",
    )  # fmt: skip


def _room(model: Model, swing: Swing) -> Finding:
    """Whether a level posture inside the constraints exists at every door angle, connected to its neighbours."""
    margin, k = model.scenario.planner.margin, swing.narrowest
    room, angle = float(swing.room[k]), model.door.in_words(float(swing.door_angles[k]), 0)
    names = [model.constraint_names[row] for row in swing.binding[k]]
    keeps = f"keeps {1e2 * room:.1f} cm from all constraints"
    message = (
        f"at {'' if model.door.slides else 'α = '}{angle}, the narrowest place of the way, the best posture "
        f"{keeps if room >= 0.0 else f'breaks a constraint by {-1e2 * room:.1f} cm'}, where planner.margin is "
        f"{1e2 * margin:.1f} cm; the narrowest {'are' if len(names) > 1 else 'is'} {' and '.join(map(repr, names))}"
    )
    more, tracking = f"use {room_to_gain(names)}", SPARE * model.scale.length
    if room < margin:
        more, worse = f"{1e2 * (margin - room):.1f} cm are missing: {more}", Severity.ERROR
    elif not swing.connected:
        message += "; the way there from the start's posture has a jump"
        more, worse = "choose another start.arm", Severity.ERROR
    else:
        more, worse = f"fly it in simulation first, or {more}", Severity.WARNING
    ok = worse is Severity.WARNING and room >= margin + tracking
    if not ok and worse is Severity.WARNING:
        message += f"; tracking errors of {1e2 * tracking:.1f} cm come on top of that"
    return found("room along the swing", ok, message, room, margin, "m", more, worse)


def room_to_gain(names: Collection[str]) -> str:
    """What gives room where these constraints bind."""
    latch, hinge = (jamb in names for jamb in JAMBS)
    ways = {
        "another contact.distance_from_hinge": latch and hinge,
        "a smaller contact.distance_from_hinge": latch and not hinge,
        "a larger contact.distance_from_hinge": not latch and (hinge or WALL in names),
        "a wider doorway": latch or hinge,
        "a longer arm": LEAF in names,
        "a smaller disc (vehicle.radius) or a smaller planner.margin": True,
    }
    return ", ".join(way for way, helps in ways.items() if helps)


def _force(model: Model) -> Finding:
    """Force that moves the door steadily through the swing in a given time, against what tilt and thrust can give."""
    needed, tilt = force_needed(model), model.scenario.control.max_tilt
    available = largest_push(model, tilt)
    by_tilt = available < largest_push(model, math.pi / 2)
    what = f"the tilt limit of {math.degrees(tilt):.0f}°" if by_tilt else "the largest thrust"
    return found(
        "force on the door", needed <= _FORCE_RESERVE * available,
        f"friction, damping and spring of the hinge need {needed:.1f} N at the tip; {what} allows {available:.1f} N",
        needed, available, "N", "raise contact.distance_from_hinge, control.max_tilt or the thrust, or an easier hinge",
        warning_if(needed < available),
    )  # fmt: skip


def inertia_in_words(model: Model) -> str:
    """Inertia of the leaf about its hinge, or mass on its slide."""
    return f"{model.door.mass:.3g} kg" if model.door.slides else f"{model.door.inertia:.3g} kg m²"


def _time(model: Model) -> Finding:
    """Time that the inertia of leaf and vehicle takes at least, against the mission's patience."""
    least, limit = shortest_swing(model), model.scenario.mission.time_out.open
    return found(
        "time for the swing", least <= limit,
        f"{inertia_in_words(model)} of leaf take {least:.1f} s at the largest push; the mission waits for {limit:g} s",
        least, limit, "s",
        "use a lighter leaf, a larger contact.distance_from_hinge or control.max_tilt, or a longer mission.time_out.open",
    )  # fmt: skip
