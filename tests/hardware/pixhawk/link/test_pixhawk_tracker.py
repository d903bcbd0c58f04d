"""Telemetry to samples: order, plausibility, frames, units."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.hardware.pixhawk import LocalFrame
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4, dialect_of
from doorman.hardware.pixhawk.link.timesync import ClockMap
from doorman.hardware.pixhawk.link.tracker import Tracker
from doorman.hardware.pixhawk.sample import LandedState

NOW = 50.0


def synchronised() -> ClockMap:
    """The autopilot's clock is ours minus 40 s."""
    clock = ClockMap()
    for k in range(6):
        sent = round((49.0 + 0.1 * k) * 1e9)
        clock.answer(clock.ask(sent), sent - round(39.9995e9), sent + 1_000_000)
    return clock


@pytest.fixture
def tracker() -> Tracker:
    return Tracker(synchronised(), LocalFrame())


def attitude(stamp: int = 9990, q=(1.0, 0.0, 0.0, 0.0), rates=(0.1, 0.2, 0.3)):
    return mavlink.MAVLink_attitude_quaternion_message(stamp, *q, *rates)


def position(stamp: int = 9990, place=(1.0, 2.0, -3.0), speed=(0.1, 0.2, 0.3)):
    return mavlink.MAVLink_local_position_ned_message(stamp, *place, *speed)


def test_state_arrives_in_our_frames_and_on_our_clock(tracker):
    tracker.take(attitude(q=(math.cos(0.1), 0.0, 0.0, math.sin(0.1))), NOW)
    tracker.take(position(stamp=9980), NOW)
    sample = tracker.sample
    assert sample.position.tolist() == [1.0, -2.0, 3.0]
    assert sample.velocity.tolist() == [0.1, -0.2, -0.3]
    assert sample.body_rates.tolist() == [0.1, -0.2, -0.3]
    assert np.allclose(sample.attitude, [0.0, 0.0, -0.2])
    assert sample.attitude_time == pytest.approx(49.99, abs=1e-3)
    assert sample.position_time == pytest.approx(49.98, abs=1e-3)
    assert sample.age(NOW) == pytest.approx(0.02, abs=1e-3)
    assert not sample.position.flags.writeable and not sample.attitude.flags.writeable


def test_a_local_frame_turns_and_moves_the_state():
    tracker = Tracker(synchronised(), LocalFrame((10.0, 0.0, 0.0), math.pi / 2))
    tracker.take(position(place=(1.0, 0.0, 0.0), speed=(1.0, 0.0, 0.0)), NOW)
    tracker.take(attitude(), NOW)
    assert np.allclose(tracker.sample.position, [10.0, 1.0, 0.0])
    assert np.allclose(tracker.sample.velocity, [0.0, 1.0, 0.0])
    assert tracker.sample.attitude[2] == pytest.approx(math.pi / 2)


@pytest.mark.parametrize(
    ("stamps", "taken", "disordered", "invalid"),
    [([9990, 9990, 9980], 9990, 2, 0), ([20_000], None, 0, 1), ([10_100, *range(9970, 9990)], 9989, 5, 0)],
    ids=["copies and overtaken ones", "from the future", "one wrong stamp does not shut out the rest"],
)
def test_messages_count_in_the_order_of_their_stamps(tracker, stamps, taken, disordered, invalid):
    for stamp in stamps:
        tracker.take(position(stamp, place=(1e-3 * stamp, 0.0, 0.0)), NOW)
    assert (tracker.counters.disordered, tracker.counters.invalid) == (disordered, invalid)
    assert (
        np.isnan(tracker.sample.position[0])
        if taken is None
        else tracker.sample.position[0] == pytest.approx(1e-3 * taken)
    )


