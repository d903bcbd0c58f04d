"""What the autopilot's parameters should be, why, and how to mend them: data, one rule a parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum

from doorman.hardware.pixhawk.config import PixhawkConfig
from doorman.hardware.pixhawk.dialect import PX4, Dialect


class Severity(Enum):
    ERROR = "error"
    """The flight cannot work, or a fault would not end safely; whoever flies decides whether it is flown so."""
    WARNING = "warning"  # it can work, worse


class When(Enum):
    ALWAYS = "always"
    MOCAP = "mocap"
    ATTITUDE = "attitude setpoints"
    OWN_COMPENSATION = "thrust curve with battery voltage"


@dataclass(frozen=True)
class Rule:
    names: tuple[str, ...]  # of the parameter, newest firmware first; the first that the autopilot has counts
    wanted: str  # in words
    accepts: Callable[[float], bool]
    value: Callable[[float], float] | None  # value to write for a given one; None where a person must decide
    severity: Severity
    why: str
    when: When = When.ALWAYS
    optional: bool = False  # whether firmware without the parameter is fine
    only_with: tuple[str, int] | None = None
    """Another parameter and the value that it must have for this one to count; it has a rule of its own."""

    @property
    def condition(self) -> str:
        """Set-ups for which the rule counts, in words."""
        return self.when.value if self.only_with is None else "{} {}".format(*self.only_with)

    def counts(self, values: Mapping[str, float]) -> bool:
        """Whether the rule counts with these values of the other parameters."""
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


def within(names: str, low: float, high: float, best: float, severity: Severity, why: str, wanted: str = "") -> Rule:
    """Rule of a parameter with a range."""
    wanted = wanted or f"{low:g} to {high:g}"
    return Rule(tuple(names.split()), wanted, lambda given: low <= given <= high, lambda _: best, severity, why)


def equal(names: str, value: float, severity: Severity, why: str, near: float = 1e-4) -> Rule:
    """Rule of a parameter that has one right value."""
    return within(names, value - near, value + near, value, severity, why, f"{value:g}")


def one_of(name: str, values: tuple[int, ...], severity: Severity, why: str) -> Rule:
    """Rule of a parameter with a few right values, the best of them first."""
    wanted, best = " or ".join(map(str, values)), float(values[0])
    return Rule((name,), wanted, lambda given: round(given) in values, lambda _: best, severity, why)


def bit(name: str, bit: int, severity: Severity, why: str) -> Rule:
    """Rule of a parameter with a bit that must be set; its other bits stay."""
    wanted, mask = f"bit {bit} ({1 << bit}) set", 1 << bit
    return Rule(
        (name,),
        wanted,
        lambda given: bool(round(given) & mask),
        lambda given: float(round(given) | mask),
        severity,
        why,
    )


def optional(*rules: Rule) -> tuple[Rule, ...]:
    """Rules of parameters that not every firmware has."""
    return tuple(replace(rule, optional=True) for rule in rules)


def where(other: str, value: int, *rules: Rule) -> tuple[Rule, ...]:
    """Rules that count only where another parameter has a value."""
    return tuple(replace(rule, only_with=(other, value)) for rule in rules)


def when(set_up: When, *rules: Rule) -> tuple[Rule, ...]:
    """Rules that count only for a set-up."""
    return tuple(replace(rule, when=set_up) for rule in rules)


_E, _W = Severity.ERROR, Severity.WARNING
_NO_CLIMB = "the vehicle must return at its height: a climb in a doorway ends in the lintel"
_KEEPS_HEADING = "a turn in the doorway turns the arm into the frame and costs thrust"
_LANDS = "above its pad the vehicle must land soon, while dead reckoning holds"
_LOW_BATTERY = "on a low battery the autopilot must land or warn, not climb to return"
_COMPENSATED = "doorman compensates for the battery already"
_STEEL = "steel indoors bends the field; yaw comes from mocap"

PX4_RULES = (
    Rule(("COM_OBL_ACT",), "absent", lambda _: False, None, _E,
         "PX4 1.13 or older has other parameters than these; without a radio it flies offboard only with bit 2 (4) of "
         "COM_RCL_EXCEPT; update to 1.14 or newer", optional=True),
    within("COM_OF_LOSS_T", 0.1, 1.0, 0.2, _E, "time without setpoints until the failsafe acts"),
    one_of("COM_OBL_RC_ACT", (4, 3), _E,
           "without setpoints it must land, in place (4) or on its pad (3); the default waits for a pilot or climbs to return"),
    *where(
        "COM_OBL_RC_ACT", 3,
        within("RTL_RETURN_ALT", 0.0, 0.5, 0.0, _E, _NO_CLIMB),
        equal("RTL_CONE_ANG", 0, _E, "the vehicle must return at its height: with a cone it sinks on the way"),
        equal("RTL_TYPE", 0, _E, "the vehicle must return to where it took off"),
        within("NAV_ACC_RAD", 0.05, 0.5, 0.2, _E, "distance from its pad at which the vehicle lands"),
        within("RTL_MIN_DIST", 0.5, 0.8, 0.5, _W, _KEEPS_HEADING),
        equal("MPC_YAW_MODE", 5, _W, _KEEPS_HEADING),
        within("RTL_LAND_DELAY", 0.0, 1.0, 0.0, _E, _LANDS),
    ),
    one_of("NAV_DLL_ACT", (0, 3), _W, "without a ground station the vehicle must land or go on, not climb to return"),
    one_of("NAV_RCL_ACT", (3, 1, 7), _W, "without the radio the vehicle must land or hold, not climb to return"),
    one_of("COM_LOW_BAT_ACT", (2, 0), _W, _LOW_BATTERY),
    *when(When.OWN_COMPENSATION, *optional(equal("MC_BAT_SCALE_EN", 0, _E, _COMPENSATED))),
    *when(
        When.MOCAP,
        equal("EKF2_EV_CTRL", 11, _E, "position, height and yaw are fused from mocap"),
        equal("EKF2_HGT_REF", 3, _E, "height comes from mocap"),
        equal("EKF2_GPS_CTRL", 0, _E, "no GPS indoors"),
        equal("EKF2_BARO_CTRL", 1, _W,
              "height when the cameras fail: with neither, the autopilot does not notice a landing, and the motors run on"),
        equal("EKF2_RNG_CTRL", 0, _W, "no range finder over the door's sill"),
        equal("EKF2_MAG_TYPE", 5, _E, _STEEL),
        equal("EKF2_EVP_NOISE", 0.01, _W, "noise of the pose's position [m]"),
        equal("EKF2_EVA_NOISE", 0.02, _W, "noise of the pose's attitude [rad]"),
    ),
)  # fmt: skip
"""Rules for PX4."""

ARDUPILOT_RULES = (
    *when(When.ATTITUDE, bit("GUID_OPTIONS", 3, _E,
                             "otherwise ArduPilot takes the thrust of an attitude setpoint for a climb rate")),
    within("GUID_TIMEOUT", 0.1, 1.0, 0.2, _W,
           "time without setpoints until the vehicle levels and stops; before 4.5.2 it also turns to north"),
    one_of("FS_GCS_ENABLE", (5, 1), _E,
           "ArduPilot holds position setpoints for ever: without doorman it must land, in place (5) or on its pad (1)"),
    *where(
        "FS_GCS_ENABLE", 1,
        *optional(within("RTL_ALT", 0.0, 50.0, 30.0, _E, _NO_CLIMB)),
        *optional(within("RTL_ALT_M", 0.0, 0.5, 0.3, _E, _NO_CLIMB)),
        equal("RTL_CLIMB_MIN_M RTL_CLIMB_MIN", 0, _E, _NO_CLIMB),
        equal("RTL_ALT_FINAL_M RTL_ALT_FINAL", 0, _E, "the vehicle must land"),
        one_of("WP_YAW_BEHAVIOR", (2, 0), _W, _KEEPS_HEADING),
        within("WPNAV_JERK WP_JERK", 3.0, 20.0, 5.0, _W, "the vehicle must be back before dead reckoning ends"),
        within("RTL_LOIT_TIME", 0.0, 1000.0, 0.0, _E, _LANDS),
        within("FS_GCS_TIMEOUT", 2.0, 3.0, 2.0, _W, "the vehicle drifts until this time is over"),
        bit("FS_OPTIONS", 3, _E, "a vehicle that lands already must go on landing, not fly to its pad"),
    ),
    one_of("FS_THR_ENABLE", (3, 0, 7), _W, "without the radio the vehicle must land or go on, not climb to return"),
    *optional(one_of("BATT_FS_LOW_ACT", (1, 0), _W, _LOW_BATTERY)),
    *optional(one_of("BATT_FS_CRT_ACT", (1, 0), _W, "as above")),
    one_of("FS_EKF_ACTION", (1, 3), _W, "without an estimate the vehicle must land"),
    *when(When.OWN_COMPENSATION, equal("MOT_BAT_VOLT_MAX", 0, _E, _COMPENSATED)),
    *when(
        When.MOCAP,
        equal("GPS1_TYPE GPS_TYPE", 0, _E, "no GPS indoors"),
        equal("COMPASS_USE", 0, _E, _STEEL),
        *optional(equal("COMPASS_USE2", 0, _E, "as above")),
        *optional(equal("COMPASS_USE3", 0, _E, "as above")),
        equal("EK3_SRC1_POSXY", 6, _E, "position comes from mocap"),
        equal("EK3_SRC1_POSZ", 6, _E, "height comes from mocap"),
        equal("EK3_SRC1_YAW", 6, _E, "yaw comes from mocap"),
        equal("EK3_SRC1_VELXY", 0, _E, "mocap sends no velocity"),
        equal("EK3_SRC1_VELZ", 0, _E, "mocap sends no velocity"),
        equal("VISO_TYPE", 1, _E, "poses come by MAVLink"),
        *optional(one_of("VISO_QUAL_MIN", (0, -1), _E, "poses carry no quality: with another value ArduPilot drops them")),
    ),
)  # fmt: skip
"""Rules for ArduPilot; that of the ground station's id and those of delays depend on the set-up."""

