"""Commands that set up a computer, an autopilot or ROS 2."""
