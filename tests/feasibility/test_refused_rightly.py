"""Files that the check refuses, and why it is right to.

`contact_near_latch`: a leaf of 1.2 m with the tip 0.2 m from its latch edge. On the way, the disc of 0.4 m must pass between the
leaf and the latch jamb. At 60° no level posture of the arm leaves it more than 3 mm from both, though the exact shapes count here
and not the planes of the planner; `planner.margin` is 3 cm. With the tip 0.35 m from the edge it has 4.4 cm.

`hatch`: a leaf whose axis is the normal of its face turns in its own plane. Its weight drives it on with more than 10 times the
torque that the vehicle's tilt makes at the edge.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from doorman.feasibility import Severity
from doorman.feasibility.report import Finding
from doorman.feasibility.swing.geometry import geometry_findings
from doorman.model import Model
from doorman.scenario import Scenario

HATCH = """<robot name="hatch"><link name="frame">
<collision><origin xyz="-0.06 -0.06 1.04"/><geometry><box size="0.12 0.1 2.08"/></geometry></collision>
<collision><origin xyz="-0.06 1.26 1.04"/><geometry><box size="0.12 0.1 2.08"/></geometry></collision></link>
<joint name="hinge" type="revolute"><origin xyz="0 0 0.4"/><parent link="frame"/><child link="leaf"/><axis xyz="0 1 0"/>
<limit lower="-1.5" upper="1.7" effort="0" velocity="10"/><dynamics damping="0.3" friction="0.5"/></joint>
<link name="leaf"><inertial><origin xyz="0.6 0 0.8"/><mass value="11"/>
<inertia ixx="2.3467" ixy="0" ixz="0" iyy="3.6667" iyz="0" izz="1.32"/></inertial>
<collision><origin xyz="0.6 -0.02 0.8"/><geometry><box size="1.2 0.04 1.6"/></geometry></collision></link></robot>"""


def model_of(**keys: object) -> Model:
    return Model(Scenario.load("paper", {key.replace("__", "."): value for key, value in keys.items()}))


def found(model: Model) -> dict[str, Finding]:
    return {one.name: one for one in geometry_findings(model)}


def widest(model: Model, longest: float, angle: float) -> float:
    """Most that the disc can stay from leaf and latch jamb, of all places from which the tip reaches the leaf [m]."""
    radius, contact = (
        model.vehicle.radius,
        model.coupling.distance_from_hinge * np.array([np.cos(angle), np.sin(angle)]),
    )
    normal = np.array([np.sin(angle), -np.cos(angle)])
    reach = np.linspace(0.3, longest, 60)[:, None, None]
    headings = angle - math.pi / 2 + np.linspace(-1.2, 1.2, 481)
    away = reach * np.column_stack([np.cos(headings), np.sin(headings)])
    center = contact - away
    jamb = np.array([-0.06, model.door.width + 0.04]), np.array([0.06, 0.04])
    beside = np.linalg.norm(np.maximum(np.abs(center - jamb[0]) - jamb[1], 0.0), axis=2)
    return float(np.minimum(away @ normal, beside).max()) - radius


@pytest.mark.parametrize(("distance", "fits"), [(1.0, False), (0.85, True)])
def test_a_tip_near_the_latch_leaves_the_disc_no_room_at_the_jamb(distance: float, fits: bool) -> None:
    model = model_of(contact__distance_from_hinge=distance)
    findings = found(model)
    longest = model.vehicle.radius + float(findings["reach"].value or 0.0)
    room = min(widest(model, longest, math.radians(angle)) for angle in range(20, 91, 5))
    assert (room > model.scenario.planner.margin) is fits and (fits or room < 0.01)
    assert (findings["room along the swing"].severity is not Severity.ERROR) is fits


def test_a_heavy_leaf_that_turns_in_its_own_plane_is_not_held(tmp_path: Path) -> None:
    (tmp_path / "hatch.urdf").write_text(HATCH, encoding="utf-8")
    model = model_of(door__urdf=str(tmp_path / "hatch.urdf"))
    force = found(model)["force on the door"]
    assert force.severity is Severity.ERROR and force.value > 10.0 * force.limit
    weight = max(abs(model.door.weight_torque(angle)) for angle in np.linspace(model.start_angle, model.goal_angle, 50))
    assert weight == pytest.approx(11.0 * 9.81 * math.hypot(0.6, 0.8), rel=0.3)