MOCAP_DELAY = {"PX4": ("EKF2_EV_DELAY", 20), "ArduPilot": ("VISO_DELAY_MS", 20)}
"""Parameter of the pose's delay [ms], and by how much it may miss."""
THRUST_MODEL = {"PX4": "THR_MDL_FAC", "ArduPilot": "MOT_THST_EXPO"}
"""Parameter by which the autopilot bends thrust into the motors' signal: 0 not at all, 1 as the square root."""
_LEAST_BENT = 0.2
"""Least sum of that and the curve's own shape: what measured motors have at least."""
_EARLIER = 0.2
"""Margin above the autopilot's threshold at which the mission is given up, for the sag of a manoeuvre [V]."""


def rules_for(dialect: Dialect, config: PixhawkConfig, mocap_delay: float | None = None) -> tuple[Rule, ...]:
    thrust = thrust_model_rule(dialect, 0.0 if config.thrust_curve is None else config.thrust_curve.shape)
    if dialect is PX4:
        rules = [*PX4_RULES, thrust]
        mocap_delay = 0.0  # stamps carry the delay, once TIMESYNC has converged
    else:  # it acts on the loss of one station's heartbeat only
        why = "doorman's system id: otherwise ArduPilot does not notice when doorman stops"
        station = equal("MAV_GCS_SYSID SYSID_MYGCS", config.system_id, _E, why)
        rules = [*ARDUPILOT_RULES, thrust, *voltage_rules(config.min_voltage), station]
    if mocap_delay is not None:  # ArduPilot removes a constant lag from the stamps, and needs it as a parameter
        name, near = MOCAP_DELAY[dialect.name]
        rules += when(When.MOCAP, equal(name, round(1e3 * mocap_delay), _W, "delay of the pose [ms]", near))
    return tuple(rule for rule in rules if rule.applies(config))


