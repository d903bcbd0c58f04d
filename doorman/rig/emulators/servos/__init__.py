"""Emulated DYNAMIXEL servos: protocol 2.0 byte for byte on a pseudo-terminal."""

from doorman.rig.emulators.servos.emulator import ServoEmulator

__all__ = ["ServoEmulator"]
