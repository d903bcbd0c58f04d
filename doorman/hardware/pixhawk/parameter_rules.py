"""What the autopilot's parameters should be, why, and how to mend them: data, one row a parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum

from doorman.hardware.pixhawk.config import PixhawkConfig
from doorman.hardware.pixhawk.dialect import PX4, Dialect


class Severity(Enum):
    """What a finding means."""

    ERROR = "error"
    """The flight cannot work, or a fault would not end safely; whoever flies decides whether it is flown so."""
    WARNING = "warning"
    """It can work, worse."""


class When(Enum):
    """For which set-ups a rule holds."""

    ALWAYS = "always"
    MOCAP = "mocap"
    ATTITUDE = "attitude setpoints"
    OWN_COMPENSATION = "thrust curve with battery voltage"


@dataclass(frozen=True)
class Rule:
    """One parameter."""

    names: tuple[str, ...]
    """Of the parameter, newest firmware first; the first that the autopilot has counts."""
    wanted: str
    """In words."""
    accepts: Callable[[float], bool]
    value: Callable[[float], float] | None
    """Value to write for a given one; None where a person must decide."""
    severity: Severity
    when: When
    why: str
    optional: bool = False
    """Whether firmware without the parameter is fine."""
    only_with: tuple[str, int] | None = None
    """Another parameter and the value that it must have for this one to count; it has a rule of its own."""

    @property
    def condition(self) -> str:
        """For which set-ups it counts, in words."""
        return self.when.value if self.only_with is None else "{} {}".format(*self.only_with)

    def counts(self, values: Mapping[str, float]) -> bool:
        """Whether it counts with these values of the other parameters."""
        return self.only_with is None or values.get(self.only_with[0]) == self.only_with[1]

    def applies(self, config: PixhawkConfig) -> bool:
        """Whether the rule holds for a set-up."""
        curve = config.thrust_curve
        return {
            When.ALWAYS: True,
            When.MOCAP: config.mocap,
            When.ATTITUDE: config.setpoints == "attitude",
            When.OWN_COMPENSATION: curve is not None and curve.hover_voltage is not None,
        }[self.when]


def _equal(
    names: str, value: float, severity: Severity, when: When, why: str, *, optional: bool = False, near: float = 1e-4
) -> Rule:
    return Rule(
        tuple(names.split()),
        f"{value:g}",
        lambda given: abs(given - value) <= near,
        lambda _: value,
        severity,
        when,
        why,
        optional,
    )


def _within(names: str, low: float, high: float, best: float, severity: Severity, when: When, why: str) -> Rule:
    return Rule(
        tuple(names.split()),
        f"{low:g} to {high:g}",
        lambda given: low <= given <= high,
        lambda _: best,
        severity,
        when,
        why,
    )


def _one_of(
    names: str, values: tuple[int, ...], severity: Severity, when: When, why: str, *, optional: bool = False
) -> Rule:
    wanted = " or ".join(str(value) for value in values)
    return Rule(
        tuple(names.split()),
        wanted,
        lambda given: round(given) in values,
        lambda _: float(values[0]),
        severity,
        when,
        why,
        optional,
    )


def _bit(names: str, bit: int, severity: Severity, when: When, why: str) -> Rule:
    mask = 1 << bit
    return Rule(
        tuple(names.split()),
        f"bit {bit} ({mask}) set",
        lambda given: bool(round(given) & mask),
        lambda given: float(round(given) | mask),
        severity,
        when,
        why,
    )


def _where(other: str, value: int, *rules: Rule) -> tuple[Rule, ...]:
    """Rules that count only where another parameter has a value."""
    return tuple(replace(rule, only_with=(other, value)) for rule in rules)


_E, _W = Severity.ERROR, Severity.WARNING
_NO_CLIMB = "it must go back as high as it is: a climb from a doorway ends in its lintel"
_KEEPS_HEADING = "a turn in the doorway takes the arm with it, and the thrust that it needs"
_LANDS = "back on its pad it must land, by dead reckoning: soon"

PX4_RULES = (
    Rule(
        ("COM_OBL_ACT",),
        "absent",
        lambda _: False,
        None,
        _E,
        When.ALWAYS,
        "PX4 1.13 or older, with other parameters than these; without a radio it flies offboard only with bit 2 (4) of "
        "COM_RCL_EXCEPT; update to 1.14 or newer",
        optional=True,
    ),
    _within("COM_OF_LOSS_T", 0.1, 1.0, 0.2, _E, When.ALWAYS, "time without setpoints until the failsafe acts"),
    _one_of(
        "COM_OBL_RC_ACT",
        (4, 3),
        _E,
        When.ALWAYS,
        "without setpoints it must land, in place (4) or on its pad (3); the default waits for a pilot, or climbs to return",
    ),
    *_where(
        "COM_OBL_RC_ACT",
        3,
        _within("RTL_RETURN_ALT", 0.0, 0.5, 0.0, _E, When.ALWAYS, _NO_CLIMB),
        _equal("RTL_CONE_ANG", 0, _E, When.ALWAYS, "as above; with a cone it sinks on the way"),
        _equal("RTL_TYPE", 0, _E, When.ALWAYS, "it must go to where it took off"),
        _within("NAV_ACC_RAD", 0.05, 0.5, 0.2, _E, When.ALWAYS, "it lands once it is as near as that"),
        _within("RTL_MIN_DIST", 0.5, 0.8, 0.5, _W, When.ALWAYS, _KEEPS_HEADING),
        _equal("MPC_YAW_MODE", 5, _W, When.ALWAYS, _KEEPS_HEADING),
        _within("RTL_LAND_DELAY", 0.0, 1.0, 0.0, _E, When.ALWAYS, _LANDS),
    ),
    _one_of(
        "NAV_DLL_ACT", (0, 3), _W, When.ALWAYS, "without a ground station it must land or go on, not climb to return"
    ),
    _one_of("NAV_RCL_ACT", (3, 1, 7), _W, When.ALWAYS, "without the radio it must land or hold, not climb to return"),
    _one_of("COM_LOW_BAT_ACT", (2, 0), _W, When.ALWAYS, "on a low battery it must land or warn, not climb to return"),
    _equal("MC_BAT_SCALE_EN", 0, _E, When.OWN_COMPENSATION, "the battery is compensated here already", optional=True),
    _equal("EKF2_EV_CTRL", 11, _E, When.MOCAP, "position, height and yaw are fused from mocap"),
    _equal("EKF2_HGT_REF", 3, _E, When.MOCAP, "height comes from mocap"),
    _equal("EKF2_GPS_CTRL", 0, _E, When.MOCAP, "no GPS indoors"),
    _equal(
        "EKF2_BARO_CTRL",
        1,
        _W,
        When.MOCAP,
        "height without cameras: with neither, it does not notice that it has landed, and its motors run on",
    ),
    _equal("EKF2_RNG_CTRL", 0, _W, When.MOCAP, "no range finder over the door's sill"),
    _equal("EKF2_MAG_TYPE", 5, _E, When.MOCAP, "steel indoors bends the field; yaw comes from mocap"),
    _equal("EKF2_EVP_NOISE", 0.01, _W, When.MOCAP, "noise of the pose's position [m]"),
    _equal("EKF2_EVA_NOISE", 0.02, _W, When.MOCAP, "noise of the pose's attitude [rad]"),
)
"""Rules for PX4."""

ARDUPILOT_RULES = (
    _bit(
        "GUID_OPTIONS", 3, _E, When.ATTITUDE, "otherwise the thrust of an attitude setpoint is taken for a climb rate"
    ),
    _within(
        "GUID_TIMEOUT",
        0.1,
        1.0,
        0.2,
        _W,
        When.ALWAYS,
        "time without setpoints until it levels and stops; before 4.5.2 it turns to north, too",
    ),
    _one_of(
        "FS_GCS_ENABLE",
        (5, 1),
        _E,
        When.ALWAYS,
        "position setpoints are held for ever: without us it must land, in place (5) or on its pad (1)",
    ),
    *_where(
        "FS_GCS_ENABLE",
        1,
        replace(_within("RTL_ALT", 0.0, 50.0, 30.0, _E, When.ALWAYS, _NO_CLIMB), optional=True),
        replace(_within("RTL_ALT_M", 0.0, 0.5, 0.3, _E, When.ALWAYS, _NO_CLIMB), optional=True),
        _equal("RTL_CLIMB_MIN_M RTL_CLIMB_MIN", 0, _E, When.ALWAYS, _NO_CLIMB),
        _equal("RTL_ALT_FINAL_M RTL_ALT_FINAL", 0, _E, When.ALWAYS, "it must land"),
        _one_of("WP_YAW_BEHAVIOR", (2, 0), _W, When.ALWAYS, _KEEPS_HEADING),
        _within(
            "WPNAV_JERK WP_JERK",
            3.0,
            20.0,
            5.0,
            _W,
            When.ALWAYS,
            "it must be back before it gives dead reckoning up: soon",
        ),
        _within("RTL_LOIT_TIME", 0.0, 1000.0, 0.0, _E, When.ALWAYS, _LANDS),
        _within("FS_GCS_TIMEOUT", 2.0, 3.0, 2.0, _W, When.ALWAYS, "until it is over it drifts"),
        _bit("FS_OPTIONS", 3, _E, When.ALWAYS, "one that lands already must go on, not fly off to its pad"),
    ),
    _one_of(
        "FS_THR_ENABLE", (3, 0, 7), _W, When.ALWAYS, "without the radio it must land or go on, not climb to return"
    ),
    _one_of(
        "BATT_FS_LOW_ACT",
        (1, 0),
        _W,
        When.ALWAYS,
        "on a low battery it must land or warn, not climb to return",
        optional=True,
    ),
    _one_of("BATT_FS_CRT_ACT", (1, 0), _W, When.ALWAYS, "as above", optional=True),
    _one_of("FS_EKF_ACTION", (1, 3), _W, When.ALWAYS, "without an estimate it must land"),
    _equal("MOT_BAT_VOLT_MAX", 0, _E, When.OWN_COMPENSATION, "the battery is compensated here already"),
    _equal("GPS1_TYPE GPS_TYPE", 0, _E, When.MOCAP, "no GPS indoors"),
    _equal("COMPASS_USE", 0, _E, When.MOCAP, "steel indoors bends the field; yaw comes from mocap"),
    _equal("COMPASS_USE2", 0, _E, When.MOCAP, "as above", optional=True),
    _equal("COMPASS_USE3", 0, _E, When.MOCAP, "as above", optional=True),
    _equal("EK3_SRC1_POSXY", 6, _E, When.MOCAP, "position comes from mocap"),
    _equal("EK3_SRC1_POSZ", 6, _E, When.MOCAP, "height comes from mocap"),
    _equal("EK3_SRC1_YAW", 6, _E, When.MOCAP, "yaw comes from mocap"),
    _equal("EK3_SRC1_VELXY", 0, _E, When.MOCAP, "mocap sends no velocity"),
    _equal("EK3_SRC1_VELZ", 0, _E, When.MOCAP, "mocap sends no velocity"),
    _equal("VISO_TYPE", 1, _E, When.MOCAP, "poses come by MAVLink"),
    _one_of(
        "VISO_QUAL_MIN",
        (0, -1),
        _E,
        When.MOCAP,
        "poses come without a quality, and are dropped otherwise",
        optional=True,
    ),
)
"""Rules for ArduPilot; that of the ground station's id and those of delays depend on the set-up."""

