"""Lead of the commanded pitch after the grip: the settings, cut where an arm with mass leaves the rotors less."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from urdf_variants import write_massive

from doorman.control.engagement import Engagement
from doorman.model import Model
from doorman.scenario import Scenario

SHARES = {"servo_1": 0.2, "servo_2": 0.2, "servo_3": 0.25, "servo_4": 0.25}
"""Of the arm's mass."""


def engagement(tmp_path: Path, mass: float, lag: float = 0.1) -> Engagement:
    urdf = write_massive(tmp_path / f"{mass}.urdf", {link: mass * share for link, share in SHARES.items()})
    return Engagement(Model(Scenario.load("paper", {"vehicle.urdf": str(urdf), "vehicle.attitude_lag": lag})))


def test_an_arm_without_mass_has_the_settings(model: Model) -> None:
    lead = Engagement(model)
    assert (lead.lead(0.0), lead.lead(2.0)) == (0.1, 0.5)


def test_a_heavier_arm_is_led_less(tmp_path: Path) -> None:
    leads = [engagement(tmp_path, mass).lead(0.0) for mass in (0.05, 0.3, 0.6, 0.9)]
    assert leads == sorted(leads, reverse=True) and leads[0] <= 0.1
    assert 0.02 < leads[-1] < 0.07


def test_a_softer_attitude_loop_may_be_led_farther(tmp_path: Path) -> None:
    usual, soft = engagement(tmp_path, 0.9), engagement(tmp_path, 0.9, lag=0.1 * math.sqrt(1.4))
    assert soft.lead(0.0) == pytest.approx(1.4 * usual.lead(0.0))
    assert soft.lead(1.0) == pytest.approx(1.4 * usual.lead(1.0))
