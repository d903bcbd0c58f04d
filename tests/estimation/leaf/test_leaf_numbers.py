"""The filter's numbers are keys of `[estimation]`: what a scenario gives is flown, and a default grows with the vehicle."""

from __future__ import annotations

import pytest

from doorman.estimation.leaf.numbers import TUNED, leaf_numbers
from doorman.model import Model
from doorman.scenario import Scenario


def numbers(source: str = "push", **given: float):
    return leaf_numbers(
        Model(Scenario.load(source, {key.replace("__", "."): value for key, value in given.items()})), 1e-3
    )


@pytest.mark.parametrize("source", ["push", "push_small"])
def test_what_a_scenario_gives_is_what_the_filter_goes_by(source: str) -> None:
    known = numbers(source, estimation__noise__wind=0.3)
    assert known.one("noise.wind") == 0.3


def test_lengths_forces_and_rates_grow_with_the_vehicle_and_shares_and_times_stay() -> None:
    small, usual, scale = numbers("push_small"), numbers("push"), Model("push_small").scale
    ratios = {"noise.wind": scale.force, "contact.gap": scale.length, "noise.velocity": scale.speed, "noise.rate": scale.rate,
              "contact.more": scale.torque, "contact.friction": 1.0, "contact.lasts": 1.0, "switch.jump": 1.0,
              "noise.gust": 1.0, "contact.stiffness": scale.stiffness}  # fmt: skip
    assert scale.force < 0.6
    for name, ratio in ratios.items():
        assert small.one(name) == pytest.approx(ratio * usual.one(name)), name


def test_every_tuned_number_is_known_and_no_key_is_a_constant_too() -> None:
    known = numbers()
    assert len(set(TUNED)) == len(TUNED)
    assert all(known.one(name) > 0.0 for name in TUNED)
