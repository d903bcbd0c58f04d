"""A place on earth for ArduPilot without GPS: given until it has one, and poses only after that.

ArduPilot calls the height at which it stands zero in the second after it got its origin (`AP_Baro::update_field_elevation`).
A pose that came before makes that a step: from then on its heights are larger than mocap's by the height of the pose.
"""

from __future__ import annotations

from doorman.hardware.pixhawk.messages import Message, command_message, mavlink

_PERIOD = 1.0
_SETTLING = 2.0
"""Between the origin and the first pose [s]."""
_PATIENCE = 20.0
"""For an autopilot that never says that it has an origin; then poses are sent all the same [s]."""


class Origin:
    """Gives the origin, and says when poses may follow; used by the thread of the link only.

    Args:
        place: Latitude [°], longitude [°], altitude [m].
    """

    def __init__(self, place: tuple[float, float, float]) -> None:
        self._place = round(place[0] * 1e7), round(place[1] * 1e7), round(place[2] * 1e3)
        self.reset()

    def reset(self) -> None:
        """Begin anew, as after a reboot."""
        self._next, self._began, self._heard = 0.0, float("inf"), float("inf")

    def heard(self, now: float) -> None:
        """The autopilot says that it has an origin."""
        self._heard = min(self._heard, now)

    def settled(self, now: float, armed: bool) -> bool:
        """Whether poses may be sent; the height's zero of an armed vehicle stays."""
        if armed:
            return True
        return now > (self._heard + _SETTLING if self._heard <= now else self._began + _PATIENCE)

    def messages(self, now: float, system: int, component: int) -> list[Message]:
        """What is due: the origin, and the question whether it was taken, which right after boot it is not."""
        self._began = min(self._began, now)
        if self._heard <= now or now < self._next:
            return []
        self._next = now + _PERIOD
        wanted = float(mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN)
        return [
            mavlink.MAVLink_set_gps_global_origin_message(system, *self._place),
            command_message((system, component), mavlink.MAV_CMD_REQUEST_MESSAGE, wanted),
        ]
