"""Telemetry rates: asked for by SET_MESSAGE_INTERVAL, measured, and asked for again where they fall short."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.hardware.pixhawk.config import HEARTBEAT
from doorman.hardware.pixhawk.wire.messages import IDENTIFIERS, Message, command_message, mavlink

ENOUGH = 0.6
"""Share of a rate that must be reached: a stream below it is asked for again, and grounds a vehicle that needs it."""
_LONGEST_WAIT = 16 * HEARTBEAT
_TRIES_BEFORE_LESS = 2
"""Unheard requests before half the rate is asked for: ArduPilot refuses one above 0.8 of its loop's."""
_LEAST_SHARE = 1 / 4
"""Least share of the wanted rate that is requested."""


@dataclass
class Rate:
    """Rate of one message."""

    wanted: float  # [1/s]
    share: float = 1.0  # of it, that is asked for
    measured: float = 0.0  # over the last second [1/s]
    known: bool = False  # whether it was ever heard
    again: int = 0
    """Times that the whole rate is to be asked for once more: what was silent may not have been refused."""
    heard: int = 0
    tries: int = 0
    wait: float = 0.0
    next_request: float = 0.0

    @property
    def asked(self) -> float:
        return self.wanted * self.share


class RateKeeper:
    """Keeps the streams that are wanted running, across losses and reboots; needs no acknowledgement."""

    def __init__(self, rates: dict[str, float]) -> None:
        self.rates = {name: Rate(rate) for name, rate in rates.items()}
        self._next_check = 0.0
        self._last_check: float | None = None

    def want(self, name: str, rate: float) -> None:
        self.rates = {**self.rates, name: Rate(rate)}

    def heard(self, name: str) -> None:
        if name in self.rates:
            self.rates[name].heard += 1

    def restart(self) -> None:
        self.rates = {name: Rate(rate.wanted) for name, rate in self.rates.items()}
        self._next_check, self._last_check = 0.0, None

    def requests(self, now: float, target: tuple[int, int]) -> list[Message]:
        """Requests that are due; call it often."""
        if now < self._next_check:
            return []
        elapsed = None if self._last_check is None else now - self._last_check
        self._last_check, self._next_check = now, now + HEARTBEAT
        due = [(name, self._due(rate, now, elapsed)) for name, rate in self.rates.items()]
        return [
            command_message(target, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, float(IDENTIFIERS[name]), float(round(1e6 / rate)))
            for name, rate in due
            if rate is not None
        ]  # fmt: skip

    def _due(self, rate: Rate, now: float, elapsed: float | None) -> float | None:
        """Rate to ask for now; None where the message comes as it was asked for, or the next request is not due."""
        if elapsed is not None:
            rate.measured = rate.heard / elapsed
        if rate.heard > 0 and not rate.known:
            rate.known, rate.again = True, _TRIES_BEFORE_LESS
        rate.heard = 0
        if rate.measured >= ENOUGH * rate.wanted:
            rate.share = 1.0
        if rate.measured >= ENOUGH * rate.asked:
            rate.tries, rate.wait = 0, 0.0
            if rate.share == 1.0 or rate.again == 0:
                return None
            rate.again -= 1
            return rate.wanted
        if now < rate.next_request:
            return None
        rate.tries += 1
        rate.wait = min(_LONGEST_WAIT, max(HEARTBEAT, 2.0 * rate.wait)) if rate.tries > 2 else 0.0
        rate.next_request = now + rate.wait
        if not rate.known and rate.tries > _TRIES_BEFORE_LESS:
            rate.share = max(0.5 * rate.share, _LEAST_SHARE)
        return rate.asked
