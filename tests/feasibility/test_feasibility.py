"""`doorman check`: what is possible passes, and what is not is named with its number, its limit and what to change."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from urdf_variants import DOOR, VEHICLE, write_arm, write_door, write_edited, write_mirrored, write_moved

from doorman.collision.audit import audit
from doorman.feasibility import Finding, Report, Severity, check
from doorman.feasibility.check import audit_finding
from doorman.feasibility.inputs.setup import setup_findings
from doorman.feasibility.swing.flight import flight_findings
from doorman.feasibility.swing.geometry import geometry_findings
from doorman.feasibility.swing.rehearsal import DURATION, Rehearsal, rehearse
from doorman.feasibility.swing.room import best_swing
from doorman.model import Model
from doorman.postures.proposal import PAPER_POSTURES
from doorman.scenario import Scenario

LATCH = 4
PAPER_START = {f"start__{key}": PAPER_POSTURES[f"start.{key}"] for key in ("attitude", "arm")}


def changed(**overrides: Any) -> Model:
    """Model of the paper's task with other values; `contact__height` is `contact.height`."""
    return Model(Scenario.load("paper", {key.replace("__", "."): value for key, value in overrides.items()}))


def variant(folder: Path, *, width: float, contact: float, rod: float, **door: float) -> Model:
    """Another leaf and another rod."""
    return changed(
        door__urdf=str(write_door(folder / "door.urdf", width=width, **door)),
        vehicle__urdf=str(write_arm(folder / "arm.urdf", rod=rod)),
        contact__distance_from_hinge=contact,
    )


def named(findings: list[Finding], name: str) -> Finding:
    return Report("", tuple(findings))[name]


def errors(findings: list[Finding]) -> set[str]:
    return {finding.name for finding in Report("", tuple(findings)).errors}


@pytest.fixture(scope="module")
def report() -> Report:
    return check(Scenario.load("paper"), with_audit=True)


@pytest.fixture(scope="module")
def rehearsal(model: Model) -> Rehearsal:
    return rehearse(model)


def test_the_papers_task_is_possible(report: Report) -> None:
    assert report.possible
    assert report.scenario == "paper"
    assert [finding.name for finding in report.findings if not finding.ok] == [], "nothing is in doubt"
    assert report.audit is not None
    assert report.audit.ok


def test_infinite_limits_become_null() -> None:
    finding = Finding("a", Severity.WARNING, "1", 1.0, math.inf, "m", "change it")
    said = Report("x", (finding,)).as_dict()
    assert said["findings"][0]["limit"] is None
    assert said["possible"] is True


@pytest.mark.parametrize(
    ("width", "contact", "rod", "mass", "resistance"),
    [(1.1, 0.6, 0.35, 20.0, 0.0), (1.5, 0.55, 0.22, 20.0, 0.4)],
)
def test_doors_and_arms_that_can_be_opened(
    tmp_path: Path, width: float, contact: float, rod: float, mass: float, resistance: float
) -> None:
    """Corners of what the planner is built for; in the first one the paper's goal would be 9 cm out of bounds."""
    model = variant(tmp_path, width=width, contact=contact, rod=rod, mass=mass, damping=resistance, friction=resistance)
    flight = rehearse(model)
    findings = [*setup_findings(model), *geometry_findings(model), *flight_findings(model, flight)]
    assert errors(findings) == set()
    assert abs(flight.final_door_angle - math.pi / 9) < math.radians(1.5)


def test_a_goal_out_of_bounds_is_a_warning_with_its_rows(tmp_path: Path) -> None:
    door, arm = write_door(tmp_path / "door.urdf", width=1.1), write_arm(tmp_path / "arm.urdf", rod=0.35)
    goal = {f"goal__{key}": PAPER_POSTURES[f"goal.{key}"] for key in ("attitude", "arm")}
    model = changed(door__urdf=str(door), vehicle__urdf=str(arm), contact__distance_from_hinge=0.6, **goal)
    finding = named(setup_findings(model), "goal constraints")
    excess = model.constraints(model.goal_state)[LATCH] + model.scenario.planner.margin
    assert finding.severity is Severity.WARNING
    assert finding.value == pytest.approx(excess)
    assert f"'disc clear of latch jamb' by {100 * excess:.1f} cm" in finding.message


