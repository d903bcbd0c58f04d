"""What the emulated autopilot sends by itself: messages and their stamps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.brain import Brain
from doorman.rig.emulators.autopilot.control import Task
from doorman.rig.emulators.autopilot.earth import global_origin, global_position, home_position, satellites
from doorman.rig.emulators.autopilot.estimator import Estimate
from doorman.rig.emulators.autopilot.plant import Array, into_body, yaw_of
from doorman.rig.emulators.autopilot.way_home import Home

FLIP = np.array([1.0, -1.0, -1.0])
"""NED or FRD of a world with z up or a body with z up, and back: half a turn about x."""
FLIP_QUATERNION = np.array([1.0, 1.0, -1.0, -1.0])

_SENSORS = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mavlink.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
)
"""That every vehicle has, calibrated."""
_VISION = mavlink.MAV_SYS_STATUS_SENSOR_VISION_POSITION
_PREARM_CHECK = mavlink.MAV_SYS_STATUS_PREARM_CHECK
_CAPABILITIES = (
    mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
)
"""Those of the real ones that are emulated: no missions, fences or files."""
_FIELD, _AIR = np.array([0.21, 0.0, -0.43]), 1013.25
"""Of the earth in Switzerland, shape (3,), world frame [gauss], and pressure [mbar]."""
_PX4_VERSION, _ARDUPILOT_VERSION = 0x01_10_00_FF, 0x04_06_03_FF
"""Releases 1.16.0 and 4.6.3."""


@dataclass
class EmulatedBattery:
    """What the power module measures; set it at any time."""

    voltage: float = 15.6
    """[V]"""
    current: float = 12.0
    """[A]"""
    remaining: float = 0.9
    """0 … 1"""
    silent: bool = False
    """Whether nobody measures it."""

    @property
    def charge_state(self) -> int:
        """MAV_BATTERY_CHARGE_STATE by the remaining charge."""
        return 3 if self.remaining < 0.07 else 2 if self.remaining < 0.15 else 1


def estimator_status(boot_seconds: float, landed: bool, located: bool) -> Any:
    """PX4's ESTIMATOR_STATUS.

    Args:
        boot_seconds: Time of the autopilot's clock [s].
        landed: Whether the vehicle stands on the ground.
        located: Whether the estimator has a position.
    """
    flags = mavlink.ESTIMATOR_ATTITUDE
    flags |= mavlink.ESTIMATOR_CONST_POS_MODE if landed or not located else 0
    flags |= mavlink.ESTIMATOR_POS_HORIZ_REL if located else 0
    return mavlink.MAVLink_estimator_status_message(round(boot_seconds * 1e6), flags, *[0.0] * 8)


class Telemetry:
    """Builds messages.

    Args:
        brain: Modes.
        battery: Power.
        vehicle_type: MAV_TYPE.
        satellites: Whether it has a receiver for them.
    """

    def __init__(self, brain: Brain, battery: EmulatedBattery, vehicle_type: int, *, satellites: bool) -> None:
        self.brain = brain
        self._battery = battery
        self._type = vehicle_type
        self._satellites = satellites
        self.confused = False
        """Whether its state is not numbers."""

    def message(
        self, identifier: int, boot_seconds: float, estimate: Estimate, steered: Array, thrust: float
    ) -> Any | None:
        """The message of an identifier as of now; None if there is none to send.

        Args:
            identifier: Of the message.
            boot_seconds: Time of the autopilot's clock [s].
            estimate: What it believes.
            steered: Attitude by which its controller steers.
            thrust: Normalised, that its controller asks of the mixer.
        """
        boot_ms = int(boot_seconds * 1e3) % (1 << 32)
        if identifier == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
            return self._heartbeat()
        if identifier == mavlink.MAVLINK_MSG_ID_ATTITUDE:
            angles, rates = _angles(estimate.quaternion) * FLIP * self._sense, estimate.body_rates * FLIP
            return mavlink.MAVLink_attitude_message(boot_ms, *angles.tolist(), *rates.tolist())
        if identifier == mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION:
            q, rates = estimate.quaternion * FLIP_QUATERNION * self._sense, estimate.body_rates * FLIP
            return mavlink.MAVLink_attitude_quaternion_message(boot_ms, *q.tolist(), *rates.tolist())
        if identifier == mavlink.MAVLINK_MSG_ID_HIGHRES_IMU:
            return _inertial(boot_seconds, estimate)
        if identifier == mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED:
            if not self._has_position(estimate):
                return None
            place, speed = estimate.position * FLIP * self._sense, estimate.velocity * FLIP
            return mavlink.MAVLink_local_position_ned_message(boot_ms, *place.tolist(), *speed.tolist())
        if identifier == mavlink.MAVLINK_MSG_ID_ODOMETRY:
            return self._odometry(boot_seconds, estimate) if self._has_position(estimate) else None
        if identifier == mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET:
            q = steered * FLIP_QUATERNION
            return mavlink.MAVLink_attitude_target_message(boot_ms, 0, q.tolist(), 0.0, 0.0, 0.0, thrust)
        if identifier == mavlink.MAVLINK_MSG_ID_SYS_STATUS:
            return self._system(estimate)
        if identifier == mavlink.MAVLINK_MSG_ID_BATTERY_STATUS:
            return None if self._battery.silent else self._battery_status()
        if identifier == mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE:
            return mavlink.MAVLink_extended_sys_state_message(0, self._landed_state())
        if identifier == mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS:
            return estimator_status(boot_seconds, self.brain.landed, estimate.position_valid)
        if identifier == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            return self._version()
        return self._on_earth(identifier, boot_ms, estimate)

    def _on_earth(self, identifier: int, boot_ms: int, estimate: Estimate) -> Any | None:
        """Messages that need an origin, and all but that of the origin a position."""
        origin = estimate.origin
        if origin is None:
            return None
        if identifier == mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN:
            return global_origin(origin)
        if not estimate.on_earth:
            return None
        home = self.brain.home if self.brain.armed else Home.of(estimate)
        if identifier == mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT:
            yaw = yaw_of(estimate.quaternion)
            return global_position(boot_ms, origin, estimate.position, estimate.velocity, yaw, home.position)
        if identifier == mavlink.MAVLINK_MSG_ID_HOME_POSITION:
            return home_position(boot_ms, origin, home.position, home.yaw)
        if identifier == mavlink.MAVLINK_MSG_ID_GPS_RAW_INT and self._satellites:
            return satellites(boot_ms, origin, estimate.position)
        return None

    def _version(self) -> Any:
        px4 = self.brain.vendor == mavlink.MAV_AUTOPILOT_PX4
        capabilities = _CAPABILITIES | (mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE if px4 else 0)
        version, nothing = _PX4_VERSION if px4 else _ARDUPILOT_VERSION, [0] * 8
        return mavlink.MAVLink_autopilot_version_message(
            capabilities, version, version if px4 else 0, 0, 0, nothing, nothing, nothing, 0, 0, 0
        )

    @property
    def _sense(self) -> float:
        return math.nan if self.confused else 1.0

    def _landed_state(self) -> int:
        """MAV_LANDED_STATE."""
        if self.brain.landed:
            return int(mavlink.MAV_LANDED_STATE_ON_GROUND)
        if self.brain.demand.task is Task.LAND:
            return int(mavlink.MAV_LANDED_STATE_LANDING)
        return int(mavlink.MAV_LANDED_STATE_TAKEOFF if self.brain.taking_off else mavlink.MAV_LANDED_STATE_IN_AIR)

    def _has_position(self, estimate: Estimate) -> bool:
        """PX4 sends what it has; ArduPilot only what it calls valid."""
        return estimate.position_valid or self.brain.vendor == mavlink.MAV_AUTOPILOT_PX4

    def _heartbeat(self) -> Any:
        brain = self.brain
        base = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        base |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED if brain.armed else 0
        status = mavlink.MAV_STATE_STANDBY
        if brain.armed:
            status = mavlink.MAV_STATE_CRITICAL if brain.failsafe else mavlink.MAV_STATE_ACTIVE
            if brain.killed and brain.vendor == mavlink.MAV_AUTOPILOT_PX4:  # ArduPilot's says nothing
                status = mavlink.MAV_STATE_FLIGHT_TERMINATION
        return mavlink.MAVLink_heartbeat_message(self._type, brain.vendor, base, brain.mode, status, 3)

    def _odometry(self, boot_seconds: float, estimate: Estimate) -> Any:
        q = estimate.quaternion * FLIP_QUATERNION
        speed = into_body(estimate.quaternion, estimate.velocity) * FLIP
        unknown = [math.nan, *[0.0] * 20]
        return mavlink.MAVLink_odometry_message(
            int(boot_seconds * 1e6),
            mavlink.MAV_FRAME_LOCAL_NED,
            mavlink.MAV_FRAME_BODY_FRD,
            *(estimate.position * FLIP).tolist(),
            q.tolist(),
            *speed.tolist(),
            *(estimate.body_rates * FLIP).tolist(),
            unknown,
            unknown,
            0,
            mavlink.MAV_ESTIMATOR_TYPE_AUTOPILOT,
            100,
        )

    def _system(self, estimate: Estimate) -> Any:
        ready = estimate.position_valid and not self.brain.refusal.active
        sensors = _SENSORS | (mavlink.MAV_SYS_STATUS_SENSOR_GPS if self._satellites else _VISION)
        unwell = 0 if estimate.position_valid else mavlink.MAV_SYS_STATUS_SENSOR_GPS | _VISION
        health = sensors & ~unwell | (_PREARM_CHECK if ready else 0)
        told = 0 if self.brain.vendor == mavlink.MAV_AUTOPILOT_PX4 else _PREARM_CHECK  # PX4 since 1.14: in health alone
        battery = self._battery
        power = round(battery.voltage * 1e3), round(battery.current * 1e2), round(battery.remaining * 1e2)
        unknown = 0xFFFF, -1, -1
        return mavlink.MAVLink_sys_status_message(
            told | sensors, told | sensors, health, 200, *(unknown if battery.silent else power), 0, 0, 0, 0, 0, 0
        )

    def _battery_status(self) -> Any:
        battery = self._battery
        cells = [round(battery.voltage / 4.0 * 1e3)] * 4 + [0xFFFF] * 6
        return mavlink.MAVLink_battery_status_message(
            0, 0, 1, 32767, cells, round(battery.current * 1e2), -1, -1, round(battery.remaining * 1e2), 0,
            battery.charge_state,
        )  # fmt: skip


def _inertial(boot_seconds: float, estimate: Estimate) -> Any:
    """HIGHRES_IMU: accelerations and rates; a field that points north and down, and the air at sea level."""
    force, rates = estimate.specific_force * FLIP, estimate.body_rates * FLIP
    field = into_body(estimate.quaternion, _FIELD) * FLIP
    return mavlink.MAVLink_highres_imu_message(
        round(boot_seconds * 1e6), *force.tolist(), *rates.tolist(), *field.tolist(), _AIR, 0.0,
        float(estimate.position[2]), 20.0, 0xFFFF >> 3,
    )  # fmt: skip


def _angles(quaternion: Array) -> Array:
    """Roll, pitch and yaw [rad]."""
    w, x, y, z = quaternion.tolist()
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    return np.array([roll, pitch, yaw_of(quaternion)])
