"""A stick for an arm: no servos, no section of them, and a vehicle file that works."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import VEHICLE

from doorman.cli.vehicles.vehicle_file import new_file
from doorman.hardware.vehicle import VehicleLinks
from doorman.hardware.vehicle_file import VehicleFile
from doorman.model import Model


@pytest.fixture
def stick(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> VehicleFile:
    """The shipped vehicle with its arm fixed, and the vehicle file that `doorman vehicle new` writes for it."""
    monkeypatch.chdir(tmp_path)
    text = VEHICLE.read_text()
    for joint in range(1, 5):
        text = text.replace(f'<joint name="eta_{joint}" type="revolute">', f'<joint name="eta_{joint}" type="fixed">')
    Path("stick.urdf").write_text(text)
    new_file(Path("stick.toml"), "stick.urdf", "base_link", "tip", every_key=False)
    return VehicleFile.load("./stick.toml")


def test_a_new_file_of_a_stick_has_no_servos_and_flies(stick: VehicleFile) -> None:
    assert stick.path is not None and "[servos]" not in stick.path.read_text()
    model = Model(stick.scenario("push"))
    config = stick.links(model)
    assert (model.n_arm, config.n_arm, config.gripper) == (0, 0, False)
    links = VehicleLinks(config)
    links.move_arm(np.zeros(0), closed=False)
    links.let_go()
    sample = links.servos.read()
    assert sample.fresh and not sample.fault and sample.angles.shape == (0,)
