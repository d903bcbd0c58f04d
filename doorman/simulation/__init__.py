"""Simulation: a MuJoCo plant built from the same URDFs, behind the same interface as the hardware."""

from doorman.simulation.attitude_loop import AttitudeGains
from doorman.simulation.backend import SimulatedBackend
from doorman.simulation.simulator import Disturbance, Simulator
from doorman.simulation.truth import Truth

__all__ = ["AttitudeGains", "Disturbance", "SimulatedBackend", "Simulator", "Truth"]
