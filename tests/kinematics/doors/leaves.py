"""URDFs of leaves on joints of all kinds: hinges that stand, lean or lie, of either hand, and slides, level and inclined."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

LIMITS = {"revolute": (-0.2, 1.4), "prismatic": (-0.1, 0.45)}


@dataclass(frozen=True)
class Leaf:
    """One kind: a plate that hangs at one of its edges, or slides across its face."""

    joint: str
    rpy: tuple[float, float, float]
    """Of the joint."""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    side: str = "push"
    closed: float = 0.0


LEAVES = {
    "plumb": Leaf("revolute", (0.0, 0.0, 0.4)),
    "of the other hand, pulled": Leaf("revolute", (0.0, 0.0, -2.6), (0.0, 0.0, -1.0), side="pull", closed=-0.2),
    "leaning": Leaf("revolute", (0.06, -0.03, 0.4)),
    "leaning, pulled": Leaf("revolute", (-0.05, 0.02, 2.0), side="pull"),
    "at the top": Leaf("revolute", (1.5707963267948966, 1.5707963267948966, 0.0), side="push"),
    "at the top, pulled": Leaf("revolute", (1.5707963267948966, 1.5707963267948966, -1.1), side="pull"),
    "at the bottom": Leaf("revolute", (1.5707963267948966, -1.5707963267948966, 0.7), side="pull"),
    "drawer": Leaf("prismatic", (0.0, 0.0, 0.5), (0.0, 1.0, 0.0), side="pull"),
    "pushed in": Leaf("prismatic", (0.0, 0.0, -2.5), (0.0, -1.0, 0.0), side="push"),
    "inclined": Leaf("prismatic", (0.2, 0.0, 1.0), (0.0, 1.0, 0.0), side="pull", closed=0.1),
}


def write_leaf(path: Path, leaf: Leaf) -> Path:
    """Write its URDF: 0.8 m along x of the joint, 0.03 m thick along y, 0.6 m along z."""
    lower, upper = LIMITS[leaf.joint]
    path.write_text(
        f"""<?xml version="1.0"?>
<robot name="leaf">
  <link name="frame">
    <collision name="wall"><origin xyz="0.3 0.4 9"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
  </link>
  <joint name="hinge" type="{leaf.joint}">
    <origin xyz="0.3 -0.4 1.5" rpy="{" ".join(map(str, leaf.rpy))}"/>
    <parent link="frame"/><child link="leaf"/>
    <axis xyz="{" ".join(map(str, leaf.axis))}"/>
    <limit lower="{lower}" upper="{upper}" effort="0" velocity="10"/>
    <dynamics damping="0.5" friction="0.8"/>
  </joint>
  <link name="leaf">
    <inertial>
      <origin xyz="0.4 0.02 0.3"/><mass value="1.5"/>
      <inertia ixx="0.05" ixy="0.001" ixz="0.002" iyy="0.13" iyz="0.003" izz="0.085"/>
    </inertial>
    <collision name="leaf"><origin xyz="0.4 0.01 0.3"/><geometry><box size="0.8 0.03 0.6"/></geometry></collision>
  </link>
</robot>
""",
        encoding="utf-8",
    )
    return path
