"""Units of MAVLink fields and their SI values; "unknown" on the wire becomes NaN here, never a number."""

from __future__ import annotations

import math

_UNKNOWN_VOLTAGE = 0xFFFF
_WRAP_MS = 1 << 32


def seconds_to_us(seconds: float) -> int:
    return round(seconds * 1e6)


def ms_to_seconds(milliseconds: int) -> float:
    return milliseconds * 1e-3


def seconds_to_boot_ms(seconds: float) -> int:
    """Time [s] as the 32 bit count of milliseconds that MAVLink stamps carry."""
    return round(seconds * 1e3) % _WRAP_MS


def boot_ms_difference(newer: int, older: int) -> int:
    """Signed difference of two 32 bit stamps [ms], across a wrap too."""
    return (newer - older + _WRAP_MS // 2) % _WRAP_MS - _WRAP_MS // 2


def millivolts_to_volts(millivolts: int) -> float:
    """Voltage of SYS_STATUS [V]; NaN where the autopilot does not know it."""
    return math.nan if millivolts == _UNKNOWN_VOLTAGE else millivolts * 1e-3


def cells_to_volts(cells: list[int]) -> float:
    """Sum of the cells' voltages of BATTERY_STATUS [V]; NaN where no cell is known."""
    # A pack of more than 65.5 V is sent as several full "cells", which this adds up too.
    known = [cell for cell in cells if cell != _UNKNOWN_VOLTAGE]
    return sum(known) * 1e-3 if known else math.nan


def centiamperes_to_amperes(centiamperes: int) -> float:
    """Current [A]; NaN where the autopilot does not know it."""
    return math.nan if centiamperes < 0 else centiamperes * 1e-2


def percent_to_share(percent: int) -> float:
    """Remaining charge as a share; NaN where the autopilot does not know it."""
    return math.nan if percent < 0 else percent * 1e-2


def interval_us(rate: float) -> int:
    """Period [µs] of a rate [1/s], as SET_MESSAGE_INTERVAL takes it."""
    return round(1e6 / rate)
