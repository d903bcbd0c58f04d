"""Adapter to PX4 and ArduPilot multirotors by MAVLink; needs the extra `hardware`."""

from doorman.hardware.pixhawk.authority import Authority
from doorman.hardware.pixhawk.autopilot import Autopilot
from doorman.hardware.pixhawk.config import PixhawkConfig, Rates, Timeouts
from doorman.hardware.pixhawk.events import Event, EventKind, Outcome, OutcomeStatus
from doorman.hardware.pixhawk.link.status import LinkStatus
from doorman.hardware.pixhawk.parameters.protocol import Finding
from doorman.hardware.pixhawk.sample import Battery, LandedState, SampleStatus, VehicleSample
from doorman.hardware.pixhawk.setpoints import AttitudeSetpoint, PositionSetpoint
from doorman.hardware.pixhawk.thrust.curve import ThrustCurve
from doorman.hardware.pixhawk.wire.frames import LocalFrame

__all__ = [
    "AttitudeSetpoint",
    "Authority",
    "Autopilot",
    "Battery",
    "Event",
    "EventKind",
    "Finding",
    "LandedState",
    "LinkStatus",
    "LocalFrame",
    "Outcome",
    "OutcomeStatus",
    "PixhawkConfig",
    "PositionSetpoint",
    "Rates",
    "SampleStatus",
    "ThrustCurve",
    "Timeouts",
    "VehicleSample",
]
