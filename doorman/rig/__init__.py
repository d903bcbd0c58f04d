"""Rig: the emulated autopilot, servos and cameras on their real protocols, all moved by one MuJoCo plant."""

from doorman.rig.emulated import Rig, RigSetup
from doorman.rig.plant import RigPlant, Snapshot
from doorman.rig.witness import judge

__all__ = ["Rig", "RigPlant", "RigSetup", "Snapshot", "judge"]
