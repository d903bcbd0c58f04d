"""The whole-body plan in a mission: what it flies, and on what estimates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.leaf_estimator import LeafEstimate, LeafEstimator
from doorman.control.state_converter import StateConverter
from doorman.control.whole_body_control import WholeBodyController
from doorman.mission.phases import Phase
from doorman.model import Model
from doorman.signals import Command, Measurement

Array = NDArray[np.float64]

_AT_THE_LEAF = (Phase.TOUCH, Phase.OPEN, Phase.RECOVER, Phase.HOLD)


class WholeBodyFlight:
    """Touch, swing, loss of contact and hold as one problem; before and after them the position controller flies.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
    """

    def __init__(self, model: Model, converter: StateConverter) -> None:
        self._estimator, self._controller = LeafEstimator(model, converter), WholeBodyController(model)
        self._known: LeafEstimate | None = None

    def listen(self, measurement: Measurement, force: Array, phase: Phase, time_step: float) -> None:
        """Take in one measurement, in every phase.

        Args:
            measurement: What the sensors say.
            force: Of the rotors since the last call, shape (3,), world frame [N].
            phase: Where the mission is.
            time_step: Since the last call [s].
        """
        seeks, wanted = phase in _AT_THE_LEAF, self._controller.opening_rate
        self._known = self._estimator.update(measurement, force, time_step, seeks, wanted)

    def command(self, measurement: Measurement, phase: Phase, time_step: float) -> Command | None:
        """What the vehicle is to do now.

        Args:
            measurement: What the sensors say.
            phase: Where the mission is.
            time_step: Since the last call [s].

        Returns:
            The command; None where the tip is not at the leaf.
        """
        if phase not in _AT_THE_LEAF or self._known is None:
            self._controller.forget()
            return None
        return self._controller.command(measurement.time, self._known, time_step, float(measurement.attitude[2]))
