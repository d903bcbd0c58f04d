"""Audit of the analytic constraints by FCL: it must pass them, and fail every broken version of them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from doorman.collision.audit import TOLERANCE, AuditReport, audit, clearances_at
from doorman.collision.scene import CollisionScene
from doorman.model import Model

Array = NDArray[np.float64]

LEAF, LATCH = 3, 4
SWING = (math.pi / 2, math.pi / 9)


def small_audit(model: Model, constraints: object = None, **options: float) -> AuditReport:
    settings = {"door_angles": SWING, "draws": 400_000, "checks": 500, **options}
    return audit(model.coupling, constraints, **settings)  # type: ignore[arg-type]


def test_nothing_that_the_constraints_allow_collides(model: Model) -> None:
    report = audit(model.coupling, model.constraints_along, door_angles=SWING, max_tilt=0.5, checks=1500)
    assert report.ok, report.reason
    assert report.allowed >= 4000
    assert report.colliding == 0
    assert report.worst is None
    assert "none of" in report.reason
    assert 0.0 < report.forbidden_free_share < 0.7


def test_the_papers_misprinted_doorframe_bound_fails(model: Model) -> None:
    """The paper prints D_V sin α + R_A + D_w ≤ (R d)_y; the arm is not that long, so that it allows nothing at all."""

    def misprinted(states: Array) -> Array:
        h = model.constraints_along(states)
        h[:, LATCH] += 2.0 * model.door.width
        return h

    report = small_audit(model, misprinted)
    assert not report.ok
    assert report.allowed == report.colliding == 0
    assert report.worst is None
    assert report.reason.startswith("none of")
    assert "are allowed" in report.reason
    assert report.forbidden_free_share == 1.0


@pytest.mark.parametrize(
    ("row", "loosened", "pair"),
    [
        (LEAF, 0.03, ("base_link", "leaf/leaf")),
        (LATCH, 0.05, ("base_link", "frame/jamb_latch")),
        (2, 0.3, ("servo_4", "base_link")),
    ],
)
def test_a_loosened_row_is_found_out(model: Model, row: int, loosened: float, pair: tuple[str, str]) -> None:
    def loose(states: Array) -> Array:
        h = model.constraints_along(states)
        h[:, row] -= loosened
        return h

    report = small_audit(model, loose)
    assert not report.ok
    assert report.colliding > 0
    assert report.worst is not None
    assert "collide" in report.reason
    state = np.array(report.worst.state)
    assert loose(state[None]).max() <= 0.0  # it is allowed …
    again = clearances_at(CollisionScene(model.vehicle, model.door), model.coupling, state[None]).worst
    assert again.distance == pytest.approx(-report.worst.depth)  # … and it does collide
    assert report.worst.depth > TOLERANCE
    assert (report.worst.first, report.worst.second) == pair


def test_beyond_the_stated_tilt_an_elbow_comes_through_the_leaf(model: Model) -> None:
    """The documented limit of the guarantee: 0.68 rad for the shipped vehicle."""
    report = small_audit(model, max_tilt=0.85)
    assert not report.ok
    assert report.worst is not None
    assert report.worst.second == "leaf/leaf"
    assert report.worst.first in ("servo_3", "servo_4")
    roll, pitch = report.worst.state[:2]
    assert math.acos(math.cos(roll) * math.cos(pitch)) > 0.68


def test_too_few_allowed_configurations_are_no_proof(model: Model) -> None:
    def almost_nothing(states: Array) -> Array:
        return np.where(np.abs(states[:, :1] - 0.1) < 0.002, model.constraints_along(states), 1.0)

    report = small_audit(model, almost_nothing, draws=100_000)
    assert not report.ok
    assert report.colliding == 0
    assert report.reason.startswith("only ")


def test_same_seed_same_report(model: Model) -> None:
    first, second = (small_audit(model, checks=100, seed=3).as_dict() for _ in range(2))
    assert first == second
    assert first != small_audit(model, checks=100, seed=4).as_dict()
    assert json.loads(json.dumps(first, allow_nan=False))["ok"] is True
