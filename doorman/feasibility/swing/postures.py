"""Finding about the postures that a scenario leaves open: what is proposed for them, and how far from all limits that stays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from doorman.arrays import Array
from doorman.feasibility.inputs.setup import joint_margin
from doorman.feasibility.report import Finding, found
from doorman.feasibility.swing.geometry import room_to_gain
from doorman.model import Model
from doorman.postures.proposal import PAPER_POSTURES

_TOLERANCE = 1e-9


def postures_finding(model: Model) -> Finding:
    """Start and goal postures against constraints and joint limits; an error if no open posture keeps them."""
    ends = {"start": model.start_state, "goal": model.goal_state}
    open_ends = {name: state for name, state in ends.items() if any(key.startswith(name) for key in model.proposed)}
    looked_at, given = open_ends or ends, model.scenario.planner.margin
    slack = {name: -(model.constraints(state) + given) for name, state in looked_at.items()}
    worst = min(slack, key=lambda name: float(slack[name].min()))
    room, row = float(slack[worst].min()), int(slack[worst].argmin())
    margin = joint_margin(model, np.array([ends[name][5:] for name in slack])) if model.n_arm else None
    proposal = in_toml(model.proposed) or "start and goal are given"
    ok = not open_ends or (room >= -_TOLERANCE and (margin is None or margin.inside >= -_TOLERANCE))
    if ok:
        message = (
            f"{proposal}; nearest are '{model.constraint_names[row]}', {1e2 * room:.1f} cm beyond the margin at the {worst}"
            + (f", and a limit of joint {margin.joint}, {margin.size} away" if margin else "")
        )
    else:
        broken = [name for name, distances in slack.items() if distances.min() < -_TOLERANCE] or list(slack)
        message = (
            f"no {' and '.join(broken)} posture keeps all limits: {_missing(model, slack)}; the widest is {proposal}"
        )
    return found("postures", ok, message, room, 0.0, "m", "" if ok else _advice(model, slack))


def unusual_postures(model: Model) -> str:
    """Proposed postures other than the paper's in the syntax of TOML; empty where there are none."""
    return in_toml({key: value for key, value in model.proposed.items() if value != PAPER_POSTURES[key]})


def in_toml(postures: Mapping[str, tuple[float, ...]]) -> str:
    """Postures as the scenario's keys and values, `goal.arm = [0.0, 1.5, -1.5, 0.0], …`."""
    return ", ".join(f"{key} = {list(value)}" for key, value in postures.items())


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
    ways = []
    if min(rows, default=len(model.vehicle.point_names)) < len(model.vehicle.point_names):
        ways.append("an arm that reaches the leaf from below the body")
    given = [f"{end}.{key}" for end in slack for key in ("attitude", "arm") if f"{end}.{key}" not in model.proposed]
    if given:
        ways.append(f"no {' and no '.join(given)} in the scenario, so that doorman proposes it")
    return "use " + ", ".join([*ways, room_to_gain({model.constraint_names[row] for row in rows})])
