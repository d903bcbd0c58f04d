"""Rig: the emulated autopilot, servos and cameras on their real protocols, all moved by one MuJoCo plant.

A public name brings in its module when it is first asked for: a program that wants an emulator alone loads no plant.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the types of the names below; no layer hides an import here
    from doorman.rig.emulated import Rig, RigSetup
    from doorman.rig.plant import RigPlant, Snapshot

__all__ = ["Rig", "RigPlant", "RigSetup", "Snapshot"]

_MODULES = {
    "Rig": "doorman.rig.emulated",
    "RigPlant": "doorman.rig.plant",
    "RigSetup": "doorman.rig.emulated",
    "Snapshot": "doorman.rig.plant",
}

if not TYPE_CHECKING:  # a type checker would take any name for granted

    def __getattr__(name: str) -> object:
        if name not in _MODULES:
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'", name=name)
        value = getattr(importlib.import_module(_MODULES[name]), name)
        globals()[name] = value
        return value
