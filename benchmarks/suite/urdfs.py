"""Small URDFs by the numbers: doors of any size and arms of any number of joints; what a planner reads and no more."""

from __future__ import annotations

from pathlib import Path

DOOR = """<?xml version="1.0"?>
<robot name="door">
  <link name="frame"/>
  <link name="leaf">
    <inertial>
      <origin xyz="{half:.17g} 0 {half_height:.17g}"/>
      <mass value="{mass:.17g}"/>
      <inertia ixx="{ixx:.17g}" iyy="{iyy:.17g}" izz="{izz:.17g}" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision>
      <origin xyz="{half:.17g} -0.02 {half_height:.17g}"/>
      <geometry><box size="{width:.17g} 0.04 {height:.17g}"/></geometry>
    </collision>
  </link>
  <joint name="hinge" type="revolute">
    <origin xyz="0 0 0.4"/><parent link="frame"/><child link="leaf"/><axis xyz="0 0 1"/>
    <limit lower="-0.2" upper="2" effort="100" velocity="10"/>
  </joint>
</robot>
"""

VEHICLE = """<?xml version="1.0"?>
<robot name="vehicle">
  <link name="base_link">
    <inertial>
      <mass value="3"/><inertia ixx="0.045" iyy="0.045" izz="0.08" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision>
      <origin xyz="0 0 0.0002"/><geometry><cylinder radius="0.4" length="0.0004"/></geometry>
    </collision>
  </link>
{arm}  <joint name="tip_mount" type="fixed">
    <origin xyz="{tip}"/><parent link="servo_{joints}"/><child link="tip"/>
  </joint>
  <link name="tip"/>
</robot>
"""

JOINT = """  <joint name="eta_{k}" type="revolute">
    <origin xyz="{offset}"/><parent link="{parent}"/><child link="servo_{k}"/><axis xyz="{axis}"/>
    <limit lower="-1.8" upper="1.8" effort="3.1" velocity="3.1"/>
  </joint>
  <link name="servo_{k}"/>
"""

REACH = 0.5
"""Of an arm at H = 0, ahead of the body [m]."""


def write_door(path: Path, *, width: float, mass: float, height: float = 1.6) -> Path:
    """A leaf as a thin plate in the plane of the hinge axis.

    Args:
        path: File to write.
        width: D_w [m].
        mass: Of the leaf [kg].
        height: D_h [m].

    Returns:
        The path.
    """
    about_width, about_height = mass * height**2 / 12.0, mass * width**2 / 12.0
    text = DOOR.format(
        width=width, height=height, mass=mass, half=width / 2.0, half_height=height / 2.0,
        ixx=about_width, iyy=about_width + about_height, izz=about_height,
    )  # fmt: skip
    path.write_text(text, encoding="utf-8")
    return path


def write_vehicle(path: Path, joints: int) -> Path:
    """The paper's vehicle with an arm of 2 to 7 joints that flies: yaw first, the others pitch, the tip ahead at H = 0.

    Args:
        path: File to write.
        joints: Number of joints.

    Returns:
        The path.
    """
    links = max(joints - 2, 1)  # that share the way ahead
    ahead = f"{REACH / links:.17g} 0 "
    offsets = ["0 0 -0.05", "0 0 -0.04", *["0 0 0"][: joints - 2]] + [
        ahead + ("-0.128" if k == 0 else "0") for k in range(links)
    ]
    arm, parent = "", "base_link"
    for k, offset in enumerate(offsets[:joints], start=1):
        arm += JOINT.format(k=k, offset=offset, parent=parent, axis="0 0 -1" if k == 1 else "0 -1 0")
        parent = f"servo_{k}"
    path.write_text(VEHICLE.format(arm=arm, tip=offsets[joints], joints=joints), encoding="utf-8")
    return path
