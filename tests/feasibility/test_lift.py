"""Lift that is left while the rotors steer: against the mixer itself."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.feasibility import Severity
from doorman.feasibility.lift import lift_findings, lift_left
from doorman.gravity import GRAVITY
from doorman.kinematics.vehicles.rotor_layout import rotor_layout
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation.plant.onboard.rotors import MixerParameters, mix


@pytest.mark.parametrize("torque", [(0.0, 0.0), (0.0, 3.0), (-1.2, 2.1), (2.4, -0.7)])
def test_the_mixer_makes_that_lift_and_no_more(model: Model, torque: tuple[float, float]) -> None:
    layout = rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)
    lift = lift_left(layout, np.array(torque))
    mixer = MixerParameters.of(layout)
    for asked, made in ((0.98 * lift, 0.98 * lift), (1.2 * lift, lift)):
        mix(mixer, asked, np.array([*torque, 0.0]))
        np.testing.assert_allclose(mixer.achieved[:3], [made, *torque], atol=1e-9)


def ratio_needed(source: str, **overrides: object) -> float:
    """Ratio of thrust and weight from which a task is not refused."""
    low, high = 1.0, 1.8
    for _ in range(9):
        ratio = 0.5 * (low + high)
        thrust = ratio * 3.0 * GRAVITY
        named = {key.replace("__", "."): value for key, value in overrides.items()}
        findings = lift_findings(Model(Scenario.load(source, {"vehicle.max_thrust": thrust, **named})))
        low, high = (ratio, high) if findings[0].severity is Severity.ERROR else (low, ratio)
    return high


def test_the_reserve_is_what_flights_need() -> None:
    """Flown: a grip sinks with 1.45 times its weight and opens the door with 1.5; a push fails with 1.1 and opens with 1.15."""
    assert 1.45 < ratio_needed("paper") < 1.5
    assert 1.1 < ratio_needed("push") < 1.15


def test_the_reserve_follows_from_the_task() -> None:
    stiff = ratio_needed("push", control__velocity_gain=[10.5, 10.5, 4.5])
    assert stiff > ratio_needed("push")
