"""Telemetry rates: asked for by SET_MESSAGE_INTERVAL, measured, and asked for again where they fall short."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.hardware.pixhawk.wire.messages import IDENTIFIERS, Message, command_message, interval_us, mavlink

_CHECK_PERIOD = 1.0
_SHORTFALL = 0.7
"""A stream below this share of its rate is asked for again."""
_LONGEST_WAIT = 16.0
_TRIES_BEFORE_LESS = 2
"""Unheard requests before half the rate is asked for: ArduPilot refuses one above 0.8 of its loop's."""
_LEAST_SHARE = 0.25
"""Least share of the wanted rate that is requested."""


@dataclass
class _Stream:
    rate: float
    share: float = 1.0  # of the rate, that is asked for
    known: bool = False  # whether it was ever heard
    again: int = 0
    """Times that the whole rate is to be asked for once more: what was silent may not have been refused."""
    heard: int = 0
    measured: float = 0.0
    tries: int = 0
    wait: float = 0.0
    next_request: float = 0.0


class RateKeeper:
    """Keeps the streams that are wanted running, across losses and reboots; needs no acknowledgement."""

    def __init__(self, rates: dict[str, float]) -> None:
        self._streams = {name: _Stream(rate) for name, rate in rates.items()}
        self._next_check = 0.0
        self._last_check: float | None = None

    @property
    def measured(self) -> dict[str, float]:
        """Rate over the last second [1/s], by name of the message."""
        return {name: stream.measured for name, stream in self._streams.items()}

    @property
    def asked(self) -> dict[str, float]:
        return {name: stream.rate * stream.share for name, stream in self._streams.items()}

    @property
    def wanted(self) -> dict[str, float]:
        """Rates that are wanted [1/s], by name of the message."""
        return {name: stream.rate for name, stream in self._streams.items()}

    def want(self, name: str, rate: float) -> None:
        self._streams = {**self._streams, name: _Stream(rate)}

    def heard(self, name: str) -> None:
        stream = self._streams.get(name)
        if stream is not None:
            stream.heard += 1

    def restart(self) -> None:
        for stream in self._streams.values():
            stream.tries, stream.wait, stream.next_request = 0, 0.0, 0.0
            stream.share, stream.known, stream.again = 1.0, False, 0
            stream.measured, stream.heard = 0.0, 0
        self._next_check, self._last_check = 0.0, None

    def requests(self, now: float, system: int, component: int) -> list[Message]:
        """Requests that are due; call it often."""
        if now < self._next_check:
            return []
        elapsed = None if self._last_check is None else now - self._last_check
        self._last_check, self._next_check = now, now + _CHECK_PERIOD
        messages: list[Message] = []
        for name, stream in self._streams.items():
            if elapsed is not None:
                stream.measured = stream.heard / elapsed
            if stream.heard > 0 and not stream.known:
                stream.known, stream.again = True, _TRIES_BEFORE_LESS
            stream.heard = 0
            if stream.measured >= _SHORTFALL * stream.rate:
                stream.share = 1.0
            if stream.measured >= _SHORTFALL * stream.rate * stream.share:
                stream.tries, stream.wait = 0, 0.0
                if stream.share < 1.0 and stream.again > 0:
                    stream.again -= 1
                    messages.append(_interval_request(name, stream.rate, system, component))
            elif now >= stream.next_request:
                messages.append(self._request(name, stream, now, system, component))
        return messages

    def _request(self, name: str, stream: _Stream, now: float, system: int, component: int) -> Message:
        stream.tries += 1
        stream.wait = min(_LONGEST_WAIT, max(_CHECK_PERIOD, 2.0 * stream.wait)) if stream.tries > 2 else 0.0
        stream.next_request = now + stream.wait
        if not stream.known and stream.tries > _TRIES_BEFORE_LESS:
            stream.share = max(0.5 * stream.share, _LEAST_SHARE)
        return _interval_request(name, stream.rate * stream.share, system, component)


def _interval_request(name: str, rate: float, system: int, component: int) -> Message:
    interval = float(interval_us(rate))
    return command_message(
        (system, component), mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, float(IDENTIFIERS[name]), interval
    )
