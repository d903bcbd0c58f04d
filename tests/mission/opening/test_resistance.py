"""Which doors are held at once, by the estimates and their deviations, and which are tried."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from doorman import Model
from doorman.control.estimation.estimator import Estimate
from doorman.mission.opening.progress import Progress
from doorman.mission.opening.resistance import Resistance


def known(spare: float, deviation: float, wind: float = 0.0) -> Estimate:
    hinge = SimpleNamespace(spare=spare, spare_deviation=deviation)
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


TICK = 0.01


def gripped(goal: float, off: float, rate: float, disturbance: float, time: float = 0.0) -> Estimate:
    """A door this far from the goal, with a hinge of 1 N m of friction."""
    hinge = SimpleNamespace(friction=1.0)
    return SimpleNamespace(  # type: ignore[return-value]
        time=time, door_angle=goal + off, door_rate=rate, door_disturbance=disturbance, hinge=hinge
    )


def carried(model: Model, offs: list[float], rate: float, noise: float = 0.0) -> tuple[Resistance, Progress, float]:
    """What plans are told last of a door that is seen at these angles from the goal, each for half a second."""
    progress = Progress(model, pushes=False)
    resistance, goal = Resistance(model, progress), model.goal_angle
    ticks = [off for off in offs for _ in range(round(0.5 / TICK))]
    for tick, off in enumerate(ticks):
        seen = rate + noise * math.copysign(1.0, tick % 50 - 25)
        estimate = gripped(goal, off, seen, -1.8, TICK * tick)
        progress.update(estimate, False, TICK)
        told = resistance.torque(estimate, TICK)
    return resistance, progress, told


@pytest.mark.parametrize(("offs", "pushed"), [([0.1, 0.06], 1.8), ([0.06, -0.03, -0.06], 1.1)])
def test_a_gripped_door_that_passes_the_goal_is_left_to_its_friction(
    model: Model, offs: list[float], pushed: float
) -> None:
    """A push against all that resists it would move it on, and on."""
    _, _, told = carried(model, offs, -0.06)
    assert told == pytest.approx(-pushed, abs=0.02)


def test_a_gripped_door_that_stands_beyond_the_goal_is_pulled_back_however_noisy_its_rate(model: Model) -> None:
    _, _, told = carried(model, [0.06] + 10 * [-0.06], 0.0, noise=0.05)
    assert told == pytest.approx(-1.1, abs=0.15), "of the 1.8 N m that it was pushed with, and 0.7 are the most"
    _, _, told = carried(model, [0.06] + 60 * [-0.06], 0.0)
    assert told == pytest.approx(-1.1, abs=0.01), "for however long it sticks"
    _, _, told = carried(model, [0.06] + 10 * [-0.01], 0.0, noise=0.05)
    assert told < -1.7, "friction may hold it that near to the goal"


def test_a_gripped_door_that_is_brought_back_gets_on(model: Model) -> None:
    """It passed the goal and came near it then: farther away again, every step back counts."""
    away, back = [0.03, -0.01, -0.03] + 16 * [-0.06], [-0.055, -0.05, -0.045]
    stuck, returning = (carried(model, offs, 0.0)[1] for offs in (away + 3 * [-0.06], away + back))
    assert stuck.stuck_for(11.0) > 8.0
    assert returning.stuck_for(11.0) < 2.0
