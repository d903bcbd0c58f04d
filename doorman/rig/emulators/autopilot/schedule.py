"""When the emulated autopilot sends which message: the rates of a fresh link, and those that were asked for."""

from __future__ import annotations

from pymavlink.dialects.v20 import ardupilotmega as mavlink

PX4_RATES = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 20.0,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50.0,
    mavlink.MAVLINK_MSG_ID_HIGHRES_IMU: 20.0,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 30.0,
    mavlink.MAVLINK_MSG_ID_ODOMETRY: 30.0,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 5.0,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 0.5,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 5.0,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 5.0,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: 0.5,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 1.0,
}
"""Of a PX4 link before anybody asks for others [1/s]; for its own TIMESYNC it must be asked, as on a link in normal mode."""
ARDUPILOT_RATES = {mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0, mavlink.MAVLINK_MSG_ID_TIMESYNC: 0.1}
"""Of a fresh ArduPilot link [1/s]: nothing but the heartbeat until it is asked."""
SETTABLE = frozenset(
    {
        mavlink.MAVLINK_MSG_ID_ATTITUDE,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
        mavlink.MAVLINK_MSG_ID_ODOMETRY,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS,
        mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_HOME_POSITION,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT,
        mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN,
        mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION,
    }
)
"""Messages whose interval may be set, and that may be asked for, of both;"""
PX4_SETTABLE = SETTABLE | {
    mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS,
    mavlink.MAVLINK_MSG_ID_HIGHRES_IMU,
    mavlink.MAVLINK_MSG_ID_TIMESYNC,
}
"""of PX4."""


class Schedule:
    """When which message is due.

    Args:
        rates: Messages per second by identifier.
        settable: Messages whose interval may be set.
    """

    def __init__(self, rates: dict[int, float], settable: frozenset[int] = SETTABLE) -> None:
        self.settable = settable
        """Messages whose interval may be set."""
        self._defaults = dict(rates)
        self._periods: dict[int, float] = {}
        self._next: dict[int, float] = {}
        self.reset()

    def reset(self) -> None:
        """Rates as after a reboot."""
        self._periods = {identifier: 1.0 / rate for identifier, rate in self._defaults.items()}
        self._next = {}

    def set_interval(self, identifier: int, interval_us: float) -> bool:
        """SET_MESSAGE_INTERVAL: −1 stops, 0 is the default; False for a message that cannot be set."""
        if identifier not in self.settable:
            return False
        if interval_us < 0:
            self._periods.pop(identifier, None)
        elif interval_us == 0 and identifier in self._defaults:
            self._periods[identifier] = 1.0 / self._defaults[identifier]
        elif interval_us > 0:
            self._periods[identifier] = max(0.002, interval_us * 1e-6)
        return True

    def due(self, now: float) -> list[int]:
        """Identifiers of the messages that are due at a time [s]."""
        due = []
        for identifier, period in self._periods.items():
            at = self._next.get(identifier, now)
            if now >= at:
                self._next[identifier] = at + period if now - at < 3.0 * period else now + period
                due.append(identifier)
        return due
