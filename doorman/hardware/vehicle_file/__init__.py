"""Vehicle file: what belongs to one vehicle and not to a task, as TOML: URDF, links, calibration, gains."""

from doorman.hardware.vehicle_file.file import VehicleFile, write_values
from doorman.hardware.vehicle_file.template import vehicle_template

__all__ = ["VehicleFile", "vehicle_template", "write_values"]