MOCAP_DELAY = {"PX4": ("EKF2_EV_DELAY", 20.0), "ArduPilot": ("VISO_DELAY_MS", 20.0)}
"""Parameter of the pose's delay [ms], and by how much it may miss."""
THRUST_MODEL = {"PX4": "THR_MDL_FAC", "ArduPilot": "MOT_THST_EXPO"}
"""Parameter by which the autopilot bends thrust into the motors' signal: 0 not at all, 1 as the square root."""
_LEAST_BENT = 0.2
"""Of that, together with the curve's own shape: what measured motors have at least."""
_EARLIER = 0.2
"""By which the mission is given up before, for the sag of a manoeuvre [V]."""


def rules_for(dialect: Dialect, config: PixhawkConfig, mocap_delay: float | None = None) -> tuple[Rule, ...]:
    """Rules that hold for a set-up.

    Args:
        dialect: Of the autopilot.
        config: The set-up.
        mocap_delay: From capture to sending, as measured [s]; None if not measured yet.

    Returns:
        The rules in the order of the tables.
    """
    thrust = thrust_model_rule(dialect, 0.0 if config.thrust_curve is None else config.thrust_curve.shape)
    if dialect is PX4:
        rules = [*PX4_RULES, thrust, delay_rule(dialect, 0.0)]  # stamps carry the delay, once TIMESYNC has converged
    else:
        rules = [*ARDUPILOT_RULES, thrust, *voltage_rules(config.min_voltage), station_rule(config.system_id)]
        if mocap_delay is not None:  # it removes a constant lag from the stamps, and must be told what that was
            rules.append(delay_rule(dialect, mocap_delay))
    return tuple(rule for rule in rules if rule.applies(config))


