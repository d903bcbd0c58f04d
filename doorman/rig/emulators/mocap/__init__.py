"""Emulated cameras: Vicon Tracker and OptiTrack Motive."""

from doorman.rig.emulators.mocap.emulator import MocapEmulator

__all__ = ["MocapEmulator"]
