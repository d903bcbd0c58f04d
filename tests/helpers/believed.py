"""Estimates that differ from another one, with vehicle, tip and leaf where their state has them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from doorman.control.estimation.estimator import Estimate
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model


def geometry(model: Model, position: np.ndarray, state: np.ndarray) -> dict[str, np.ndarray]:
    """What an estimate says of tip and leaf beside its state."""
    angle, rotation = float(state[3]), rotation_body_to_world(state[:3])
    return {
        "normal": model.door.normal(angle), "along": model.door.leaf_direction(angle),
        "contact_point": model.coupling.contact_point(angle), "rotation_body_to_world": rotation,
        "tip": position + rotation @ model.vehicle.tip_position(state[5:]),
    }  # fmt: skip


def changed(model: Model, estimate: Estimate, **changes: Any) -> Estimate:
    """The same estimate but for these fields."""
    one = replace(estimate, **changes)
    return replace(one, **geometry(model, one.position, one.state))