def thrust_model_rule(dialect: Dialect, shape: float) -> Rule:
    """Thrust that is bent by the autopilot, by the curve here, or by both a little, but not by neither or by both wholly.

    Args:
        dialect: Of the autopilot.
        shape: k of the thrust curve.
    """
    low, high = max(0.0, _LEAST_BENT - shape), min(1.0, 1.0 + _LEAST_BENT - shape)
    return Rule(
        (THRUST_MODEL[dialect.name],),
        f"{low:g} to {high:g}",
        lambda given: low - 1e-4 <= given <= high + 1e-4,
        None,
        _W,
        When.ATTITUDE,
        "the thrust of real motors grows with the square of their signal; hover measures it, but the autopilot's own loops "
        "are steeper than they were tuned for",
    )


def voltage_rules(min_voltage: float | None) -> tuple[Rule, ...]:
    """ArduPilot's own look at the voltage must not land the vehicle in the doorway before the mission is given up.

    Args:
        min_voltage: At which it is given up [V]; None: by the charge alone.
    """
    most = 0.0 if min_voltage is None else min_voltage - _EARLIER

    def rule(name: str, action: str) -> Rule:
        return Rule(
            (name,),
            "0, or below pixhawk.min_voltage",
            lambda given: given <= max(most, 0.0),
            None,
            _W,
            When.ALWAYS,
            "it lands where it is, in the doorway: the mission must be given up at a higher voltage",
            optional=True,
            only_with=(action, 1),
        )

    return rule("BATT_LOW_VOLT", "BATT_FS_LOW_ACT"), rule("BATT_CRT_VOLT", "BATT_FS_CRT_ACT")


def station_rule(system_id: int) -> Rule:
    """ArduPilot acts on the loss of one station's heartbeat only."""
    return _equal(
        "MAV_GCS_SYSID SYSID_MYGCS",
        system_id,
        _E,
        When.ALWAYS,
        "otherwise our loss is not noticed: it is our system id",
    )


def delay_rule(dialect: Dialect, delay: float) -> Rule:
    """Delay that the estimator reckons with [s]."""
    name, near = MOCAP_DELAY[dialect.name]
    return _equal(name, round(1e3 * delay), _W, When.MOCAP, "delay of the pose [ms]", near=near)