@pytest.mark.parametrize(
    ("overrides", "name", "severity"),
    [
        ({"vehicle__max_thrust": 29.0}, "thrust reserve", Severity.ERROR),
        ({"vehicle__max_thrust": 35.0}, "thrust reserve", Severity.ERROR),
        ({"vehicle__max_thrust": 37.0, "contact__kind": "push"}, "thrust reserve", Severity.WARNING),
        ({"contact__height": 0.01}, "contact on the leaf", Severity.WARNING),
        ({"goal__door_angle": -1.6}, "hinge limits", Severity.ERROR),
        ({"start__door_angle": 1.75}, "hinge limits", Severity.ERROR),
        ({"vehicle__radius": 0.59}, "doorway width", Severity.ERROR),
        ({"start__arm": [0.0, 1.7, -0.6, -0.4]}, "start arm", Severity.ERROR),
        ({"goal__arm": [0.0, math.pi / 2, -math.pi / 2, 1.9]}, "goal arm", Severity.ERROR),
        ({"contact__distance_from_hinge": 0.79, **PAPER_START}, "start constraints", Severity.WARNING),
        ({"door__friction": 5.5}, "hinge friction", Severity.ERROR),
        ({"door__friction": 0.5, "control__door_observer_rate": 0.0}, "hinge friction", Severity.ERROR),
        ({"vehicle__attitude_lag": 0.55}, "planner", Severity.ERROR),
        (
            {"planner__horizon_steps": 12, "vehicle__attitude_lag": 0.1, "vehicle__attitude_dead_time": 0.0},
            "planner",
            Severity.WARNING,
        ),
        ({"planner__time_step": 0.2}, "planner", Severity.WARNING),
    ],
)
def test_numbers_that_do_not_fit(overrides: dict[str, Any], name: str, severity: Severity) -> None:
    finding = named(setup_findings(changed(**overrides)), name)
    assert finding.severity is severity
    assert finding.advice


def test_a_centre_of_mass_beside_the_body(tmp_path: Path) -> None:
    for offset, severity in ((0.02, Severity.WARNING), (0.15, Severity.ERROR)):
        moved = (
            '<origin xyz="0 0 0" rpy="0 0 0"/>\n      <mass',
            f'<origin xyz="{offset} 0 0" rpy="0 0 0"/>\n      <mass',
        )
        path = write_edited(tmp_path / f"{offset}.urdf", VEHICLE, moved)
        finding = named(setup_findings(changed(vehicle__urdf=str(path))), "centre of mass")
        assert finding.severity is severity
        assert finding.value == pytest.approx(offset)


def test_a_leaf_before_its_hinge(tmp_path: Path) -> None:
    path = write_edited(tmp_path / "door.urdf", DOOR)
    written = path.read_text(encoding="utf-8")
    for middle, severity in ((0.01, Severity.OK), (0.17, Severity.WARNING)):
        path.write_text(written.replace('"0.6 -0.02 0.8"', f'"0.6 {middle} 0.8"'), encoding="utf-8")
        finding = named(setup_findings(changed(door__urdf=str(path))), "leaf's surface")
        assert finding.severity is severity
        assert finding.value == pytest.approx(middle + 0.02)


def test_a_door_is_told_as_it_was_read(tmp_path: Path) -> None:
    shipped = named(setup_findings(changed()), "door as read").message
    assert "hinge on the right" in shipped and "closed at 90.0° and falls" in shipped and "into 0°" in shipped
    moved = write_moved(tmp_path / "moved.urdf", write_mirrored(tmp_path / "left.urdf", DOOR), (1.0, 2.0, 0.0), 0.5)
    told = named(setup_findings(changed(door__urdf=str(moved))), "door as read").message
    assert "hinge on the left" in told and "into 29°" in told


