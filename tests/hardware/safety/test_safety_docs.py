"""What docs/hardware/safety.md says: its rows are tests, its actions and numbers are those of the code."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
from safety_page import table

from doorman.flight.way_back import LOST_SPEED
from doorman.hardware.pixhawk.straight_way import SPEED
from doorman.hardware.safety import RULES, Action, Fault
from doorman.hardware.safety.obedience import SHAPING
from doorman.hardware.safety.observer import FORCE_LAG
from doorman.hardware.safety.supervisor import ABORT_WITHIN, ACKNOWLEDGE_WITHIN, SILENT_WITHIN
from doorman.hardware.vehicle.links import GUARD_TIMEOUT
from doorman.scenario import SafetySection

HERE = Path(__file__).parent


def names_of_tests() -> set[str]:
    paths = [
        *HERE.glob("test_*.py"),
        *(HERE.parent / "pixhawk").rglob("test_*.py"),
        *(HERE.parents[1] / "rig").glob("test_*.py"),
        *(HERE.parents[1] / "mission").rglob("test_*.py"),
    ]
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in paths)
    return {node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def test_every_row_of_the_fault_table_is_a_test():
    rows = table("Faults")
    assert len(rows) >= 25
    assert all(len(row) == 5 and all(row) for row in rows)
    assert {row[-1].strip("`") for row in rows} <= names_of_tests()


def test_every_action_is_explained():
    assert [row[0] for row in table("Safety")] == [action.name for action in Action]


def test_every_action_of_the_rules_is_in_the_table():
    told = " ".join(row[2] for row in table("Faults"))
    assert {rule.action.name for rule in RULES} <= set(re.findall(r"[A-Z]{4,}", told))


def test_times_and_speeds_are_those_of_the_code():
    assert [row[1] for row in table("Times and speeds")] == [
        f"{ABORT_WITHIN:g} s", f"{ACKNOWLEDGE_WITHIN:g} s", f"{SILENT_WITHIN:g} s", f"{GUARD_TIMEOUT:g} s",
        f"{SPEED:g} m/s", f"{LOST_SPEED:g} m/s", f"{FORCE_LAG:g} s", f"{SHAPING:g} s",
    ]  # fmt: skip


def number(value: float | tuple[float, ...]) -> str:
    return ", ".join(f"{part:g}" for part in value) if isinstance(value, tuple) else f"{value:g}"


def test_the_table_of_rules_is_that_of_the_supervisor():
    limits = SafetySection()
    expected = [
        [
            rule.fault.name, rule.words, "; ".join(f"`{key}` {number(getattr(limits, key))}" for key in rule.limits) or "–",
            f"{rule.patience:g} s", rule.action.name,
        ]
        for rule in RULES
    ]  # fmt: skip
    assert table("Rules") == expected
    used = [key for rule in RULES for key in rule.limits]
    assert sorted(used) == sorted(SafetySection.model_fields), "every limit bounds one rule"


SAME = {
    "too much tilt": Fault.TILT, "too fast": Fault.SPEED, "outside the fence": Fault.FENCE, "thrust saturated": Fault.THRUST,
    "wind or a collision push the vehicle": Fault.FORCE, "battery low": Fault.BATTERY_LOW,
    "battery nearly empty": Fault.BATTERY_CRITICAL, "servo shut down": Fault.SERVOS_FAILED,
    "servos' device unplugged": Fault.SERVOS_DISCONNECTED, "arm does not follow: servo hot": Fault.SERVOS_STOPPED,
    "the gripper does not hold, or its servo has shut down while it did": Fault.GRIPPER,
}  # fmt: skip
"""Rows of the fault table that are found as soon as a rule's patience is over."""


@pytest.mark.parametrize("words", SAME)
def test_the_fault_table_gives_the_patience_and_the_action_of_its_rule(words):
    (row,) = (row for row in table("Faults") if row[0] == words)
    (rule,) = (rule for rule in RULES if rule.fault is SAME[words])
    assert row[1] == f"{rule.patience:g} s"
    assert re.findall(r"[A-Z]{4,}", row[2])[:1] == [rule.action.name]