@pytest.mark.parametrize(
    "message",
    [
        attitude(q=(math.nan, 0.0, 0.0, 1.0)),
        attitude(q=(0.0, 0.0, 0.0, 0.0)),
        attitude(q=(3.0, 0.0, 0.0, 0.0)),
        attitude(rates=(math.inf, 0.0, 0.0)),
        position(place=(math.nan, 0.0, 0.0)),
        position(speed=(0.0, 0.0, 1e30)),
    ],
)
def test_what_cannot_be_true_is_left_out(tracker, message):
    tracker.take(message, NOW)
    assert tracker.counters.invalid == 1
    assert np.isnan(tracker.sample.position).all() and np.isnan(tracker.sample.quaternion).all()


def test_sequence_numbers_tell_copies_and_overtaken_messages(tracker):
    assert [tracker.in_order(number, NOW) for number in (250, 251, 251, 250, 3, 2, 4, 90)] == [
        True, True, False, False, True, False, True, True,
    ]  # fmt: skip
    assert not tracker.in_order(80, NOW + 0.05)
    assert tracker.in_order(80, NOW + 0.15), "after a silence, a number behind means nothing"


def test_the_sequence_of_a_rebooted_autopilot_is_picked_up(tracker):
    tracker.in_order(30, NOW)
    accepted = [tracker.in_order(number, NOW + 0.001 * number) for number in range(80)]
    assert accepted.index(True) <= 31 and all(accepted[31:])


def test_battery_by_cells_charge_and_alarm(tracker):
    cells = [3900] * 4 + [0xFFFF] * 6
    tracker.take(mavlink.MAVLink_battery_status_message(0, 0, 1, 0, cells, 1250, 0, 0, 44, 0, 2), NOW)
    battery = tracker.sample.battery
    assert (battery.voltage, battery.current, battery.remaining, battery.alarm) == (15.6, 12.5, 0.44, True)
    tracker.take(mavlink.MAVLink_battery_status_message(1, 0, 1, 0, [0] * 10, 0, 0, 0, 1, 0, 1), NOW)
    assert tracker.sample.battery is battery, "the second battery is another one"


def battery_status(number: int, remaining: int, cell: int = 3900):
    return mavlink.MAVLink_battery_status_message(
        number, 0, 1, 0, [cell] * 4 + [0xFFFF] * 6, 100, 0, 0, remaining, 0, 1
    )


def system_status(voltage: int, remaining: int):
    return mavlink.MAVLink_sys_status_message(0, 0, 0, 0, voltage, 100, remaining, 0, 0, 0, 0, 0, 0)


NO_CELL = 0xFFFF


@pytest.mark.parametrize(
    "rows",
    [
        [(0.0, battery_status(123, 60), 15.6, 0.6), (0.0, battery_status(1, 50), 15.6, 0.5),
         (1.0, battery_status(123, 60), 15.6, 0.5), (6.0, battery_status(123, 60), 15.6, 0.6)],
        [(0.0, system_status(15000, 40), 15.0, 0.4), (0.0, battery_status(0, 60), 15.6, 0.6),
         (0.1, system_status(15000, 40), 15.6, 0.6), (0.2, battery_status(0, 60, NO_CELL), 15.6, 0.6),
         (0.3, system_status(15000, 40), 15.0, 0.6), (4.0, battery_status(0, -1, NO_CELL), 15.0, 0.6),
         (6.0, system_status(14000, 30), 14.0, 0.3)],
    ],
    ids=["the first one need not have the number zero", "what is said of all does not mix with what is said of the first"],
)  # fmt: skip
def test_one_battery_counts(tracker, rows):
    for after, message, voltage, remaining in rows:
        tracker.take(message, NOW + after)
        assert (tracker.sample.battery.voltage, tracker.sample.battery.remaining) == (voltage, remaining), after


def test_a_battery_of_twelve_cells(tracker):
    message = mavlink.MAVLink_battery_status_message(0, 0, 1, 0, [3900] * 10, 1250, 0, 0, 44, 0, 2)
    message.voltages_ext = [3900, 3900, 0, 0]
    tracker.take(message, NOW)
    assert tracker.sample.battery.voltage == pytest.approx(46.8)


