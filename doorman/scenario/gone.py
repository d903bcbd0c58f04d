"""Keys of older scenarios, and what replaces them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_LAG = "it follows from vehicle.attitude_lag"
_HINGE = "the mean is door.{0} where that is given"
_FOUND = "it is found in flight"
_FIXED = {
    "control": "position_look_ahead arm_look_ahead yaw_share yaw_gain observer_damping",
    "door": "search_yaw",
    "mission": "touch_distance retreat_speed touch_speed hold_time",
    "mission.time_out": "hover touch_frame touch recover take_back release retreat through approach",
    "estimation": "sure gate loose_time slam_speed elsewhere seen_time blow_time swap_time frame_touch frame_track "
    "tip_force_noise tip_force_offset",
    "estimation.contact": "gap_rate slip_rate inside lasts friction_lasts held settles sticks more brakes creeps ajar",
    "estimation.switch": "near make far reach lose leave follow slip jump calm throw stop",
    "estimation.noise": "bounce jump gust_lasts draught wind_turn rate throw thrown_along drawn gives inertia face "
    "face_by_angle",
    "estimation.start": "velocity draught wind_turn gust joint stop astray joint_rate astray_rate resistance log_inertia reach "
    "friction",
    "estimation.hinge": "by_chance in_wind moves",
    "safety": "thrust_share pose_age disobedience command_age",
    "simulation": "door_latch_angle door_seal_angle",
    "simulation.sensors": "swap_duration swap_turn",
    "simulation.gust": "correlation_time",
    "simulation.door_sensor": "tag_size",
    "push": "hold_tolerance",
}
"""Keys that became constants, by table."""
GONE: Mapping[str, str] = {
    **{f"{table}.{key}": "it is fixed" for table, keys in _FIXED.items() for key in keys.split()},
    "push.max_rate": "goal.duration says how long the opening should take",
    "push.stopping_share": "what the hinge resists with bounds the rate by itself",
    "push.friction_coefficient": "contact.friction is the same number",
    **{f"control.{part}_look_ahead": _LAG for part in ("acceleration", "attitude")},
    "control.engage_pitch": "it follows from vehicle.attitude_lag and the rotors",
    "control.engage_rate": "it follows from vehicle.attitude_lag and the rotors",
    **{f"estimation.{name}": _HINGE.format(name) for name in ("damping", "friction", "stiffness")},
    **{
        f"estimation.{name}": _FOUND
        for name in (
            "vehicle_observer_rate", "wind_rate", "angle_deviation", "angle_noise", "push_noise", "push_noise_in_wind",
            "torque_deviation", "torque_deviation_in_wind", "torque_time", "leaf_wind", "leaf_wind_share", "leaf_wind_deviation",
            "inertia_deviation",
        )
    },
    "mission.touch_force": "it is a share of the vehicle's weight",
    **{
        f"simulation.{name}": "it follows from the vehicle's weight and radius"
        for name in ("tip_stiffness", "tip_damping", "grip_stiffness", "grip_damping")
    },
    "safety.critical_battery": "it is half of safety.low_battery",
    "simulation.door_sensor.turn_noise": "it goes with simulation.door_sensor.place_noise",
    "campaign.low_friction": "it is fixed at 0.5 N m",
}  # fmt: skip
"""By dotted key."""


def gone(field: str, given: Any, root: str) -> tuple[str, str] | None:
    """The key that went, and what replaces it; None for a key that never was. A table that went holds such keys.

    Of a section by itself, `root` is the class, and `field` lacks the names of the tables around it.
    """
    if isinstance(given, Mapping):
        for key, value in given.items():
            if found := gone(f"{field}.{key}", value, root):
                return found
    for key, words in GONE.items():
        table = key.removesuffix(f".{field}").rpartition(".")[2].replace("_", "")
        if f".{field}".endswith(f".{key}") or (key.endswith(f".{field}") and table in root.lower()):
            return key, words
    return None
