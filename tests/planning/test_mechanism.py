"""Mechanisms in symbols: contact point, normal and lever of any axis, the paper's door among them."""

import math
from pathlib import Path
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from paper_door import door_normal
from urdf_variants import write_edited

from doorman.model import Model
from doorman.planning.mechanism import Mechanism, Prismatic, Revolute, mechanism_in_symbols
from doorman.planning.mechanism_numbers import mechanism_numbers
from doorman.resources import urdf_directory
from doorman.scenario import Scenario


def unit(generator: np.random.Generator) -> np.ndarray:
    vector = generator.standard_normal(3)
    return vector / np.linalg.norm(vector)


def at(mechanism: Mechanism, name: str, *arguments: object) -> np.ndarray:
    return np.array(ca.DM(getattr(mechanism, name)(*arguments))).ravel()


def some(kind: str, generator: np.random.Generator) -> Mechanism:
    axis = unit(generator)
    return Prismatic(axis) if kind == "slide" else Revolute(axis, ca.DM(generator.standard_normal(3)))


@pytest.mark.parametrize("kind", ["hinge", "slide"])
def test_lever_is_how_a_point_moves(kind: str) -> None:
    generator = np.random.default_rng(3)
    for _ in range(5):
        mechanism, q, step = some(kind, generator), generator.uniform(-1.5, 1.5), 1e-6
        point = ca.DM(generator.standard_normal(3))
        moved = at(mechanism, "moved", q + step, point) - at(mechanism, "moved", q - step, point)
        lever = at(mechanism, "lever", ca.DM(at(mechanism, "moved", q, point)))
        np.testing.assert_allclose(lever, moved / (2.0 * step), atol=1e-8)


def test_a_hinge_carries_lengths_and_angles() -> None:
    generator = np.random.default_rng(4)
    mechanism, one, other = some("hinge", generator), unit(generator), unit(generator)
    turned = [at(mechanism, "carried", 0.7, ca.DM(each)) for each in (one, other)]
    assert turned[0] @ turned[1] == pytest.approx(one @ other, abs=1e-12)
    assert np.linalg.norm(turned[0]) == pytest.approx(1.0, abs=1e-12)


def test_the_papers_door_is_a_hinge_upwards() -> None:
    model = Model("push")
    away, height = model.coupling.distance_from_hinge, model.coupling.height
    hinge = model.door.hinge_position
    door, touched = Revolute([0.0, 0.0, 1.0], ca.DM(hinge)), ca.DM(hinge + [away, 0.0, height])
    for angle in (0.2, 1.0, np.pi / 2):
        np.testing.assert_allclose(
            at(door, "moved", angle, touched), model.door.contact_point(angle, away, height), atol=1e-12
        )
        np.testing.assert_allclose(at(door, "carried", angle, ca.DM([0, 1, 0])), -door_normal(angle), atol=1e-12)


def leaning(folder: Path) -> str:
    """A door whose hinge leans by 3 degrees."""
    plumb = '<origin xyz="0 0 0.01" rpy="0 0 1.5707963267948966"/>'
    leans = plumb.replace('rpy="0 0', 'rpy="0.05 0.02')
    return str(write_edited(folder / "leaning.urdf", urdf_directory() / "door_with_handle.urdf", (plumb, leans)))


@pytest.mark.parametrize("leaf", ["leans", "slides", "lies"])
def test_a_leaf_in_symbols_is_the_doors_own(leaf: str, tmp_path: Path) -> None:
    """Contact point, face, lever and weight of every kind of leaf, against `Door`, which Pinocchio checks."""
    slides = {"start.opening": 0.3, "goal.opening": 0.0}
    tasks = {"leans": ("pull", {"door.urdf": leaning(tmp_path)}), "slides": ("drawer", slides), "lies": ("hatch", {})}
    name, keys = tasks[leaf]
    model = Model(Scenario.load(f"shipped:{name}", keys))
    door, away = model.door, model.coupling.distance_from_hinge
    numbers = SimpleNamespace(
        **{key.partition(".")[2]: ca.DM(np.atleast_1d(each)) for key, each in mechanism_numbers(model).items()}
    )
    mechanism = mechanism_in_symbols(numbers)
    for angle in (0.4, 1.2, math.pi / 2, 1.9):
        point = at(mechanism, "moved", angle, numbers.point)
        np.testing.assert_allclose(point, model.coupling.contact_point(angle), atol=1e-9)
        np.testing.assert_allclose(at(mechanism, "carried", angle, numbers.normal), -door.normal(angle), atol=1e-9)
        np.testing.assert_allclose(
            at(mechanism, "carried", angle, numbers.along), door.leaf_direction(angle), atol=1e-9
        )
        np.testing.assert_allclose(at(mechanism, "lever", ca.DM(point)), door.lever(angle, away), atol=1e-9)
        torque = at(mechanism, "weight_torque", angle, numbers.center, numbers.weight)[0]
        assert torque == pytest.approx(door.weight_torque(angle), abs=1e-6)
    assert leaf == "slides" or abs(torque) > 0.1
