"""Keys of older scenarios, and what replaces them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_LAG = "it follows from vehicle.attitude_lag"
_HINGE = "the mean is door.{0} where that is given"
_FOUND = "it is found in flight"
_FIXED = {
    "control": "position_look_ahead arm_look_ahead yaw_share yaw_gain observer_damping",
    "limits": "min_thrust",
    "planner": "iterations",
    "door": "search search_yaw friction_rate",
    "contact": "grip_stiffness",
    "mission": "touch_distance retreat_speed touch_speed hold_time hold_open approach_speed recoveries",
    "mission.time_out": "hover touch_frame touch recover take_back release retreat through approach",
    "estimation": "sure gate loose_time slam_speed elsewhere seen_time blow_time swap_time frame_touch frame_track "
    "tip_force tip_force_noise tip_force_offset",
    "estimation.contact": "stiffness gap pull friction gap_rate slip_rate inside lasts friction_lasts held settles sticks "
    "more brakes creeps ajar",
    "estimation.switch": "near make far reach lose leave follow slip jump calm throw stop",
    "estimation.noise": "velocity gust lift resistance bounce jump gust_lasts draught wind_turn rate throw thrown_along "
    "drawn gives inertia face face_by_angle",
    "estimation.start": "wind lift face velocity draught wind_turn gust joint stop astray joint_rate astray_rate "
    "resistance log_inertia reach friction",
    "estimation.hinge": "by_chance in_wind moves damping_deviation friction_deviation stiffness_deviation",
    "safety": "thrust_share pose_age disobedience command_age misfit missed_ticks",
    "simulation": "door_latch_angle door_seal_angle planner_latency_periods",
    "simulation.noise": "velocity body_rates arm_angles arm_rates tip_force",
    "simulation.sensors": "dropout_duration swap swap_duration swap_turn",
    "simulation.gust": "correlation_time jump_angle jump_strength",
    "simulation.door_sensor": "tag_size field_of_view",
    "campaign": "min_contact_fraction max_push_force",
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
    **{
        f"estimation.{table}{name}": _HINGE.format(name)
        for table in ("", "hinge.")
        for name in ("damping", "friction", "stiffness")
    },
    "estimation.door_yaw_deviation": "it follows from estimation.door_place_deviation",
    **{f"{end}.joint_value": f"{end}.opening says it, from closed" for end in ("start", "goal")},
    **{
        f"mission.{name}": f'mission.measures lists "{what}"'
        for name, what in (("judge_poses", "poses"), ("measure_attitude", "attitude"), ("touch_frame", "frame"))
    },
    "vehicle.servos": "frames of the names servo_3 to servo_n in the URDF",
    "contact.fit_doorway": "a tip that pushes always does; contact.point or frame says where it is to be",
    "control.max_disturbance": "it is control.max_push",
    "planner.weights.terminal": "planner.weights.state is both",
    **{f"safety.fence_{end}": "safety.fence has both corners" for end in ("low", "high")},
    "simulation.gripper_closes": "a gripper of simulation.gripper_force = 0 never closes",
    "simulation.arm_mass": "simulation.vehicle_mass and vehicle_com say how a vehicle is heavier",
    "simulation.attitude_feedback": "moments are answered with simulation.attitude_lag",
    "simulation.sensors.tip_force_bias": "the sensor has none",
    **{f"simulation.gust.draught_{on}": "simulation.gust.draught acts on both" for on in ("vehicle", "leaf")},
    **{
        f"simulation.door_sensor.{name}": "it follows from simulation.door_sensor.kind"
        for name in ("frame", "rate", "latency", "place_noise", "turn_noise")
    },
    **{f"simulation.door_sensor.dropout_{name}": "it has no gaps" for name in ("rate", "duration")},
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