def test_an_arm_too_short(tmp_path: Path) -> None:
    model = changed(vehicle__urdf=str(write_arm(tmp_path / "arm.urdf", rod=0.12)), planner__margin=0.02)
    findings = geometry_findings(model)
    assert errors(findings) == {"reach", "room along the swing"}
    reach = named(findings, "reach")
    # stretched level from servo 2: √(24² + 128²) + 124 + 120 mm ahead, 400 mm of disc
    assert reach.value == pytest.approx(math.hypot(0.024, 0.128) + 0.244 - 0.4, abs=2e-3)
    assert "an arm longer by at least 4.6 cm" in reach.advice


def test_a_swing_beyond_a_right_angle_goes_round_the_hinge_jamb() -> None:
    """That jamb is an edge there, and no bound of the whole way."""
    model = changed(goal__door_angle=-0.5)
    assert model.surroundings == "corners"
    assert errors(geometry_findings(model)) == set()
    assert changed(goal__door_angle=0.0).surroundings == "doorway"


def test_a_doorway_too_narrow(tmp_path: Path) -> None:
    findings = geometry_findings(variant(tmp_path, width=0.85, contact=0.4, rod=0.25))
    room = named(findings, "room along the swing")
    assert room.severity is Severity.ERROR
    assert "'disc clear of latch jamb'" in room.message
    assert "a wider doorway" in room.advice
    assert named(findings, "reach").ok


def test_a_doorway_without_room_for_tracking_errors_is_a_warning() -> None:
    """Flown, the disc brushes the jamb in the first; the second is opened and left with nothing touched."""
    for width, severity in ((1.05, Severity.WARNING), (1.09, Severity.OK)):
        room = named(geometry_findings(changed(door__width=width)), "room along the swing")
        assert room.severity is severity
        assert ("tracking errors of 1.0 cm" in room.message) is (severity is Severity.WARNING)


def test_a_hinge_too_stiff_for_the_tilt() -> None:
    assert named(geometry_findings(changed(door__friction=0.7)), "force on the door").value == pytest.approx(
        1.0, rel=1e-3
    )
    weak = named(
        geometry_findings(changed(door__friction=20.0, control__max_tilt=0.5, control__max_push=100.0)),
        "force on the door",
    )
    assert weak.severity is Severity.ERROR
    assert weak.limit == pytest.approx(3.0 * 9.81 * math.tan(0.5))
    spring = named(
        geometry_findings(changed(door__stiffness=8.0, control__max_tilt=0.5, control__max_push=100.0)),
        "force on the door",
    )
    assert spring.value == pytest.approx(8.0 * math.radians(70.0) / 0.7)
    assert spring.severity is Severity.WARNING


def test_room_is_what_a_blind_search_finds(tmp_path: Path, rng: np.random.Generator) -> None:
    """The minimax posture against the best of many random ones, in a doorway where it matters."""
    model = variant(tmp_path, width=1.0, contact=0.5, rod=0.25)
    swing = best_swing(model)
    k = int(np.argmin(np.abs(swing.door_angles - 1.0)))
    states = np.zeros((400_000, model.nx))
    states[:, 3] = swing.door_angles[k]
    states[:, 2] = states[:, 3] - math.pi / 2
    states[:, 5:] = rng.uniform([-0.8, 0.0, -1.65, -1.0], [0.8, 1.65, 0.0, 1.0], (len(states), model.n_arm))
    blind = -model.constraints_along(states).max(axis=1).min()  # η_1 alone turns the arm to the leaf: yaw stays
    assert swing.room[k] >= blind - 1e-6
    assert swing.room[k] <= blind + 0.01
    assert swing.connected
    np.testing.assert_allclose(-model.constraints_along(swing.states).max(axis=1), swing.room, atol=1e-12)
    assert (swing.states[:, :2] == 0.0).all()


