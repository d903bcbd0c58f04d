"""Where the tip touches a leaf if nobody says where: with room for the disc."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import write_door

from doorman.control.doorway import Doorway
from doorman.kinematics.coupling import ROOM_TO_LEVEL
from doorman.model import Model
from doorman.scenario import Scenario

OPEN_LEAF = """<robot name="leaf"><link name="base"/><joint name="hinge" type="revolute"><parent link="base"/><child link="leaf"/>
<axis xyz="0 0 1"/><limit lower="0" upper="1.6"/></joint><link name="leaf"><inertial><origin xyz="0.33 0 0.9"/><mass value="12"/>
<inertia ixx="3" ixy="0" ixz="0" iyy="3.5" iyz="0" izz="0.5"/></inertial>
<collision><origin xyz="0.33 0 0.9"/><geometry><box size="0.66 0.04 1.8"/></geometry></collision></link></robot>"""


@pytest.mark.parametrize("width", [0.6, 0.66, 0.72])
def test_a_narrow_leaf_is_pulled_where_a_jamb_leaves_room_to_let_go(width: float, tmp_path: Path) -> None:
    file = write_door(tmp_path / "door.urdf", width=width)
    task = {"door": {"urdf": str(file)}, "goal": {"opening": 1.2}}
    model = Model(Scenario(**task, contact={"kind": "grip", "side": "pull"}))
    place = model.coupling.vehicle_position([0.0, 0.0, model.start_yaw], model.start_angle, model.start_arm)
    assert Doorway(model).gap_to_jambs(place, np.zeros(3)) > ROOM_TO_LEVEL
    said = Model(Scenario(**task, contact={"kind": "grip", "side": "pull", "distance_from_hinge": width - 0.05}))
    assert said.coupling.distance_from_hinge == pytest.approx(width - 0.05), "what somebody says is kept"


def test_a_leaf_without_a_frame_fits_in_no_doorway(tmp_path: Path) -> None:
    """It is pushed where any leaf is, and not beside its hinge."""
    file = tmp_path / "leaf.urdf"
    file.write_text(OPEN_LEAF)
    model = Model(Scenario(door={"urdf": str(file), "closed": 0.0}, contact={"kind": "push"}, goal={"opening": 1.2}))
    assert model.coupling.distance_from_hinge > 0.5 * model.door.width
