"""Radius of the rotor disc: from shapes of the body, or from rotors and propellers where these do not tell it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE, write_edited

from doorman.exceptions import UrdfError
from doorman.kinematics.vehicles.vehicle import Vehicle

HUB = 0.275
DISC = '<cylinder radius="0.40" length="0.0004"/>'
PROPELLERS = (
    r'\s*<visual>\s*<origin xyz="0 0 0.041"[^>]*/>\s*<geometry><[^>]*/></geometry>\s*<material[^>]*/>\s*</visual>'
)
MOTORS = r'\s*<visual>\s*<origin xyz="0 0 0.024"[^>]*/>\s*<geometry><[^>]*/></geometry>\s*<material[^>]*/>\s*</visual>'


def vehicle(path: Path, text: str) -> Vehicle:
    path.write_text(text, encoding="utf-8")
    return Vehicle(path)


def hub_only(text: str) -> str:
    assert DISC in text
    return text.replace(DISC, '<cylinder radius="0.12" length="0.05"/>')


def test_a_hub_does_not_tell_the_radius(tmp_path: Path) -> None:
    text = hub_only(VEHICLE.read_text(encoding="utf-8"))
    assert vehicle(tmp_path / "v.urdf", text).radius == pytest.approx(HUB + 0.1194, abs=1e-6)
    larger = text.replace('<cylinder radius="0.1194"', '<cylinder radius="0.13"')
    assert vehicle(tmp_path / "l.urdf", larger).radius == pytest.approx(HUB + 0.13, abs=1e-6)


def test_without_any_shape_of_the_body_rotors_tell_it(tmp_path: Path) -> None:
    text = re.sub(r"<collision>.*?</collision>", "", VEHICLE.read_text(encoding="utf-8"), count=1, flags=re.DOTALL)
    assert vehicle(tmp_path / "v.urdf", text).radius == pytest.approx(HUB + 0.1194, abs=1e-6)


@pytest.mark.parametrize("kind", ["fixed", "continuous"])
def test_shapes_of_rotors_count_whether_they_turn_or_not(tmp_path: Path, kind: str) -> None:
    fixed = '" type="fixed">\n    <origin xyz="0.0'
    text = hub_only(VEHICLE.read_text(encoding="utf-8"))
    text = text.replace(fixed, fixed.replace("fixed", kind))
    assert kind == "fixed" or kind in text
    shape = '<collision><geometry><cylinder radius="0.15" length="0.01"/></geometry></collision>'
    text = text.replace('<link name="rotor_2">', f'<link name="rotor_2">{shape}')
    assert vehicle(tmp_path / "v.urdf", text).radius == pytest.approx(HUB + 0.15, abs=1e-6)


def test_propellers_that_are_not_shown_reach_half_way_to_the_next(tmp_path: Path) -> None:
    text = hub_only(VEHICLE.read_text(encoding="utf-8"))
    bare = re.sub(MOTORS, "", re.sub(PROPELLERS, "", text))
    assert bare.count("<visual>") < text.count("<visual>") - 17
    made = vehicle(tmp_path / "v.urdf", bare)
    assert made.radius == pytest.approx(1.5 * HUB, abs=1e-5)  # on a hexagon the next is as far as the middle
    assert made.propeller_reach == 0.0


def test_a_shape_beyond_the_rotors_axes_tells_it(tmp_path: Path) -> None:
    smaller = Vehicle(write_edited(tmp_path / "v.urdf", VEHICLE, ('radius="0.40"', 'radius="0.30"')))
    assert smaller.radius == pytest.approx(0.30, abs=1e-9)
    assert smaller.propeller_reach == pytest.approx(HUB + 0.1194, abs=1e-6)


def test_neither_shapes_nor_rotors(tmp_path: Path) -> None:
    text = re.sub(r"<collision>.*?</collision>", "", VEHICLE.read_text(encoding="utf-8"), count=1, flags=re.DOTALL)
    with pytest.raises(UrdfError) as caught:
        vehicle(tmp_path / "v.urdf", text.replace('"rotor_', '"screw_'))
    assert caught.value.field == "vehicle.radius" and caught.value.given == "none"
    assert np.isfinite(Vehicle(VEHICLE).radius)
