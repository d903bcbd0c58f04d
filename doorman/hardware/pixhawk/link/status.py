"""Figures of the link, for checklists and status lines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from doorman.hardware.pixhawk.authority import Authority
from doorman.hardware.pixhawk.events import RARELY, EventKind
from doorman.hardware.pixhawk.link.link import Link
from doorman.hardware.pixhawk.link.mocap import MocapStatistics
from doorman.hardware.pixhawk.link.stream import Source
from doorman.hardware.pixhawk.wire.codec import Counters


@dataclass(frozen=True)
class LinkStatus:
    """The link as it is now."""

    dialect: str
    """`PX4` or `ArduPilot`; empty before the first heartbeat."""
    feedback_lag: float
    """Lag with which its attitude loop answers a moment, where it follows setpoints sooner; 0 where it does not [s]."""
    authority: Authority
    source: Source
    conditions: frozenset[EventKind]
    synchronised: bool
    clock_offset: float
    """Our clock minus the autopilot's [s]; NaN before synchronisation."""
    round_trip: float
    """Median of TIMESYNC [s]."""
    rates: Mapping[str, float]
    """Measured messages per second, by name."""
    wanted_rates: Mapping[str, float]
    """Messages per second that would be best, by name."""
    asked_rates: Mapping[str, float]
    """Messages per second that are asked for, by name: less where the autopilot refused more."""
    messages: int
    corrupted: int
    disordered: int
    invalid: int
    foreign: int
    bad_signatures: int
    longest_setpoint_gap: float
    """[s]"""
    namesake: bool
    """Whether another station with our system id was heard lately: the autopilot does not notice our loss then."""
    on_earth: bool | None
    """Whether the autopilot says that it has an origin on earth, without which it has no home; None where it is not asked."""
    mocap: MocapStatistics


def link_status(link: Link, now: float) -> LinkStatus:
    counters = Counters() if link.codec is None else link.codec.counters
    dialect, rates = link.dialect, link.rates.rates.items()
    return LinkStatus(
        dialect="" if dialect is None else dialect.name,
        feedback_lag=0.0 if dialect is None else dialect.feedback_lag,
        authority=link.authority.state,
        source=link.stream.source,
        conditions=link.events.conditions,
        synchronised=link.clock.synchronised,
        clock_offset=link.clock.offset(now),
        round_trip=link.clock.round_trip,
        rates=MappingProxyType({name: rate.measured for name, rate in rates}),
        wanted_rates=MappingProxyType({name: rate.wanted for name, rate in rates}),
        asked_rates=MappingProxyType({name: rate.asked for name, rate in rates}),
        messages=counters.messages,
        corrupted=counters.corrupted + counters.malformed,
        disordered=link.tracker.counters.disordered,
        invalid=link.tracker.counters.invalid,
        foreign=link.foreign,
        namesake=now - link.namesake < RARELY,
        bad_signatures=counters.bad_signatures,
        longest_setpoint_gap=link.stream.longest_gap,
        on_earth=None if link.origin is None else link.origin.known,
        mocap=link.mocap.statistics(),
    )
