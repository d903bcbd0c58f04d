"""Outputs: what users ask of a filter, beside its state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, eq=False)
class Output:
    """An expression of the state, with its deviation.

    Args:
        name: Name under which the estimate has it.
        expression: Of the model's symbols, (1, 1).
        under: Other expressions under some hypotheses, by their names: a force that is 0 in free flight.
    """

    name: str
    expression: Any
    under: Mapping[str, Any] = field(default_factory=dict)
