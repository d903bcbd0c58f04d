"""What the check says of missions that fly through the doorway."""

from __future__ import annotations

from typing import Any

import pytest

from doorman.feasibility import Finding
from doorman.feasibility.through import through_findings
from doorman.model import Model
from doorman.scenario import Scenario


def findings(source: str, **overrides: Any) -> dict[str, Finding]:
    overrides = {"mission.then": "through"} | {key.replace("__", "."): each for key, each in overrides.items()}
    return {one.name: one for one in through_findings(Model(Scenario.load(f"shipped:{source}", overrides)))}


@pytest.mark.parametrize("opening, ok", [(1.1, False), (1.2, False), (1.45, True)])
def test_a_gap_that_is_too_narrow_is_refused(opening: float, ok: bool) -> None:
    assert findings("through", goal__opening=opening)["way through"].ok is ok


@pytest.mark.parametrize("torques, ok", [
    ({"simulation__door_preload": 0.4}, True),
    ({"simulation__door_preload": 0.6}, False),
    ({"simulation__door_stiffness": 0.3}, True),
    ({"simulation__door_stiffness": 0.5}, False),
    ({"simulation__door_stiffness": 0.5, "simulation__door_rest_angle": 0.2}, True),
    ({"door__preload": 1.0}, False),
])  # fmt: skip
def test_a_door_that_shuts_by_itself_is_refused(torques: dict[str, float], ok: bool) -> None:
    """The scenario's hinge holds with 0.5 N m, and stands 1.4 rad from where a closer's spring is relaxed."""
    assert findings("through", **torques)["stays open"].ok is ok


@pytest.mark.parametrize("arm, short", [([0.0, 1.0, -0.6, -0.4], False), ([0.0, 2.0, -1.0, -0.5], True)])
def test_the_reason_says_whether_the_arm_could_hold_the_leaf_meanwhile(arm: list[float], short: bool) -> None:
    message = findings("through", simulation__door_preload=0.6, start__arm=arm)["stays open"].message
    assert ("the arm is too short" in message) is short


def test_a_pulled_door_shuts_the_other_way() -> None:
    assert not findings("pull", simulation__door_preload=0.6)["stays open"].ok
    assert findings("pull", simulation__door_preload=0.4)["stays open"].ok


def test_a_drawer_has_no_doorway() -> None:
    assert not findings("drawer")["way through"].ok


def test_other_missions_need_no_way_through() -> None:
    assert not findings("push", mission__then="return")
