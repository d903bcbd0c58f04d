"""Finding about the postures that a scenario leaves open: what is proposed for them, and how far from all limits that stays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from doorman.arrays import Array
from doorman.collision.rows.jambs import JAMBS
from doorman.collision.rows.plane import LEAF, WALL
from doorman.feasibility.inputs.setup import joint_margin
from doorman.feasibility.report import Finding, Severity, graded
from doorman.model import Model
from doorman.postures.proposal import PAPER_POSTURES

_TOLERANCE = 1e-9


def postures_finding(model: Model) -> Finding:
    """Start and goal postures against constraints and joint limits; an error if no open posture keeps them."""
    ends = {"start": model.start_state, "goal": model.goal_state}
    open_ends = {name: state for name, state in ends.items() if any(key.startswith(name) for key in model.proposed)}
    slack = {name: _slack(model, state) for name, state in (open_ends or ends).items()}
    worst = min(slack, key=lambda name: float(slack[name].min()))
    room, row = float(slack[worst].min()), int(slack[worst].argmin())
    margin = joint_margin(model, np.array([ends[name][5:] for name in slack])) if model.n_arm else None
    proposal = in_toml(model.proposed) or "start and goal are given"
    if not open_ends or (room >= -_TOLERANCE and (margin is None or margin.inside >= -_TOLERANCE)):
        message = (
            f"{proposal}; nearest are '{model.constraint_names[row]}', {1e2 * room:.1f} cm beyond the margin at the {worst}"
            + (f", and a limit of joint {margin.joint}, {margin.size} away" if margin else "")
        )
        return Finding("postures", Severity.OK, message, room, 0.0, "m")
    return Finding(
        "postures", graded(False), f"no {' and '.join(_broken(slack))} posture keeps all limits: {_missing(model, slack)}; "
        f"the widest is {proposal}",
        room, 0.0, "m", _advice(model, slack),
    )  # fmt: skip


def unusual_postures(model: Model) -> str:
    """Proposed postures other than the paper's in the syntax of TOML; empty where there are none."""
    return in_toml({key: value for key, value in model.proposed.items() if value != PAPER_POSTURES[key]})


def in_toml(postures: Mapping[str, tuple[float, ...]]) -> str:
    """Postures as the scenario's keys and values, `goal.arm = [0.0, 1.5, -1.5, 0.0], …`."""
    return ", ".join(f"{key} = {list(value)}" for key, value in postures.items())


def _slack(model: Model, state: Array) -> Array:
    """Distances from the constraints beyond the margin [m]."""
    return -(model.constraints(state) + model.scenario.planner.margin)


def _broken(slack: Mapping[str, Array]) -> list[str]:
    """Ends that break a constraint, or all where it is a joint's limit."""
    return [name for name, distances in slack.items() if distances.min() < -_TOLERANCE] or list(slack)


def _missing(model: Model, slack: Mapping[str, Array]) -> str:
    """What the widest postures lack."""
    lacks = [
        f"at the {name} '{model.constraint_names[row]}' lacks {-1e2 * distances[row]:.1f} cm"
        for name, distances in slack.items()
        for row in np.flatnonzero(distances < -_TOLERANCE)
    ]
    return ", ".join(lacks) or "a joint that the scenario gives is outside its limits"


def _advice(model: Model, slack: Mapping[str, Array]) -> str:
    """What gives the room that is missing."""
    rows = {int(row) for distances in slack.values() for row in np.flatnonzero(distances < -_TOLERANCE)}
    names, (latch, hinge) = {model.constraint_names[row] for row in rows}, JAMBS
    ways = []
    if latch in names or hinge in names:
        side = "another" if {latch, hinge} <= names else ("a smaller" if latch in names else "a larger")
        ways.append(f"{side} contact.distance_from_hinge, a wider doorway")
    if WALL in names:
        ways.append("a larger contact.distance_from_hinge, a door that opens less")
    if LEAF in names:
        ways.append("a longer arm")
    if min(rows, default=len(model.vehicle.point_names)) < len(model.vehicle.point_names):
        ways.append("an arm that reaches the leaf from below the body")
    given = [f"{end}.{key}" for end in slack for key in ("attitude", "arm") if f"{end}.{key}" not in model.proposed]
    if given:
        ways.append(f"no {' and no '.join(given)} in the scenario, so that doorman proposes it")
    return "use " + ", ".join([*ways, "a smaller disc (vehicle.radius) or a smaller planner.margin"])
