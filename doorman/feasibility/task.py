"""The task in words."""

from __future__ import annotations

import math

from doorman.feasibility.geometry import force_needed
from doorman.feasibility.report import Finding, Severity
from doorman.model import Model
from doorman.planning.limits import largest_push


def task_finding(model: Model, duration: float) -> Finding:
    """What the vehicle is to do, as `pull open, hinge on the left, 0° to 75° of 109°, needs 3.1 N of 7.5 N at the handle`.

    Args:
        model: Model of the scenario.
        duration: Time for the swing [s].
    """
    door, travel = model.door, model.travel
    verb = "pull" if travel.sense > 0.0 else "push"
    first, last = (math.degrees(door.opening_of(angle)) + 0.0 for angle in (travel.start, travel.goal))
    side = "right" if door.hand > 0.0 else "left"
    where = "leaf" if door.handle is None else "handle"
    needed, largest = force_needed(model, duration), largest_push(model, model.scenario.control.max_tilt)
    message = (
        f"{verb} {'open' if last > first else 'shut'}, hinge on the {side}, {first:.0f}° to {last:.0f}° of "
        f"{math.degrees(door.largest_opening):.0f}°, needs {needed:.1f} N of {largest:.1f} N at the {where}"
    )
    return Finding("task", Severity.OK, message, needed, largest, "N")
