"""Standard messages of ROS 2 as DDS carries them: field by field those of the packages that they name.

DDS knows `geometry_msgs/msg/Point` as `geometry_msgs::msg::dds_::Point_`, and the topic `/a` as `rt/a`.
"""

from __future__ import annotations

from typing import Any

from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint8, uint32


def _message(package: str, kind: str, /, **fields: Any) -> Any:
    return make_idl_struct(kind, f"{package}.msg.dds_.{kind}_", fields)


Time = _message("builtin_interfaces", "Time", sec=int32, nanosec=uint32)
Duration = _message("builtin_interfaces", "Duration", sec=int32, nanosec=uint32)
Clock = _message("rosgraph_msgs", "Clock", clock=Time)
Header = _message("std_msgs", "Header", stamp=Time, frame_id=str)
String = _message("std_msgs", "String", data=str)
ColorRGBA = _message("std_msgs", "ColorRGBA", r=float32, g=float32, b=float32, a=float32)
Point = _message("geometry_msgs", "Point", x=float64, y=float64, z=float64)
Vector3 = _message("geometry_msgs", "Vector3", x=float64, y=float64, z=float64)
Quaternion = _message("geometry_msgs", "Quaternion", x=float64, y=float64, z=float64, w=float64)
Pose = _message("geometry_msgs", "Pose", position=Point, orientation=Quaternion)
PoseStamped = _message("geometry_msgs", "PoseStamped", header=Header, pose=Pose)
PoseWithCovariance = _message("geometry_msgs", "PoseWithCovariance", pose=Pose, covariance=array[float64, 36])
Twist = _message("geometry_msgs", "Twist", linear=Vector3, angular=Vector3)
TwistWithCovariance = _message("geometry_msgs", "TwistWithCovariance", twist=Twist, covariance=array[float64, 36])
Wrench = _message("geometry_msgs", "Wrench", force=Vector3, torque=Vector3)
WrenchStamped = _message("geometry_msgs", "WrenchStamped", header=Header, wrench=Wrench)
Transform = _message("geometry_msgs", "Transform", translation=Vector3, rotation=Quaternion)
TransformStamped = _message("geometry_msgs", "TransformStamped", header=Header, child_frame_id=str, transform=Transform)
TFMessage = _message("tf2_msgs", "TFMessage", transforms=sequence[TransformStamped])
Odometry = _message(
    "nav_msgs", "Odometry", header=Header, child_frame_id=str, pose=PoseWithCovariance, twist=TwistWithCovariance
)
Path = _message("nav_msgs", "Path", header=Header, poses=sequence[PoseStamped])
JointState = _message(
    "sensor_msgs", "JointState",
    header=Header, name=sequence[str], position=sequence[float64], velocity=sequence[float64], effort=sequence[float64],
)  # fmt: skip
CompressedImage = _message("sensor_msgs", "CompressedImage", header=Header, format=str, data=sequence[uint8])
UVCoordinate = _message("visualization_msgs", "UVCoordinate", u=float32, v=float32)
MeshFile = _message("visualization_msgs", "MeshFile", filename=str, data=sequence[uint8])
Marker = _message(
    "visualization_msgs", "Marker",
    header=Header, ns=str, id=int32, type=int32, action=int32, pose=Pose, scale=Vector3, color=ColorRGBA,
    lifetime=Duration, frame_locked=bool, points=sequence[Point], colors=sequence[ColorRGBA], texture_resource=str,
    texture=CompressedImage, uv_coordinates=sequence[UVCoordinate], text=str, mesh_resource=str, mesh_file=MeshFile,
    mesh_use_embedded_materials=bool,
)  # fmt: skip
MarkerArray = _message("visualization_msgs", "MarkerArray", markers=sequence[Marker])
