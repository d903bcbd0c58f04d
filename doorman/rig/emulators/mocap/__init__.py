"""Emulated cameras: Vicon Tracker."""

from doorman.rig.emulators.mocap.emulator import MocapEmulator

__all__ = ["MocapEmulator"]