def test_a_position_counts_as_long_as_the_autopilot_believes_it(tracker):
    believed = mavlink.ESTIMATOR_ATTITUDE | mavlink.ESTIMATOR_POS_HORIZ_REL
    tracker.expect_estimator(NOW)
    tracker.take(position(9980), NOW + 0.1)
    assert np.isnan(tracker.sample.position).all(), "what it sends before it said anything may be zeros"
    tracker.estimator(believed)
    tracker.take(position(9981), NOW + 0.2)
    assert tracker.sample.position.tolist() == [1.0, -2.0, 3.0]
    for flags, stamp, taken in (*((1, 9982 + k, k < 4) for k in range(5)), (believed, 9987, True)):
        tracker.estimator(flags)
        before = tracker.sample.position_time
        tracker.take(position(stamp), NOW + 0.3)
        assert (tracker.sample.position_time > before) is taken, "a fault in its numbers passes"


def test_an_estimator_that_says_nothing_is_waited_for_a_while(tracker):
    tracker.expect_estimator(NOW)
    tracker.take(position(9990), NOW + 1.9)
    assert np.isnan(tracker.sample.position).all()
    tracker.take(position(9991), NOW + 2.1)
    assert not np.isnan(tracker.sample.position).any()


def test_readiness_and_battery_of_the_system_status(tracker):
    bit = mavlink.MAV_SYS_STATUS_PREARM_CHECK
    for enabled, health, expected in ((bit, bit, True), (bit, 0, False), (0, 0, None)):
        tracker.take(mavlink.MAVLink_sys_status_message(bit, enabled, health, 0, 15000, -1, -1, 0, 0, 0, 0, 0, 0), NOW)
        assert tracker.sample.ready_to_arm is expected
    assert tracker.sample.battery.voltage == 15.0 and math.isnan(tracker.sample.battery.current)


def test_landed_states(tracker):
    for number in range(5):
        tracker.take(mavlink.MAVLink_extended_sys_state_message(0, number), NOW)
        assert tracker.sample.landed is LandedState(number)
    tracker.take(mavlink.MAVLink_extended_sys_state_message(0, 77), NOW)
    assert tracker.sample.landed is LandedState.UNKNOWN


@pytest.mark.parametrize(
    ("dialect", "number", "name"),
    [
        (PX4, 6 << 16, "offboard"),
        (PX4, 4 << 16 | 6 << 24, "auto: land"),
        (PX4, 4 << 16 | 3 << 24, "auto: loiter"),
        (PX4, 3 << 16, "position"),
        (PX4, 99 << 16, "mode 99"),
        (ARDUPILOT, 4, "guided"),
        (ARDUPILOT, 9, "land"),
        (ARDUPILOT, 77, "mode 77"),
    ],
)
def test_modes_have_names(tracker, dialect, number, name):
    tracker.heartbeat(mavlink.MAVLink_heartbeat_message(13, dialect.autopilot, 0x81, number, 4, 3), dialect, NOW)
    assert str(tracker.sample.mode) == name
    assert tracker.sample.armed and tracker.sample.heartbeat_time == NOW


def test_dialects_are_told_by_the_heartbeat():
    assert dialect_of(12) is PX4 and dialect_of(3) is ARDUPILOT and dialect_of(8) is None
    assert PX4.mode_parameters(PX4.land_mode) == (1.0, 4.0, 6.0)
    assert PX4.mode_parameters(PX4.companion_mode) == (1.0, 6.0, 0.0)
    assert ARDUPILOT.mode_parameters(ARDUPILOT.land_mode) == (1.0, 9.0, 0.0)


@pytest.mark.parametrize("value", [0, 1, -1, 5, 255, 65535, -30000, 2**31 - 1])
def test_integer_parameters_of_px4_travel_as_bytes(value):
    assert PX4.decode_parameter(PX4.encode_parameter(value, 6), 6) == value
    assert PX4.encode_parameter(1, 6) != 1.0 and ARDUPILOT.encode_parameter(1, 6) == 1.0
    assert PX4.encode_parameter(0.5, 9) == 0.5
