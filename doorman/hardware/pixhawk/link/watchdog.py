"""Watchdogs: what has been silent for too long, or is too low."""

from __future__ import annotations

import math

from doorman.hardware.pixhawk.config import PixhawkConfig
from doorman.hardware.pixhawk.events import EventKind, LinkLog
from doorman.hardware.pixhawk.link.timesync import ClockMap
from doorman.hardware.pixhawk.sample import VehicleSample

_BATTERY_MARGIN = 0.02
"""A low battery is no longer low only this much above the threshold, as a share."""


class Watchdog:
    def __init__(self, config: PixhawkConfig, events: LinkLog) -> None:
        self._config = config
        self._events = events
        self._battery, self._charge_told = math.inf, math.inf

    def check(
        self, now: float, last_message: float, sample: VehicleSample, clock: ClockMap, mocap_time: float | None
    ) -> None:
        timeouts, note = self._config.timeouts, self._events.condition
        for kind, silent, allowed, words in (
            (EventKind.LINK_LOST, now - last_message, timeouts.link, "nothing from the autopilot"),
            (EventKind.HEARTBEAT_LOST, now - sample.heartbeat_time, timeouts.heartbeat, "no heartbeat"),
            (EventKind.STATE_STALE, sample.age(now), timeouts.state, "attitude or position is too old"),
            (EventKind.CLOCK_UNSYNCHRONISED, now - clock.last_update if clock.synchronised else math.inf, timeouts.clock,
             "the clock is not synchronised"),
            (EventKind.MOCAP_LOST, -math.inf if mocap_time is None else now - mocap_time, timeouts.mocap, "no fresh pose"),
        ):  # fmt: skip
            note(kind, silent > allowed, now, words, silent=silent)
        self._check_battery(now, sample, heard=now - last_message <= timeouts.link)

    def _check_battery(self, now: float, sample: VehicleSample, heard: bool) -> None:
        battery, low_already = sample.battery, EventKind.BATTERY_LOW in self._events.conditions
        if battery.time == -math.inf:
            return
        margin = 1.0 + _BATTERY_MARGIN if low_already else 1.0
        low = battery.alarm or battery.remaining < self._config.min_battery * margin
        if self._config.min_voltage is not None:
            low = low or 1.0 < battery.voltage < self._config.min_voltage * margin
        self._events.condition(
            EventKind.BATTERY_LOW, low, now, "battery low", voltage=battery.voltage, remaining=battery.remaining
        )
        if battery.id is not None:
            if battery.id < self._battery:  # the first one, that was not heard before, or for a while
                self._charge_told = math.inf
            self._battery = battery.id
        if math.isfinite(battery.remaining):
            self._charge_told = battery.time
        silent = now - self._charge_told
        mute = heard and silent > self._config.timeouts.battery
        self._events.condition(
            EventKind.BATTERY_SILENT, mute, now, "the autopilot no longer reports the charge", silent=silent
        )
