r"""Measurements: what a sensor reads of the state, in CasADi expressions.

.. math:: y = h(x, u, p) + v,\qquad v \sim N(0, \mathrm{diag}(\sigma^2))
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from doorman.exceptions import DoormanError


@dataclass(frozen=True, eq=False)
class Measurement:
    r"""A sensor's rows.

    The innovation :math:`\nu = y - h` has the covariance :math:`S = H P H^T + R`, and the normalised innovation squared (NIS)
    :math:`\nu^T S^{-1} \nu` is χ² distributed with as many degrees as there are rows, if model and noise are right.
    Angles must be given without jumps.

    Args:
        name: By which readings are given.
        expression: h of the model's symbols, (r, 1).
        deviation: σ of each row, (r, 1), or one for all [unit of the row]: numbers, or expressions.
        gate: Largest square root of the NIS. A reading beyond it under every hypothesis is refused.
        under: Other expressions under some hypotheses, by their names: an accelerometer feels a contact only where there is one.

    Raises:
        DoormanError: if the gate is no positive number.
    """

    name: str
    expression: Any
    deviation: Any
    gate: float = math.inf
    under: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.gate > 0.0:
            raise DoormanError("not a gate", field=f"{self.name}.gate", given=self.gate, allowed="> 0 deviations")
