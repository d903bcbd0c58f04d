"""The supervisor at the limits of the documented rules, on its own clock: just below nothing happens, just above the action."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from observations import BROKEN, GOOD

from doorman.hardware.safety import RULES, Action, Fault, Observation, Supervisor
from doorman.hardware.safety.rules import ACTIONS
from doorman.hardware.vehicle import VehicleLinks, vehicle_config
from doorman.model import Model
from doorman.scenario import Scenario

PAGE = (Path(__file__).parents[3] / "docs" / "hardware" / "safety.md").read_text(encoding="utf-8")
TABLE = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in PAGE.split("# Rules\n", 1)[1].split("\n## ", 1)[0].splitlines()
    if line.startswith("|")
][2:]
"""Cells of the documented rules, row by row."""
ROWS = {Fault[row[0]]: (float(row[3].removesuffix(" s")), Action[row[4]]) for row in TABLE}
"""Patience [s] and action of every rule, as documented."""
AT = (-1.0, 0.7, 1.3)
BOUNDS: list[tuple[Fault, str, Any, Any]] = [
    (Fault.TILT, "tilt", 0.599, 0.601),
    (Fault.DIVERGENCE, "divergence", 0.149, 0.151),
    (Fault.POSE_LATE, "pose_age", 0.99, 1.01),
    (Fault.INCONSISTENT, "misfit", 2.99, 3.01),
    (Fault.DISOBEDIENCE, "disobedience", 0.199, 0.201),
    (Fault.BATTERY_CRITICAL, "battery", 0.101, 0.099),
    (Fault.BATTERY_LOW, "battery", 0.201, 0.199),
    (Fault.CONTROLLER, "command_age", 0.249, 0.251),
    (Fault.SPEED, "speed", 1.499, 1.501),
    (Fault.FORCE, "force", 17.99, 18.01),
    (Fault.THRUST, "thrust_share", 0.949, 0.951),
    (Fault.DEADLINES, "missed_ticks", 0.499, 0.501),
    *(
        (Fault.FENCE, "position", np.where(np.arange(3) == axis, end - 0.001 * side, AT),
         np.where(np.arange(3) == axis, end + 0.001 * side, AT))
        for axis, ends in enumerate(((-3.0, 3.0), (-2.5, 3.5), (0.0, 3.0)))
        for end, side in zip(ends, (-1.0, 1.0), strict=True)
    ),
]  # fmt: skip
"""A figure that a rule bounds, just inside and just outside."""


class Watch:
    """A supervisor of links that are not open, a mission that it may ask, and a clock."""

    def __init__(self, links: VehicleLinks) -> None:
        self.links, self.seen, self.asked = links, GOOD, []
        self.supervisor = Supervisor(links, lambda: self.seen)
        self.supervisor.watch_mission(self.asked.append)
        links.release()

    def look(self, seen: Observation, at: float) -> Action | None:
        """Action so far, after what is seen at a time [s]."""
        self.seen = replace(seen, now=GOOD.now + at)
        self.supervisor.look_once()
        return self.supervisor.action

    @property
    def faults(self) -> set[Fault]:
        return {finding.fault for finding in self.supervisor.findings}


@pytest.fixture(scope="module")
def links() -> VehicleLinks:
    """Those of the shipped vehicle; the constructor touches no device."""
    return VehicleLinks(vehicle_config(Model(Scenario.load("push")), "udp:14540", "/dev/null", None))


@pytest.fixture
def watch(links: VehicleLinks) -> Iterator[Watch]:
    """A flight that has been good for a second."""
    made = Watch(links)
    for tick in range(51):
        assert made.look(GOOD, 0.02 * tick) is None
    yield made
    links.release()


def test_every_rule_is_documented():
    assert set(ROWS) == set(BROKEN) == {rule.fault for rule in RULES} and set(ACTIONS) == set(Fault)
    assert {fault for fault, *_ in BOUNDS} == {Fault[row[0]] for row in TABLE if row[2] != "–"}


@pytest.mark.parametrize("fault", ROWS, ids=lambda fault: fault.name.lower())
def test_the_action_follows_when_the_patience_is_over_and_not_before(watch, fault):
    patience, action = ROWS[fault]
    bad = replace(GOOD, **BROKEN[fault])
    if patience > 0.0:
        for share in (0.0, 0.5, 0.99):
            assert watch.look(bad, 2.0 + share * patience) is None, f"{share} of the patience"
    assert watch.look(bad, 2.0 + 1.001 * patience) is action
    assert fault in watch.faults
    asks = action is Action.ABORT
    assert watch.asked == ([fault.value] if asks else []), "only ABORT asks the mission"
    assert (watch.links.inhibited is None) == asks, "all else takes the vehicle from it"


@pytest.mark.parametrize(
    ("fault", "figure", "inside", "outside"), BOUNDS, ids=lambda value: getattr(value, "name", None)
)
def test_a_figure_just_inside_its_limit_is_none_and_just_outside_is_a_fault(watch, fault, figure, inside, outside):
    patience, action = ROWS[fault]
    for at in (0.0, 1.0, 5.0):
        watch.look(replace(GOOD, **{figure: inside}), 2.0 + at * max(patience, 0.1))
    assert fault not in watch.faults
    good_again = 8.0
    watch.look(replace(GOOD, **{figure: outside}), good_again)
    assert fault not in watch.faults
    assert watch.look(replace(GOOD, **{figure: outside}), good_again + 1.001 * patience) is action
    assert fault in watch.faults


def test_the_reason_is_the_fault_that_came_first(watch):
    """A second fault with the same action follows from the first one, as a rule; a graver one replaces it."""
    first, second, graver = (replace(GOOD, **BROKEN[fault]) for fault in (Fault.SPEED, Fault.FENCE, Fault.TILT))
    for seen, at, reason in ((first, 2.0, Fault.SPEED), (second, 2.5, Fault.SPEED), (graver, 3.0, Fault.TILT)):
        watch.look(seen, at)  # all within the time in which somebody must fly the vehicle back
        watch.look(seen, at + 0.15)
        assert watch.supervisor.reason == reason.value
    assert {Fault.SPEED, Fault.FENCE, Fault.TILT} <= watch.faults
