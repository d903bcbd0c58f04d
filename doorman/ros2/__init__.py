"""ROS 2 without a ROS installation: a process of its own between a flight and the ROS graph, by DDS."""

from doorman.ros2.feed import Feed

__all__ = ["Feed"]
