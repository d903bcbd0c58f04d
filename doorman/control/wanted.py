"""What is to be planned, as it is known when a plan is due."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from doorman.arrays import Array
from doorman.planning.hinge import Hinge


class Wanted(NamedTuple):
    """A plan that is wanted."""

    state: Array
    """x of the planner, shape (nx,)."""
    hinge: Hinge
    """What is known of it."""
    numbers: Mapping[str, Any] | None = None
    """References and weights of a whole-body plan, by name: one iteration follows them."""
    goal: float | None = None
    """Where the door is to go; the scenario's goal if not given [rad]."""
    under_way: Sequence[Array] = ()
    """Inputs that were sent and have not acted yet, each for one step of the plan, shape (nu,)."""
