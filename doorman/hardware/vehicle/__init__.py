"""The vehicle as a backend: autopilot, servos and mocap together."""

from doorman.hardware.vehicle.backend import VehicleBackend
from doorman.hardware.vehicle.config import VehicleConfig, vehicle_config
from doorman.hardware.vehicle.links import VehicleLinks
from doorman.hardware.vehicle.places import Places

__all__ = ["Places", "VehicleBackend", "VehicleConfig", "VehicleLinks", "vehicle_config"]
