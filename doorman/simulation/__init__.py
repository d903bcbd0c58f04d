"""Simulation: a MuJoCo plant built from the same URDFs, behind the same interface as the hardware.

A name brings in its module when it is first asked for: a planner's cached kernels may name a type of this package.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from doorman.simulation.attitude_loop import AttitudeGains
    from doorman.simulation.backend import SimulatedBackend
    from doorman.simulation.simulator import Disturbance, Simulator
    from doorman.simulation.truth import Truth

__all__ = ["AttitudeGains", "Disturbance", "SimulatedBackend", "Simulator", "Truth"]

_MODULES = {
    "AttitudeGains": "attitude_loop",
    "Disturbance": "simulator",
    "SimulatedBackend": "backend",
    "Simulator": "simulator",
    "Truth": "truth",
}

if not TYPE_CHECKING:  # a type checker would take any name for granted

    def __getattr__(name: str) -> object:
        if name not in _MODULES:
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'", name=name)
        value = getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
