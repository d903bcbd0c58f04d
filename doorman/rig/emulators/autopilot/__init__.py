"""An emulated autopilot, PX4 or ArduPilot: MAVLink on loopback, rules, estimator, controller and plant."""

from doorman.rig.emulators.autopilot.emulator import EmulatedAutopilot

__all__ = ["EmulatedAutopilot"]
