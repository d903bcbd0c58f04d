"""Headings under which the help lists the commands."""

PREPARE = "Before a flight"
FLY = "In simulation"
LOOK = "After a flight"
VEHICLE = "On a vehicle, real or emulated"
