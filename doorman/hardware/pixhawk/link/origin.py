"""A place on earth for an autopilot without GPS: given until it has one, and poses only after that.

ArduPilot has no position without, and calls the height at which it stands zero in the second after it got its origin
(`AP_Baro::update_field_elevation`). A pose that came before makes that a step: from then on its heights are larger than
mocap's by the height of the pose. An origin that comes while its filter begins is confirmed, and forgotten by the filter; without
one it navigates, but does not arm in GUIDED ("waiting for home"). So doorman asks as long as it stands.

PX4 flies without, but has no home then: it neither returns to its pad nor holds when its pilot asks for that. It takes every
origin that comes, and one that comes late moves its position: by the origin's altitude, and by 5200 km where it navigates
already (development version of August 2026). So it gets one, of altitude zero, only while it has neither origin nor position.
"""

from __future__ import annotations

from doorman.hardware.pixhawk.wire.messages import Message, command_message, mavlink

_UNANSWERED = 5
"""Questions without an answer after which an autopilot on the ground counts as without an origin."""
_QUESTIONS = 3
"""Questions to PX4 before it gets an origin: an answer may be lost."""
_NAVIGATES = mavlink.ESTIMATOR_POS_HORIZ_REL | mavlink.ESTIMATOR_POS_HORIZ_ABS | mavlink.ESTIMATOR_PRED_POS_HORIZ_REL


class Origin:
    """Gives the origin, and says when poses may follow; used by the thread of the link only. This one is ArduPilot's."""

    patience = 20.0  # for one that never says that it has an origin: then poses are sent all the same [s]
    period = 1.0  # between two questions [s]
    settling = 2.0  # between the origin and the first pose [s]
    questions: tuple[int, ...] = (
        mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN,
    )  # identifiers of the messages that it is asked for
    forgetful = True  # whether it may lose an origin that it had, without a reboot

    def __init__(self, place: tuple[float, float, float]) -> None:
        self._place = round(place[0] * 1e7), round(place[1] * 1e7), round(place[2] * 1e3)
        self.reset()

    def reset(self) -> None:
        self._next, self._began, self._heard, self._confirmed = 0.0, float("inf"), float("inf"), float("-inf")

    @property
    def known(self) -> bool:
        return self._heard < float("inf")

    def heard(self, now: float) -> None:
        """Take in that the autopilot says that it has an origin."""
        self._heard, self._confirmed = min(self._heard, now), now

    def estimator(self, flags: int) -> None:
        """Take in how the autopilot says that its estimator is."""

    def settled(self, now: float, armed: bool) -> bool:
        """Whether poses may be sent; the height's zero of an armed vehicle stays."""
        if armed:
            return True
        return now > (self._heard + self.settling if self._heard <= now else self._began + self.patience)

    def messages(self, now: float, target: tuple[int, int], armed: bool) -> list[Message]:
        """Messages that are due: the origin, and the question whether the autopilot has one. Right after boot it has none."""
        self._began = min(self._began, now)
        if self.known and (armed or not self.forgetful):
            self._confirmed = now
            return []
        if now < self._next:
            return []
        if self.known and now - self._confirmed > _UNANSWERED * self.period:
            self.reset()
            self._began = now
        self._next = now + self.period
        gives = not self.known and self._may_give(armed)
        given = [mavlink.MAVLink_set_gps_global_origin_message(target[0], *self._place)] if gives else []
        asked = (command_message(target, mavlink.MAV_CMD_REQUEST_MESSAGE, float(one)) for one in self.questions)
        return [*given, *asked]

    def _may_give(self, armed: bool) -> bool:
        """Whether an origin does no harm now: ArduPilot keeps the one that it has."""
        return True


class CautiousOrigin(Origin):
    """PX4's: asks first, and gives none once poses may have gone out, or to an estimator that may have a position."""

    patience, period, settling, forgetful = 5.0, 0.5, 0.0, False
    questions = (mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN, mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS)

    def __init__(self, place: tuple[float, float, float]) -> None:
        super().__init__((place[0], place[1], 0.0))

    def reset(self) -> None:
        super().reset()
        self._questions_sent, self._lost, self._released = 0, False, False

    def estimator(self, flags: int) -> None:
        """Take in how the autopilot says that its estimator is; only its word since the last question counts."""
        self._lost = not flags & _NAVIGATES
        if not self._lost:
            self._began = float("-inf")  # there is nothing to wait for

    def settled(self, now: float, armed: bool) -> bool:
        """Whether poses may be sent; once they may, they always may."""
        self._released = self._released or super().settled(now, armed)
        return self._released

    def _may_give(self, armed: bool) -> bool:
        lost, self._lost = self._lost, False
        self._questions_sent += 1
        return self._questions_sent > _QUESTIONS and lost and not (armed or self._released)
