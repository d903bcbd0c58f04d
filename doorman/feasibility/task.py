"""The task in words."""

from __future__ import annotations

import math

from doorman.feasibility.report import Finding, found
from doorman.feasibility.swing.geometry import force_needed
from doorman.kinematics.doors.door import Door
from doorman.model import Model
from doorman.planning.limits import largest_push


def task_finding(model: Model) -> Finding:
    """What the vehicle is to do, as `pull open, hinge on the left, 0° to 75° of 109°, needs 3.1 N of 7.5 N at the handle`."""
    door, travel = model.door, model.travel
    verb = "turn" if door.in_plane else "pull" if travel.sense > 0.0 else "push"
    first, last = (door.opening_of(angle) + 0.0 for angle in (travel.start, travel.goal))
    where = "leaf" if door.handle is None else "handle"
    needed, largest = force_needed(model), largest_push(model, model.scenario.control.max_tilt)
    message = (
        f"{verb} {'open' if last > first else 'shut'}, {joint_in_words(door)}, {_way(door, first, last)}, "
        f"needs {needed:.1f} N of {largest:.1f} N at the {where}"
    )
    return found("task", True, message, needed, largest, "N")


def joint_in_words(door: Door) -> str:
    """Kind of the door's joint and where it is, as `hinge on the left`."""
    if door.in_plane:
        return "in the plane of its face"
    if door.slides:
        return "slide"
    if not door.lies:
        return f"hinge on the {'right' if door.hand > 0.0 else 'left'}"
    return "hinge at the top" if door.along[2] < 0.0 else "hinge at the bottom"


def _way(door: Door, first: float, last: float) -> str:
    """As `0° to 75° of 109°`, or `0.00 m to 0.30 m of 0.45 m`."""
    if door.slides:
        return f"{first:.2f} m to {last:.2f} m of {door.largest_opening:.2f} m"
    first, last = math.degrees(first), math.degrees(last)
    return f"{first:.0f}° to {last:.0f}° of {math.degrees(door.largest_opening):.0f}°"
