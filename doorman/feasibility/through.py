"""Findings about the way through the doorway of a door that stands open."""

from __future__ import annotations

import math

from doorman.control.passage import NEEDED, OFF, Passage, has_doorway
from doorman.feasibility.report import SPARE, Finding, found, near, warning_if
from doorman.feasibility.resting import torques_at_rest
from doorman.model import Model


def through_findings(model: Model) -> list[Finding]:
    """Whether the door stays open by itself, and leaves room to fly through; nothing for a mission that does not."""
    if model.scenario.mission.then != "through":
        return []
    if not has_doorway(model):
        advice = 'set mission.then = "return" or "stay"'
        return [found("way through", False, "there is no doorway behind this leaf", 0.0, NEEDED, "m", advice)]
    return [_stays_open(model), _way_through(model)]


def _stays_open(model: Model) -> Finding:
    """A door that shuts by itself meets the vehicle in the doorway."""
    goal, words = model.goal_angle, model.door.torque_in_words
    torque, friction = torques_at_rest(model, goal)
    shuts = -torque if model.door.side == "push" else torque
    ok = shuts <= friction
    message = (
        f"at {model.door.in_words(goal)} the door shuts with {words(max(shuts, 0.0) + 0.0)} by itself, against "
        f"{words(friction)} of friction"
    )
    return found(
        "stays open", ok, message if ok else f"{message}; {_held_while_passing(model)}", shuts, friction, "N m",
        'set mission.then = "stay": the vehicle then holds a door that shuts by itself',
    )  # fmt: skip


def _held_while_passing(model: Model) -> str:
    """Why the vehicle does not hold the leaf on its way.

    The edge of a leaf that shuts sweeps a circle. A vehicle that lets go of it has its disc outside of that circle, and its tip
    on the edge: so far the tip is ahead of O_B at least.
    """
    needed, arm = model.vehicle.radius + NEEDED, model.vehicle.tip_position(model.start_arm)
    reach = math.hypot(*arm[:2].tolist())
    if reach < needed:
        return (
            f"to hold it until the disc has passed, the tip would have to be {needed:.2f} m from the body frame's origin, and "
            f"with start.arm it is {reach:.2f} m: the arm is too short"
        )
    return "the vehicle turns away from the leaf to fly through, and does not hold it"


def _way_through(model: Model) -> Finding:
    """Exact clearance on the way, with a leaf as far off the goal as may be."""
    passage, door = Passage(model), model.door
    worst = passage.clearance
    return found(
        "way through", worst.distance >= NEEDED + SPARE,
        f"with the leaf up to {door.way_in_words(OFF)} off {door.in_words(model.goal_angle)}, {near(worst)} on the way "
        f"through; {1e2 * NEEDED:.0f} cm are needed",
        worst.distance, NEEDED, "m", "use a larger goal.opening, a start.arm nearer to the body, or a smaller vehicle",
        warning_if(passage.clear),
    )  # fmt: skip
