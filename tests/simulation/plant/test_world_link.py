"""A link called `world` that hangs on another one stands in the plant where its joint puts it."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from urdf_variants import DOOR, write_edited

from doorman.simulation.plant.hulls import read_spec


def test_a_link_called_world_keeps_its_place(tmp_path: Path) -> None:
    path = write_edited(
        tmp_path / "door.urdf", DOOR, ('<link name="frame">', '<link name="world">'),
        ('<parent link="frame"/>', '<parent link="world"/>'),
        ("</robot>", '<link name="map"/><joint name="place" type="fixed"><origin xyz="2 -1 0.3" rpy="0 0 1.2"/>'
         '<parent link="map"/><child link="world"/></joint></robot>'),
    )  # fmt: skip
    places = []
    for urdf in (path, DOOR):
        spec = read_spec(mujoco, urdf)
        spec.compiler.balanceinertia = True  # the shipped leaf's inertia is rounded
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        places.append(data.geom_xpos[np.argsort(model.geom_size.prod(axis=1))])
    turn = np.array([[np.cos(1.2), -np.sin(1.2), 0.0], [np.sin(1.2), np.cos(1.2), 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(places[0], places[1] @ turn.T + [2.0, -1.0, 0.3], atol=1e-9)
