"""The polygon of the centre of mass against the mixer: on its border a rotor is at a limit, and beyond it the vehicle sinks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE, write_edited, write_massive

from doorman.arrays import frozen
from doorman.kinematics.vehicles.balance import Balance, balance_numbers, balance_of
from doorman.kinematics.vehicles.rotor_layout import RotorLayout, rotor_layout
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.simulation.plant.onboard.rotors import MixerParameters, mix

SHIPPED = rotor_layout(Vehicle(VEHICLE), 0.016)
SKEWED = RotorLayout(
    frozen([[0.3, 0.1, 0.0], [-0.05, 0.28, 0.0], [-0.25, -0.1, 0.0], [0.1, -0.3, 0.0], [-0.2, 0.2, 0.0]]),
    frozen([1.0, -1.0, 1.0, -1.0, 1.0]), frozen([9.0, 8.0, 11.0, 10.0, 9.0]), 0.02,
)  # fmt: skip


@pytest.mark.parametrize(("layout", "weight"), [(SHIPPED, 20.0), (SHIPPED, 36.0), (SKEWED, 24.0)])
def test_the_border_is_where_the_mixer_loses_lift(layout: RotorLayout, weight: float) -> None:
    balance, mixer = Balance.of(layout, weight), MixerParameters.of(layout)
    assert (balance.reaches > 0.0).all()
    for turn in np.linspace(0.0, 2.0 * math.pi, 17):
        direction = np.array([math.cos(turn), math.sin(turn)])
        closing = balance.normals @ direction
        reach = float((balance.reaches[closing > 0.0] / closing[closing > 0.0]).min())
        for share, holds in ((0.99, True), (1.03, False)):
            x, y = share * reach * direction
            wanted = np.array([weight * y, -weight * x, 0.0])
            mix(mixer, weight, wanted)
            kept = np.allclose(mixer.achieved[:3], [weight, *wanted[:2]], atol=1e-9)
            assert kept is holds
            assert bool(balance.room(np.array([x, y, 0.3])).min() > 0.0) is holds


def test_sides_of_a_regular_ring_count_once() -> None:
    assert len(Balance.of(SHIPPED, 30.0).reaches) == 6


def test_rotors_that_cannot_lift_the_weight_have_no_polygon() -> None:
    balance = Balance.of(SHIPPED, 50.0)
    assert (balance.reaches < 0.0).any()


def test_only_an_arm_with_mass_is_bounded(tmp_path: Path) -> None:
    assert balance_of(Vehicle(VEHICLE)) is None and balance_numbers(Vehicle(VEHICLE)) == {}
    massive = Vehicle(write_massive(tmp_path / "arm.urdf", {"servo_3": 0.4}))
    assert set(balance_numbers(massive)) == {
        "bodies.masses", "bodies.centers", "bodies.inertias", "balance.normals", "balance.reaches"
    }  # fmt: skip


def test_rotors_that_cannot_steer_are_left_to_the_check(tmp_path: Path) -> None:
    path = write_massive(tmp_path / "arm.urdf", {"servo_3": 0.4})
    text = path.read_text(encoding="utf-8").replace('<axis xyz="0 0 -1" />', '<axis xyz="0 0 1" />')
    path.write_text(text, encoding="utf-8")
    assert balance_of(Vehicle(write_edited(tmp_path / "v.urdf", path))) is None