def thrust_model_rule(dialect: Dialect, shape: float) -> Rule:
    """Thrust that is bent by the autopilot, by the curve here, or by both a little, but not by neither or by both wholly."""
    low, high = max(0.0, _LEAST_BENT - shape), min(1.0, 1.0 + _LEAST_BENT - shape)
    why = (
        "the thrust of real motors grows with the square of their signal; doorman measures it in hover, but the autopilot's own "
        "loops act more strongly than they were tuned for"
    )
    rule = within(THRUST_MODEL[dialect.name], low - 1e-4, high + 1e-4, low, _W, why, f"{low:g} to {high:g}")
    return replace(rule, value=None, when=When.ATTITUDE)


def voltage_rules(min_voltage: float | None) -> tuple[Rule, ...]:
    """Rules of ArduPilot's own battery failsafe: it must not land in the doorway before the mission is given up."""
    most = max(0.0 if min_voltage is None else min_voltage - _EARLIER, 0.0)
    why = "the autopilot would land in the doorway: the mission must be given up first, at a higher voltage"
    return optional(
        *(
            Rule(
                (name,),
                "0, or below pixhawk.min_voltage",
                lambda given: given <= most,
                None,
                _W,
                why,
                only_with=(action, 1),
            )
            for name, action in (("BATT_LOW_VOLT", "BATT_FS_LOW_ACT"), ("BATT_CRT_VOLT", "BATT_FS_CRT_ACT"))
        )
    )
