"""What the rotor disc of a vehicle that flies freely keeps clear of: the face, and what stands beside the door.

The rows are those of `collision.constraints`, by the vehicle's own position and not by a tip that is tied to the leaf.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.collision.constraints import distances_to_corners
from doorman.collision.surroundings import Surroundings


def planes(task: Any, surroundings: Surroundings) -> dict[str, Any]:
    """By how much the rotor disc is nearer to each of them than the margin [m]."""
    beside = {"doorway": _jambs, "corners": _corners, "wall": _wall, "panel": _panel}[surroundings]
    before = ca.dot(task.normal, task.position - task.mechanism.moved(task.joint, task.of["mechanism"].point))
    return {"face": task.clear_of(task.normal, before), **beside(task)}


def _jambs(task: Any) -> dict[str, Any]:
    """Between them, wherever the vehicle is."""
    hinge_side, across = task.of["mechanism"].across, _across(task)
    return {
        "latch jamb": task.clear_of(-hinge_side, task.of["limits"].width - across),
        "hinge jamb": task.clear_of(hinge_side, across),
    }


def _corners(task: Any) -> dict[str, Any]:
    """The jambs near the wall alone, for a level disc."""
    beside = task.of["beside"]
    room = task.of["vehicle"].radius + task.of["limits"].margin
    distances = distances_to_corners(_across(task), _into(task), beside)
    return {name: room - distance for name, distance in zip(("latch jamb", "hinge jamb"), distances, strict=True)}


def _wall(task: Any) -> dict[str, Any]:
    """Before the wall."""
    beside = task.of["beside"]
    return {"wall": task.clear_of(-beside.into, -_into(task) - beside.frame_depth)}


def _panel(task: Any) -> dict[str, Any]:
    """On the handle's side of what slides."""
    beside = task.of["beside"]
    distance = ca.dot(beside.panel, task.position - task.of["mechanism"].origin) - beside.panel_distance
    return {"panel": task.clear_of(beside.panel, distance)}


def _across(task: Any) -> Any:
    """Distance of O_B from the hinge along the closed leaf [m]."""
    return ca.dot(task.of["mechanism"].across, task.position - task.of["mechanism"].origin)


def _into(task: Any) -> Any:
    """Distance of O_B behind the hinge through the doorway [m]."""
    return ca.dot(task.of["beside"].into, task.position - task.of["mechanism"].origin)
