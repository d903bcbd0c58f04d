"""The vehicle as a backend: autopilot, servos and mocap together."""

from doorman.hardware.vehicle.backend import VehicleBackend
from doorman.hardware.vehicle.config import VehicleConfig, vehicle_config
from doorman.hardware.vehicle.links import VehicleLinks
from doorman.hardware.vehicle.places import Places
from doorman.hardware.vehicle.tip_force import TipForceSource, TipReading

__all__ = [
    "Places",
    "TipForceSource",
    "TipReading",
    "VehicleBackend",
    "VehicleConfig",
    "VehicleLinks",
    "vehicle_config",
]
