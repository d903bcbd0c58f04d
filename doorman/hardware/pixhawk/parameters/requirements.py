"""What attitude setpoints need before they may be flown: a thrust curve, and an autopilot that takes thrust for thrust."""

from __future__ import annotations

from doorman.hardware.pixhawk.dialect import PX4
from doorman.hardware.pixhawk.events import Outcome, OutcomeStatus
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.parameters.protocol import read_parameters
from doorman.hardware.pixhawk.parameters.rules import THRUST_MODEL
from doorman.hardware.pixhawk.thrust.curve import ThrustCurve
from doorman.hardware.pixhawk.thrust.slope import ThrustModel
from doorman.hardware.pixhawk.thrust.tilted_rotors import COUNT, OLD_SWITCH, names

THRUST_AS_THRUST = 1 << 3
"""Bit of ArduPilot's GUID_OPTIONS."""


def prepare_attitude(link: Link) -> Outcome:
    """Look up what attitude setpoints need, and set the stream up with it."""
    dialect, config = link.known_dialect, link.config
    if link.inbox.vehicle_type not in dialect.takes_thrust:
        return Outcome(
            OutcomeStatus.NOT_READY,
            f"{dialect.name} takes no thrust setpoints for MAV_TYPE {link.inbox.vehicle_type}; use position setpoints",
        )
    if why := side_force_missing(link):
        return Outcome(OutcomeStatus.NOT_READY, f"no force to the side: {why}")
    options = ("GUID_OPTIONS", "ATC_ANGLE_BOOST") if dialect.angle_boost else ()
    model = THRUST_MODEL[dialect.name]
    values = read_parameters(link, [dialect.hover_parameter, model, *options])
    link.stream.thrust_model = ThrustModel(model, values[model]) if model in values else None
    if dialect.angle_boost:
        if not round(values.get("GUID_OPTIONS", 0.0)) & THRUST_AS_THRUST:
            return Outcome(
                OutcomeStatus.NOT_READY,
                "GUID_OPTIONS lacks bit 3 (8): ArduPilot would take thrust for a climb rate; set it, or use position setpoints",
            )
        link.stream.angle_boost = round(values.get("ATC_ANGLE_BOOST", 1.0)) != 0
    hover = values.get(dialect.hover_parameter)
    if link.stream.curve is None and config.hover_force is not None and hover is not None:
        link.stream.curve = ThrustCurve(hover, config.hover_force)
    if link.stream.curve is None:
        return Outcome(OutcomeStatus.NOT_READY, "no thrust curve: give thrust_curve or hover_force")
    return Outcome(OutcomeStatus.DONE)


def side_force_missing(link: Link) -> str:
    """Why the autopilot makes no force to the side; nothing where it does, or the vehicle's rotors make none."""
    dialect, rotors = link.known_dialect, link.config.rotors
    if rotors is None:
        return ""
    values = read_parameters(link, [COUNT, OLD_SWITCH]) if dialect is PX4 else {}
    if COUNT in values:
        values |= read_parameters(link, names(round(values[COUNT])))
    return rotors.missing(dialect, values)
