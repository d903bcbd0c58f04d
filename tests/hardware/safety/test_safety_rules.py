"""Every rule of the supervisor: it stays silent in a good flight, waits for its patience, and asks for its action."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from observations import BROKEN, GOOD

from doorman.exceptions import ScenarioError
from doorman.hardware.dynamixel import BusState, ServoFault
from doorman.hardware.mocap import PoseQuality
from doorman.hardware.pixhawk import Authority, EventKind
from doorman.hardware.safety import RULES, Action, Assessor, Fault, Observation
from doorman.scenario import SafetySection, Scenario

LIMITS = SafetySection()


def assess(seen: Observation, duration: float, step: float = 0.02) -> list[tuple[float, Fault, Action]]:
    """Findings with the time after which they came, while one observation lasts."""
    assessor = Assessor(LIMITS)
    times = np.arange(0.0, duration + 1e-9, step)
    return [
        (float(time), finding.fault, finding.action)
        for time in times
        for finding in assessor.assess(replace(seen, now=seen.now + time))
    ]


def test_a_good_flight_breaks_no_rule():
    assert assess(GOOD, 5.0) == []


@pytest.mark.parametrize(
    "rule", [rule for rule in RULES if rule.patience > 0.0], ids=lambda rule: rule.fault.name.lower()
)
def test_what_passes_in_time_is_no_fault(rule):
    assessor = Assessor(LIMITS)
    bad = replace(GOOD, **BROKEN[rule.fault])
    for start, between in ((0.0, GOOD), (10.0, replace(bad, armed=False)), (20.0, GOOD)):
        for seen, at in ((bad, 0.0), (bad, 0.6 * rule.patience), (between, 0.7 * rule.patience)):
            found = assessor.assess(replace(seen, now=100.0 + start + at))
            assert rule.fault not in [finding.fault for finding in found], "what lasted earlier does not count"


def test_late_poses_are_lost_poses():
    late = replace(GOOD, pose=PoseQuality.PREDICTED, conditions=frozenset({EventKind.MOCAP_LOST}))
    assert [row[1:] for row in assess(late, 1.0)] == [(Fault.POSE, Action.RETREAT)]


SILENT = frozenset({EventKind.STATE_STALE, EventKind.HEARTBEAT_LOST})


@pytest.mark.parametrize("pose", [None, PoseQuality.LOST, PoseQuality.NONE])
def test_an_autopilot_that_is_neither_heard_nor_seen_is_told_to_fly_back(pose):
    found = {row[1] for row in assess(replace(GOOD, pose=pose, conditions=SILENT), 2.0)}
    assert {Fault.STATE, Fault.HEARTBEAT} <= found and Fault.TELEMETRY not in found


@pytest.mark.parametrize("pose", [PoseQuality.MEASURED, PoseQuality.PREDICTED])
def test_an_autopilot_that_is_only_seen_is_flown_by_what_the_cameras_see(pose):
    seen = replace(GOOD, pose=pose, conditions=SILENT)
    assert assess(seen, 0.9) == []
    assert [row[1:] for row in assess(seen, 3.0)] == [(Fault.TELEMETRY, Action.ABORT)]


def test_a_link_that_comes_back_is_no_fault_for_want_of_its_next_heartbeat():
    assessor, late = Assessor(LIMITS), {EventKind.HEARTBEAT_LOST}
    looks = ((0.0, late | {EventKind.STATE_STALE}), (3.0, late), (4.0, late), (4.1, set()))
    found = [
        finding.fault
        for at, conditions in looks
        for finding in assessor.assess(replace(GOOD, now=100.0 + at, conditions=frozenset(conditions)))
    ]
    assert Fault.HEARTBEAT not in found


@pytest.mark.parametrize("between", [GOOD, replace(GOOD, authority=Authority.LOST, armed=False)])
def test_a_fault_is_found_once_while_it_lasts_and_again_when_it_comes_again(between):
    """Or in the next flight: it holds on the ground, too, and the assessor stays."""
    assessor, bad = Assessor(LIMITS), replace(GOOD, authority=Authority.LOST)
    found = [assessor.assess(replace(seen, now=100.0 + k)) for k, seen in enumerate((bad, bad, between, bad))]
    assert [[one.fault for one in findings] for findings in found] == [[Fault.PILOT], [], [], [Fault.PILOT]]


def test_the_gravest_comes_first():
    assessor, silent = Assessor(LIMITS), replace(GOOD, conditions=frozenset({EventKind.HEARTBEAT_LOST}))
    assert assessor.assess(silent) == []
    found = assessor.assess(replace(silent, now=silent.now + 2.0, authority=Authority.LOST))
    assert [finding.action for finding in found] == [Action.RELEASE, Action.RETREAT]


def test_nothing_is_found_on_the_ground():
    worst = replace(GOOD, **{name: value for change in BROKEN.values() for name, value in change.items()}, armed=False)
    assert assess(worst, 3.0) == []


def test_rules_of_the_mission_rest_while_none_flies():
    for fault in (Fault.CONTROLLER, Fault.DEADLINES, Fault.SERVOS_STOPPED, Fault.POSE_LATE):
        assert assess(replace(GOOD, **BROKEN[fault], commanding=False), 3.0) == []


def test_an_arm_that_nobody_commands_is_no_fault():
    seen = replace(GOOD, servo_state=BusState.HOLDING, servo_fault=ServoFault.COMMAND_STALE)
    assert assess(seen, 3.0) == []


@pytest.mark.parametrize(
    "name", ["speed", "tilt", "thrust_share", "force", "divergence", "disobedience", "battery", "pose_age", "misfit"]
)
def test_what_is_unknown_breaks_no_rule(name):
    assert assess(replace(GOOD, **{name: math.nan}), 3.0) == []


def test_every_limit_is_used():
    """Widening any limit beyond everything lets its fault pass: none is dead."""
    wide = {
        "fence": (((-9.0, -9.0, -9.0), (9.0, 9.0, 9.0)), Fault.FENCE), "tilt": (3.0, Fault.TILT), "speed": (9.0, Fault.SPEED),
        "force": (99.0, Fault.FORCE), "divergence": (9.0, Fault.DIVERGENCE),
        "low_battery": (0.02, Fault.BATTERY_LOW),
    }  # fmt: skip
    assert set(wide) == set(SafetySection.model_fields)
    for name, (value, fault) in wide.items():
        assessor = Assessor(LIMITS.model_copy(update={name: value}))
        bad = replace(GOOD, **BROKEN[fault])
        found = [f.fault for k in range(200) for f in assessor.assess(replace(bad, now=100.0 + 0.02 * k))]
        assert fault not in found, name
    low = Assessor(LIMITS.model_copy(update={"fence": ((-0.5, -2.0, 0.0), LIMITS.fence[1])}))
    assert [f.fault for k in range(9) for f in low.assess(replace(GOOD, now=100.0 + 0.02 * k))] == [Fault.FENCE]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"tilt": 0.0}, "safety.tilt"),
        ({"speed": math.nan}, "safety.speed"),
        ({"fence": [[5.0, 0.0, 0.0], [3.0, 3.5, 3.0]]}, "safety"),
    ],
)
def test_limits_are_checked(change, field):
    with pytest.raises(ScenarioError) as error:
        Scenario.load("paper", {f"safety.{name}": value for name, value in change.items()})
    assert error.value.field == field
    assert all(name in str(error.value) for name in change)
