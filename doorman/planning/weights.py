"""A scenario's weights, or the defaults where it gives none."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import ScenarioError
from doorman.model import Model

Array = NDArray[np.float64]


def chosen_weights(model: Model, name: str, default: Array) -> Array:
    """The diagonal `planner.weights.<name>`."""
    given = getattr(model.scenario.planner.weights, name)
    if given is not None and len(given) != len(default):
        raise ScenarioError(
            "wrong number of weights", file=model.scenario.source, field=f"planner.weights.{name}", given=len(given),
            allowed=f"{len(default)} for an arm of {model.n_arm} joints",
        )  # fmt: skip
    return np.array(default if given is None else given)
