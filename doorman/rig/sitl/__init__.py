"""Autopilots' own code as the rig's autopilot: PX4 and ArduPilot fly the rig's plant."""
