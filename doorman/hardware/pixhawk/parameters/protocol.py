"""Parameter protocol, the check of the parameters, and what attitude setpoints need of them; written only on request."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.config import PROMPT
from doorman.hardware.pixhawk.dialect import PX4
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.parameters.rules import THRUST_MODEL, Rule, Severity
from doorman.hardware.pixhawk.thrust.curve import ThrustCurve
from doorman.hardware.pixhawk.thrust.slope import ThrustModel
from doorman.hardware.pixhawk.thrust.tilted_rotors import COUNT, OLD_SWITCH, names
from doorman.hardware.pixhawk.wire.messages import mavlink

_TRIES = 8
_FEWER_TRIES = 3
"""Attempts to read a parameter that firmware may not have."""
_BATCH = 8
_MAX_NAME = 16


@dataclass(frozen=True)
class Finding:
    """A parameter that is not as it should be."""

    name: str
    given: float | None
    """None where the autopilot does not have it, or did not answer."""
    wanted: str
    severity: Severity
    why: str

    def __str__(self) -> str:
        if self.given is None:
            return f"{self.name} did not answer; it should be {self.wanted}: {self.why}"
        must = "must be" if self.severity is Severity.ERROR else "should be"
        return f"{self.name} is {self.given:g} and {must} {self.wanted}: {self.why}"


def read_parameters(link: Link, names: Iterable[str]) -> dict[str, float]:
    return _read_any(link, [(name,) for name in names])


def _read_any(link: Link, groups: Sequence[tuple[str, ...]], tries: int = _TRIES) -> dict[str, float]:
    """Read at least one parameter of each group: firmware knows a parameter by its newer or its older name."""
    start, missing = link.exchange.count, list(dict.fromkeys(groups))

    def answered(group: tuple[str, ...]) -> bool:
        return any(link.exchange.answer(name, start) is not None for name in group)

    for _ in range(tries):
        for first in range(0, len(missing), _BATCH):
            batch = missing[first : first + _BATCH]
            for name in (name for group in batch for name in group):
                if not name.isascii() or not 0 < len(name) <= _MAX_NAME:
                    raise BackendError(
                        "not a parameter", field="name", given=name, allowed=f"1 to {_MAX_NAME} characters of ASCII"
                    )
                link.send(mavlink.MAVLink_param_request_read_message(*link.target, name.encode(), -1))
            link.exchange.wait(lambda batch=batch: True if all(map(answered, batch)) else None, PROMPT)  # type: ignore[misc]
        missing = [group for group in missing if not answered(group)]
        if not missing:
            break
    answers = {name: link.exchange.answer(name, start) for group in groups for name in group}
    return {name: answer.value for name, answer in answers.items() if answer is not None}


def _read_for(link: Link, rules: Sequence[Rule]) -> dict[str, float]:
    values = _read_any(link, [rule.names for rule in rules if not rule.optional])
    return values | _read_any(link, [rule.names for rule in rules if rule.optional], _FEWER_TRIES)


def write_parameter(link: Link, name: str, value: float) -> bool:
    before = link.exchange.count
    if name not in read_parameters(link, [name]):
        return False
    known = link.exchange.answer(name, before)
    kind = mavlink.MAV_PARAM_TYPE_REAL32 if known is None else known.kind
    for _ in range(_TRIES):
        start = link.exchange.count
        field = link.known_dialect.encode_parameter(value, kind)
        link.send(mavlink.MAVLink_param_set_message(*link.target, name.encode(), field, kind))
        answer = link.exchange.wait(lambda start=start: link.exchange.answer(name, start), PROMPT)  # type: ignore[misc]
        if answer is not None and math.isclose(answer.value, value, rel_tol=1e-5, abs_tol=1e-6):
            return True  # otherwise it may be a late answer to the read
    return False


def check(link: Link, rules: Iterable[Rule]) -> tuple[Finding, ...]:
    rules = tuple(rules)
    values = _read_for(link, [rule for rule in rules if rule.only_with is None])
    counting = [rule for rule in rules if rule.counts(values)]
    values |= _read_for(link, [rule for rule in counting if rule.only_with is not None])
    findings = []
    for rule in counting:
        name = next((name for name in rule.names if name in values), rule.names[0])
        given = values.get(name)
        if given is None and not rule.optional:
            findings.append(Finding(name, None, rule.wanted, Severity.WARNING, rule.why))
        elif given is not None and not rule.accepts(given):
            findings.append(Finding(name, given, rule.wanted, rule.severity, rule.why))
    return tuple(findings)


def fix(link: Link, rules: Iterable[Rule]) -> tuple[str, ...]:
    """Write what `check` finds, where it was asked for and the vehicle is on the ground; names of what was written."""
    if not link.config.write_parameters:
        raise BackendError("parameters are written only on request", field="pixhawk.write_parameters", allowed="True")
    sample = link.tracker.sample
    if sample.armed or link.time.now() - sample.heartbeat_time > link.config.timeouts.heartbeat:
        raise BackendError("parameters are written on the ground only", field="armed",
                           allowed="an autopilot that is heard and disarmed")  # fmt: skip
    rules = tuple(rules)
    by_name = {name: rule for rule in rules for name in rule.names}
    written = []
    for finding in check(link, rules):
        rule = by_name.get(finding.name)
        if rule is None or rule.value is None or finding.given is None:
            continue
        if write_parameter(link, finding.name, rule.value(finding.given)):
            written.append(finding.name)
    return tuple(written)


THRUST_AS_THRUST = 1 << 3
"""Bit of ArduPilot's GUID_OPTIONS."""


def prepare_attitude(link: Link) -> str:
    """Look up what attitude setpoints need, and set the stream up with it; returns what is missing."""
    dialect, config = link.known_dialect, link.config
    if link.vehicle_type not in dialect.takes_thrust:
        return f"{dialect.name} takes no thrust setpoints for MAV_TYPE {link.vehicle_type}; use position setpoints"
    if why := side_force_missing(link):
        return f"no force to the side: {why}"
    options = ("GUID_OPTIONS", "ATC_ANGLE_BOOST") if dialect.angle_boost else ()
    model = THRUST_MODEL[dialect.name]
    values = read_parameters(link, [dialect.hover_parameter, model, *options])
    link.stream.thrust_model = ThrustModel(model, values[model]) if model in values else None
    if dialect.angle_boost:
        if not round(values.get("GUID_OPTIONS", 0.0)) & THRUST_AS_THRUST:
            return "GUID_OPTIONS lacks bit 3 (8): ArduPilot would take thrust for a climb rate; set it, or use position setpoints"
        link.stream.angle_boost = round(values.get("ATC_ANGLE_BOOST", 1.0)) != 0
    hover = values.get(dialect.hover_parameter)
    if link.stream.curve is None and config.hover_force is not None and hover is not None:
        link.stream.curve = ThrustCurve(hover, config.hover_force)
    return "no thrust curve: give thrust_curve or hover_force" if link.stream.curve is None else ""


def side_force_missing(link: Link) -> str:
    """Why the autopilot makes no force to the side; nothing where it does, or the vehicle's rotors make none."""
    dialect, rotors = link.known_dialect, link.config.rotors
    if rotors is None:
        return ""
    values = read_parameters(link, [COUNT, OLD_SWITCH]) if dialect is PX4 else {}
    if COUNT in values:
        values |= read_parameters(link, names(round(values[COUNT])))
    return rotors.missing(dialect, values)
