"""Give the vehicle an arm of another length: write its URDF, and let doorman find the postures."""

import tempfile
from pathlib import Path

from doorman import Model, Scenario
from doorman.resources import urdf_directory

urdf = (urdf_directory() / "hexarotor_arm.urdf").read_text()
mount = '<joint name="tip_mount" type="fixed">\n    <origin xyz="0.25 0 0"'
with tempfile.TemporaryDirectory() as folder:
    longer = Path(folder) / "longer_arm.urdf"
    longer.write_text(urdf.replace(mount, mount.replace("0.25", "0.28")))
    model = Model(Scenario.load("paper", overrides={"vehicle.urdf": str(longer), "start.arm": None, "goal.arm": None}))
    for name, joints in (("start", model.start_arm), ("goal", model.goal_arm)):
        print(
            f"{name}: joints {joints.round(2)} rad, tip {model.vehicle.tip_position(joints).round(3)} m in the body frame"
        )
