"""Simulation: a MuJoCo plant built from the same URDFs, behind the same interface as the hardware.

A name brings in its module on its first use: a planner's cached kernels may name a type of this package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from doorman.lazy_names import lazy_names

if TYPE_CHECKING:
    from doorman.simulation.backend import SimulatedBackend
    from doorman.simulation.plant.onboard.attitude_loop import AttitudeGains
    from doorman.simulation.simulator import Disturbance, Simulator
    from doorman.simulation.truth import Truth

__all__ = ["AttitudeGains", "Disturbance", "SimulatedBackend", "Simulator", "Truth"]

_MODULES = {
    "AttitudeGains": "plant.onboard.attitude_loop",
    "Disturbance": "simulator",
    "SimulatedBackend": "backend",
    "Simulator": "simulator",
    "Truth": "truth",
}

if not TYPE_CHECKING:  # a type checker would take any name for granted
    __getattr__, __dir__ = lazy_names(__name__, _MODULES)
