"""Keys of older scenarios, and what replaces them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_LAG = "it follows from vehicle.attitude_lag"
_HINGE = "the mean is door.{0} where that is given"
_FOUND = "it is found in flight"
GONE: Mapping[str, str] = {
    "push.max_rate": "goal.duration says how long the opening should take",
    "push.stopping_share": "what the hinge resists with bounds the rate by itself",
    "push.friction_coefficient": "contact.friction is the same number",
    "push.hold_tolerance": "it is fixed",
    **{f"control.{part}_look_ahead": _LAG for part in ("acceleration", "attitude")},
    **{f"control.{part}_look_ahead": "it is fixed" for part in ("position", "arm")},
    "control.engage_pitch": "it follows from vehicle.attitude_lag and the rotors",
    "control.engage_rate": "it follows from vehicle.attitude_lag and the rotors",
    "control.yaw_share": "it is fixed",
    **{f"estimation.{name}": _HINGE.format(name) for name in ("damping", "friction", "stiffness")},
    **{
        f"estimation.{name}": _FOUND
        for name in (
            "vehicle_observer_rate", "wind_rate", "angle_deviation", "angle_noise", "push_noise", "push_noise_in_wind",
            "torque_deviation", "torque_deviation_in_wind", "torque_time", "leaf_wind", "leaf_wind_share", "leaf_wind_deviation",
            "inertia_deviation",
        )
    },
    "mission.touch_distance": "it is fixed",
    "mission.touch_force": "it is a share of the vehicle's weight",
    "mission.retreat_speed": "it is fixed",
    **{
        f"mission.time_out.{name}": "it is fixed"
        for name in ("hover", "touch_frame", "touch", "recover", "take_back", "release", "retreat", "through")
    },
    **{
        f"simulation.{name}": "it follows from the vehicle's weight and radius"
        for name in ("tip_stiffness", "tip_damping", "grip_stiffness", "grip_damping")
    },
    "campaign.low_friction": "it is fixed at 0.5 N m",
}  # fmt: skip
"""By dotted key."""


def gone(field: str, given: Any) -> tuple[str, str] | None:
    """The key that went, and what replaces it; None for a key that never was. A table that went holds such keys."""
    if isinstance(given, Mapping):
        for key, value in given.items():
            if found := gone(f"{field}.{key}", value):
                return found
    names = [key for key in GONE if key == field or key.endswith(f".{field}") or field.endswith(f".{key}")]
    return (names[0], GONE[names[0]]) if names else None
