"""Mechanisms in symbols: contact point, normal and lever of any axis, the paper's door among them."""

import casadi as ca
import numpy as np
import pytest
from paper_door import door_normal

from doorman.model import Model
from doorman.planning.mechanism import Mechanism, Prismatic, Revolute


def unit(generator: np.random.Generator) -> np.ndarray:
    vector = generator.standard_normal(3)
    return vector / np.linalg.norm(vector)


def at(mechanism: Mechanism, name: str, *arguments: object) -> np.ndarray:
    return np.array(ca.DM(getattr(mechanism, name)(*arguments))).ravel()


def some(kind: str, generator: np.random.Generator) -> Mechanism:
    axis, point = unit(generator), ca.DM(generator.standard_normal(3))
    return Prismatic(axis, point) if kind == "slide" else Revolute(axis, ca.DM(generator.standard_normal(3)), point)


@pytest.mark.parametrize("kind", ["hinge", "slide"])
def test_lever_is_how_the_contact_point_moves(kind: str) -> None:
    generator = np.random.default_rng(3)
    for _ in range(5):
        mechanism, q, step = some(kind, generator), generator.uniform(-1.5, 1.5), 1e-6
        moved = at(mechanism, "contact_point", q + step) - at(mechanism, "contact_point", q - step)
        lever = at(mechanism, "lever", ca.DM(at(mechanism, "contact_point", q)))
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
    door = Revolute([0.0, 0.0, 1.0], ca.DM(hinge), ca.DM(hinge + [away, 0.0, height]))
    for angle in (0.2, 1.0, np.pi / 2):
        np.testing.assert_allclose(
            at(door, "contact_point", angle), model.door.contact_point(angle, away, height), atol=1e-12
        )
        np.testing.assert_allclose(at(door, "carried", angle, ca.DM([0, 1, 0])), -door_normal(angle), atol=1e-12)
