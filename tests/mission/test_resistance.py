"""Which doors are held at once, by the estimates and their deviations, and which are tried."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from doorman import Model
from doorman.control.estimator import Estimate
from doorman.mission.progress import Progress
from doorman.mission.resistance import Resistance


def known(spare: float, deviation: float, wind: float = 0.0) -> Estimate:
    hinge = SimpleNamespace(spare=spare, spare_deviation=deviation, closing_wind=0.0)
    return SimpleNamespace(hinge=hinge, wind=np.array([wind, 0.0, 0.0]))  # type: ignore[return-value]


def keeps(model: Model, in_swing: float, spare: float, deviation: float) -> bool:
    resistance = Resistance(model, Progress(model, False))
    resistance.in_swing = in_swing
    return resistance.keeps_the_door(known(spare, deviation))


@pytest.mark.parametrize(
    ("spare", "deviation", "tried"),
    [
        (0.3, 0.05, True),
        (0.3, 0.9, True),
        (-0.1, 0.3, True),
        (-0.1, 0.05, False),
        (-0.72, 0.4, False),
        (-0.72, 2.0, False),
    ],
)
def test_a_gripped_door_is_tried_unless_its_closer_surely_wins(
    model: Model, spare: float, deviation: float, tried: bool
) -> None:
    assert keeps(model, 0.5, spare, deviation) is tried


def test_a_gripped_door_that_resisted_by_nothing_is_held(model: Model) -> None:
    assert not keeps(model, 0.1, 0.3, 0.05)