def test_rehearsal_obeys_dynamics_and_constraints(model: Model, rehearsal: Rehearsal) -> None:
    assert not rehearsal.failure
    assert rehearsal.times[-1] == pytest.approx(DURATION)
    moving = model.door.inertia + model.vehicle.mass * model.coupling.distance_from_hinge**2
    for k in range(0, len(rehearsal.states) - 1, 37):
        before, after = rehearsal.states[k], rehearsal.states[k + 1]
        rates = model.derivative((before + after) / 2, rehearsal.inputs[k])
        rates[4] *= model.door.inertia / moving  # the vehicle moves with the leaf
        np.testing.assert_allclose((after - before) / 0.02, rates, atol=2e-3)
    h = model.constraints_along(rehearsal.states) + model.scenario.planner.margin
    assert h.max() <= 1e-4  # the planner does not know of the vehicle's mass at the contact point
    within = rehearsal.time_within(math.pi / 9, math.radians(2.0))
    assert within is not None
    assert 2.0 < within < 6.0
    assert abs(rehearsal.states[rehearsal.times > within - 0.01, 3] - math.pi / 9).max() <= math.radians(2.0)
    assert rehearsal.time_within(0.0, 0.01) is None


def test_a_start_without_any_plan_breaks_off(tmp_path: Path) -> None:
    model = variant(tmp_path, width=0.8, contact=0.4, rod=0.25)
    flight = rehearse(model)
    assert flight.failure
    goal = named(flight_findings(model, flight), "goal reached")
    assert goal.severity is Severity.ERROR
    assert flight.failure in goal.message


def test_a_pull_is_an_error_only_where_the_tip_can_push_alone(model: Model, rehearsal: Rehearsal) -> None:
    grip = named(flight_findings(model, rehearsal), "pull on the door")
    push = named(flight_findings(changed(contact__kind="push"), rehearsal), "pull on the door")
    assert grip.ok
    assert push.severity is Severity.ERROR
    assert push.value == grip.value
    assert 1.0 < push.value < 8.0  # [N]


def test_motion_beyond_what_vehicle_and_arm_can_do(model: Model, rehearsal: Rehearsal) -> None:
    findings = flight_findings(changed(vehicle__max_thrust=30.0, control__max_tilt=0.1), rehearsal)
    assert named(findings, "tilt").severity is Severity.WARNING
    assert named(findings, "thrust").severity is Severity.WARNING
    tilt = np.arccos(np.cos(rehearsal.states[:, 0]) * np.cos(rehearsal.states[:, 1])).max()
    assert named(findings, "tilt").value == pytest.approx(tilt)
    states = rehearsal.states + 1.0 * (np.arange(model.nx) == 6)
    fast = Rehearsal(rehearsal.times, states, 40.0 * rehearsal.inputs, rehearsal.normal_forces, "")
    assert {"joint limits along the swing"} <= errors(flight_findings(model, fast))
    assert named(flight_findings(model, fast), "servo rates").severity is Severity.WARNING
    assert named(flight_findings(model, fast), "servo torques").severity is Severity.WARNING


def test_a_contact_so_high_that_the_disc_meets_the_lintel(rehearsal: Rehearsal) -> None:
    finding = named(flight_findings(changed(contact__height=1.55), rehearsal), "clearance along the swing")
    assert finding.severity is Severity.ERROR
    assert "base_link" in finding.message
    assert "contact.height" in finding.advice


def test_a_failed_audit_is_a_warning(rehearsal: Rehearsal) -> None:
    """At this height the constraints allow the disc in the lintel; the swing itself stays clear of it."""
    model = changed(contact__height=1.4)
    report = audit(model.coupling, door_angles=(math.pi / 2, math.pi / 9), checks=200)
    finding = audit_finding(report)
    assert not report.ok
    assert finding.severity is Severity.WARNING
    assert finding.value == report.colliding > 0
    assert "clearance along the swing" in finding.advice
    assert named(flight_findings(model, rehearsal), "clearance along the swing").ok
