"""A last link that ends beyond the tip's frame touches the leaf as the tip does, in the plant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from vehicles_with_blunt_tips import TIP_AT, write_with_end

LEVEL = (0.0, 0.0, 0.0)
ENDS = {"start__attitude": LEVEL, "goal__attitude": (0.0, 0.0, -1.22), "start__arm": (0.0, 1.0, -0.6, -0.4),
        "goal__arm": (0.0, 1.5708, -1.5708, 0.0)}  # fmt: skip


@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_it_pushes_as_the_tip_and_collides_with_nothing(flight, tmp_path: Path, kind: str) -> None:
    path = write_with_end(tmp_path / "vehicle.urdf", kind, {"size": "0.06 0.03 0.02"}, TIP_AT - 0.025)
    blunt = flight(vehicle__urdf=str(path), contact__kind="push", simulation__door_friction=50.0, **ENDS)
    engine, data = blunt.plant.engine_model, blunt.data
    (end,) = [k for k in blunt.plant.tip_shapes if blunt.plant.shape_name(k) == "end"]
    link = data.body("vehicle/servo_4")
    np.testing.assert_allclose(
        link.xmat.reshape(3, 3).T @ (data.geom_xpos[end] - link.xpos), [TIP_AT - 0.025, 0, 0], atol=1e-9
    )
    assert engine.body(engine.geom_bodyid[end]).name == "vehicle/tip"
    blunt.lean(5.0)
    truths = blunt.run(3.0, every=1000)
    assert truths[-1].tip_normal_force == pytest.approx(5.0, abs=0.7)
    assert not any(truth.collisions for truth in truths), [truth.collision_pairs for truth in truths]


def test_it_still_collides_with_the_frame(flight, tmp_path: Path) -> None:
    path = write_with_end(tmp_path / "vehicle.urdf", "box", {"size": "0.06 0.03 0.02"}, TIP_AT - 0.025)
    blunt = flight(vehicle__urdf=str(path), contact__kind="push", **ENDS)
    tip = blunt.data.site("tip").xpos
    lintel = blunt.data.body("door/frame").xpos + np.array([-0.06, 0.6, 2.04])
    blunt.data.qpos[:3] += lintel - tip
    seen = blunt.run(0.002)[-1].collision_pairs
    assert any("end" in pair and "leaf" not in pair for pair in seen), seen
