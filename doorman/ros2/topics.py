"""Topics that the bridge publishes: types, quality of service, frames and rates. docs/how-to/ros2.md has the table of them."""

from __future__ import annotations

from typing import NamedTuple

from cyclonedds.idl import IdlStruct

from doorman.ros2 import types as ros


class RosTopic(NamedTuple):
    """A topic. Names that begin with a slash are ROS's own; all others stand below the bridge's prefix."""

    name: str
    type: type[IdlStruct]
    frame: str
    rate: str
    what: str
    latched: bool = False
    """Whether the last message is kept for subscribers that come late: transient local."""

    @property
    def type_name(self) -> str:
        """As ROS writes it: `nav_msgs/Odometry`."""
        package, _, _, short = self.type.__idl_typename__.split(".")
        return f"{package}/{short.removesuffix('_')}"

    def under(self, prefix: str) -> str:
        """Full name of the topic."""
        return self.name if self.name.startswith("/") else f"/{prefix}/{self.name}" if prefix else f"/{self.name}"


TOPICS = (
    RosTopic("/tf", ros.TFMessage, "`map` → base link → arm; `map` → `door/` leaf", "every tick", "vehicle, arm and leaf"),
    RosTopic("/tf_static", ros.TFMessage, "the same trees", "once", "what does not move: rotors, tip, door frame", True),
    RosTopic("/robot_description", ros.String, "", "once", "URDF of the vehicle, with absolute paths of meshes", True),
    RosTopic("/clock", ros.Clock, "", "every tick of a simulation", "simulated time; all stamps are of it then"),
    RosTopic("door_description", ros.String, "", "once", "URDF of the door; RViz takes it with the TF prefix `door`", True),
    RosTopic("odometry", ros.Odometry, "`map`, twist in the base link", "every tick", "measured pose and twist"),
    RosTopic("joint_states", ros.JointState, "", "every tick", "the arm's joints, measured"),
    RosTopic("door/joint_states", ros.JointState, "", "every tick", "the door's joint, estimated"),
    RosTopic("door/measured_joint_states", ros.JointState, "", "every reading", "the door's joint, where a sensor measures it"),
    RosTopic("tip_force", ros.WrenchStamped, "`map`", "every tick", "estimated force of the tip on the leaf"),
    RosTopic("plan", ros.Path, "`map`", "up to 10 a second", "the body's path for the horizon"),
    RosTopic("markers", ros.MarkerArray, "`map`", "up to 10 a second", "the tip's force as an arrow, for RViz"),
    RosTopic("mission", ros.String, "", "when it changes", "state of the mission and its reason", True),
)  # fmt: skip
"""What is published."""
