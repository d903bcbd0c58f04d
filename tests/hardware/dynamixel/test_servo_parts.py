"""Parts of the servo adapter that need no bus: registers, units, braking law, clock, configuration, log, samples."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.exceptions import BackendError, DimensionError
from doorman.hardware.dynamixel import LATCHED, STOPPING, WARNINGS, ServoBus, ServoConfig, ServoFault, zero_position
from doorman.hardware.dynamixel import registers as reg
from doorman.hardware.dynamixel.cycle import RateGovernor, allowed_rate, stopping_rate
from doorman.hardware.dynamixel.link import Reply
from doorman.hardware.dynamixel.monitor import DRIFT, ServoClock, ServoMonitor
from doorman.hardware.dynamixel.registers import Telemetry, Unit, joint_angle, whole_turns
from doorman.rig.emulators.servos.table import BAUD_RATES, ITEMS, TABLE_END

LIMITS = {"lower_limits": [-1.0, -2.0], "upper_limits": [1.0, 2.0], "rate_limits": [3.1, 3.1], "ids": (1, 2)}


def config(**fields):
    return ServoConfig("nowhere", **(LIMITS | fields))


HEALTHY = Telemetry(2048, 0, 0, 0, 30, 120, 1, config().watchdog_counts, 77)


# ---------------------------------------------------------------- registers


def test_registers_are_those_of_the_emulated_table():
    registers = {one for one in vars(reg).values() if isinstance(one, reg.Register)} - {reg.MAPPING, reg.TELEMETRY}
    assert len(registers) > 25
    for register in registers:
        item = ITEMS[register.name]
        assert (register.address, register.size) == (item.address, item.size)
        if item.writable:
            assert register.signed == (item.low < 0)
    assert [BAUD_RATES[code] for code in reg.BAUD_CODES.values()] == list(reg.BAUD_CODES)
    assert max(item.address + item.size for item in ITEMS.values()) == TABLE_END


def test_the_block_is_what_its_mapping_gathers():
    mapped = reg.MAPPING.encode(reg.MAPPED)
    addresses = [int.from_bytes(mapped[i : i + 2], "little") for i in range(0, len(mapped), 2)]
    assert addresses == [r.address + k for r in reg.BLOCK for k in range(r.size)]
    assert len(addresses) == reg.TELEMETRY.size <= 28
    values = (-7, -3, -5, 0x24, 55, 118, 1, 5, 32767)
    assert Telemetry.decode(b"".join(r.encode(v) for r, v in zip(reg.BLOCK, values, strict=True))) == values


@pytest.mark.parametrize(
    ("row", "ours"),
    [
        (Telemetry.decode(bytes(reg.TELEMETRY.size)), False),
        (HEALTHY, True),
        (HEALTHY._replace(bus_watchdog=6), False),
        (HEALTHY._replace(bus_watchdog=0), True),
        (HEALTHY._replace(bus_watchdog=0xFF), True),
        (HEALTHY._replace(bus_watchdog=0, torque_enable=0), False),
    ],
)
def test_a_restarted_servo_shows_zeros_and_is_told_from_one_that_is_set_up(row, ours):
    assert row.is_ours(config().watchdog_counts) == ours


class Asked:
    """A servo whose answers a monitor takes in; returns what is believed."""

    def __init__(self, **fields):
        self.monitor = ServoMonitor(config(**fields), 0.0, 1000, 0)

    def __call__(self, time, position, velocity=0):
        row = HEALTHY._replace(position=position, velocity=velocity, tick=int(1e3 * time))
        data = b"".join(register.encode(value) for register, value in zip(reg.BLOCK, row, strict=True))
        return self.monitor.take(Reply(ServoFault.NONE, time, time + 0.001, data=data))


def test_what_was_measured_before_a_servo_was_set_up_again_stays_as_old_as_it_is():
    take = Asked()
    assert take(1.0, 2048) == HEALTHY._replace(tick=1000)
    take.monitor.condemn(ServoFault.OVERLOAD)
    take.monitor.recovered()
    assert not take.monitor.fault
    assert take.monitor.take(Reply(ServoFault.TIMEOUT, 3.0, 3.01)) is None
    assert take.monitor.time == 1.0 and take.monitor.fault & ServoFault.STALE


def test_one_angle_that_jumps_is_left_out_and_two_in_a_row_are_a_fault():
    take = Asked()
    assert take(1.0, 2048)
    assert take(1.005, 2148) is None
    assert take.monitor.fault == ServoFault.JUMPED and not take.monitor.latched, "one in 65536 is damaged unseen"
    assert take(1.01, 2050)
    assert not take.monitor.fault
    assert take(1.015, 2148) is None
    assert take(1.02, 2147) is None
    assert take.monitor.latched == ServoFault.JUMPED
    assert take(1.2, 2147) is None, "by now it could have turned so far"


@pytest.mark.parametrize(
    ("rate", "step", "held_up"),
    [(3.0, 0.005, 0.0), (-3.0, 0.01, 0.0), (3.0, 0.1, 0.0), (6.0, 0.005, 0.0), (3.0, 0.005, 0.015)],
)
def test_an_angle_that_turns_as_fast_as_it_may_or_says_does_not_jump(rate, step, held_up):
    """Nor one whose question was held up: it is stamped before the computer hands it to the line."""
    take = Asked(latency=0.015)
    for k in range(40):
        at = k * step + (held_up if k == 20 else 0.0)
        assert take(1.0 + k * step, 2048 + round(rate * at / Unit.ANGLE), round(rate / Unit.VELOCITY))
    assert not take.monitor.fault


# ---------------------------------------------------------------- units


@given(st.integers(-4096, 8192), st.integers(-3000, 5000), st.sampled_from([1, -1]))
def test_zero_position_inverts_the_joint_angle(position, zero, direction):
    angle = joint_angle(position, zero, direction)
    assert zero_position(position, angle, direction) == zero
    assert joint_angle(position + 1, zero, direction) - angle == pytest.approx(direction * Unit.ANGLE)


@given(st.floats(-1.6, 1.6), st.integers(-3, 3))
def test_the_joints_limits_tell_the_turn(angle, turns):
    read = angle + turns * 2.0 * math.pi
    assert read + whole_turns(read, -1.65, 1.65) == pytest.approx(angle, abs=1e-9)


def test_at_the_border_of_a_full_turn_the_reading_stands():
    assert whole_turns(math.pi, -math.pi, math.pi) == 0.0
    assert whole_turns(-math.pi, -math.pi, math.pi) == 0.0
    assert whole_turns(0.2, 0.5, 1.0) == 0.0, "outside the limits either way"


# ---------------------------------------------------------------- braking


@given(st.floats(0.0, 3.0), st.floats(0.5, 30.0), st.floats(0.0, 0.2))
def test_the_stopping_rate_uses_the_whole_distance(distance, deceleration, delay):
    rate = stopping_rate(distance, deceleration, delay)
    assert rate * delay + rate**2 / (2.0 * deceleration) == pytest.approx(distance, rel=1e-6, abs=1e-9)


@given(st.floats(-5.0, 5.0), st.floats(-1.5, 1.5))
def test_rates_are_only_cut(asked, angle):
    rate = allowed_rate(asked, angle, -1.0, 1.0, 3.0, 10.0, 0.03)
    assert abs(rate) <= min(abs(asked), 3.0)
    assert rate * asked >= 0.0
    if angle >= 1.0:
        assert rate <= 0.0
    if angle <= -1.0:
        assert rate >= 0.0
    if abs(angle) >= 1.0 and asked * angle < 0.0:
        assert abs(rate) == pytest.approx(min(abs(asked), 3.0)), "the way back is open"


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_stops(bad):
    assert allowed_rate(bad, 0.0, -1.0, 1.0, 3.0, 10.0, 0.03) == 0.0
    assert allowed_rate(1.0, bad, -1.0, 1.0, 3.0, 10.0, 0.03) == 0.0


@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_a_joint_at_full_speed_stops_before_its_limit(lag):
    """A servo with a lag and an old measurement, which brakes no harder than it can."""
    angle, rate, delay, step = -1.0, 0.0, 0.03, 0.005
    history = [angle] * (1 + round((delay - lag) / step))
    for _ in range(2000):
        goal = allowed_rate(3.1, history[0], -1.0, 1.0, 3.1, 10.0, delay)
        wanted = goal if lag == 0.0 else rate + (goal - rate) * step / lag
        rate += max(min(wanted - rate, 11.0 * step), -11.0 * step)
        angle += rate * step
        history = [*history[1:], angle]
        assert angle < 1.0 + config().limit_margin, "that is what the margin is for"
    assert angle > 0.97


def governor_of(*velocity_limits, **fields):
    return RateGovernor(config(**fields), [SimpleNamespace(velocity_limit=limit) for limit in velocity_limits])


def counts_of(governor, rate):
    return governor.counts([rate, 0.0], [0.0, 0.0], [0.0, 0.0])[0]


@given(st.floats(-3.0, 3.0), st.integers(50, 400))
def test_rounding_keeps_the_mean(rate, cycles):
    governor = governor_of(150, 150, lower_limits=[-99.0] * 2, upper_limits=[99.0] * 2)
    total = sum(counts_of(governor, rate) for _ in range(cycles)) * Unit.VELOCITY
    assert total == pytest.approx(rate * cycles, abs=Unit.VELOCITY)


def test_rounding_carries_nothing_over_a_stop():
    governor = governor_of(130, 130)
    assert [counts_of(governor, rate * Unit.VELOCITY) for rate in (0.4, 0.0, 0.4, 0.4)] == [0, 0, 0, 1]
    governor.halt()
    assert counts_of(governor, -0.4 * Unit.VELOCITY) == 0


def test_the_governor_knows_directions_and_the_servos_own_limit():
    governor = governor_of(130, 20, directions=(1, -1))
    assert governor.counts([9.0, 9.0], [0.0, 0.0], [0.0, 0.0]) == [129, -20]
    assert governor.counts([1.0, 1.0], [0.995, -2.5], [0.0, 0.0])[0] == 0
    assert governor.halt() == [0, 0]


# ---------------------------------------------------------------- freshness


def answers(clock, offset, rate=1.0, start=100.0, cycles=400, period=0.005, delay=0.0):
    """Lateness of regular answers that take 1.5 ms, measured 1 ms after the question, `delay` before it in truth."""
    late = []
    for cycle in range(cycles):
        sent = start + cycle * period
        tick = int(((sent + 1e-3 - delay) * rate + offset) * 1e3) % 32768
        late.append(clock.lateness(sent, sent + 1.5e-3, tick))
    return np.array(late)


@pytest.mark.parametrize("rate", [1.0, 1.005, 0.995])
@pytest.mark.parametrize("offset", [0.0, 12.345, 32.0])
def test_answers_in_time_are_never_late(rate, offset):
    assert not answers(ServoClock(), offset, rate, cycles=8000).any(), "the servo's clock starts again on the way"


@pytest.mark.parametrize("delay", [0.006, 0.02, 5.0, 16.0])
def test_answers_from_before_the_question_are_told(delay):
    clock = ServoClock()
    answers(clock, 7.0)
    late = answers(clock, 7.0, start=102.0, delay=delay, cycles=10)
    assert (late > 0.0).all()
    assert late[0] == pytest.approx(delay - 1e-3, abs=0.004)


def test_a_clock_that_stands_still_is_late_for_ever_if_it_ran():
    clock = ServoClock()
    assert not any(clock.lateness(80.0 + t, 80.001 + t, 0) for t in range(10)), "one that never ran proves nothing"
    clock.restart()
    answers(clock, 7.0)
    last = int((101.995 + 1e-3 + 7.0) * 1e3) % 32768
    assert min(clock.lateness(102.0 + t, 102.0 + t + 1e-3, last) for t in np.arange(0.1, 40.0, 0.1)) > 0.0
    clock.restart()
    assert not answers(clock, 1.0, start=150.0).any(), "a restart begins afresh"


@pytest.mark.parametrize("pause", [3.0, 20.0, 40.0, 100.0])
def test_a_pause_does_not_confuse_the_clock(pause):
    clock = ServoClock()
    answers(clock, 3.0)
    assert not answers(clock, 3.0, start=102.0 + pause).any()
    assert (answers(clock, 3.0, start=105.0 + pause, delay=0.5 + DRIFT * pause, cycles=5) > 0.0).all()


# ---------------------------------------------------------------- configuration


@pytest.mark.parametrize(
    ("fields", "error", "field"),
    [
        ({"ids": (1, 1)}, BackendError, "servos.ids"),
        ({"ids": (1, 253)}, BackendError, "servos.ids"),
        ({"ids": ()}, BackendError, "servos.ids"),
        ({"ids": (1, 2, 3)}, DimensionError, "servos.lower_limits"),
        ({"lower_limits": [0.0, math.nan]}, DimensionError, "servos.lower_limits"),
        ({"lower_limits": [2.0, 0.0]}, BackendError, "servos.upper_limits"),
        ({"rate_limits": [1.0, 0.0]}, BackendError, "servos.rate_limits"),
        ({"directions": (1, 2)}, BackendError, "servos.directions"),
        ({"directions": (1,)}, BackendError, "servos.directions"),
        ({"directions": (1.0, -1.0)}, BackendError, "servos.directions"),
        ({"directions": np.array([1.0, -1.0])}, BackendError, "servos.directions"),
        ({"directions": 1}, BackendError, "servos.directions"),
        ({"ids": (1.0, 2.0)}, BackendError, "servos.ids"),
        ({"zero_positions": (2048.5, 2048)}, BackendError, "servos.zero_positions"),
        ({"homing_offsets": ("0", "0")}, BackendError, "servos.homing_offsets"),
        ({"zero_positions": (0, 10**7)}, BackendError, "servos.zero_positions"),
        ({"homing_offsets": (0, 1_044_480)}, BackendError, "servos.homing_offsets"),
        ({"models": ()}, BackendError, "servos.models"),
        ({"models": (1000, 1060)}, BackendError, "servos.models"),
        ({"baud_rate": 12345}, BackendError, "servos.baud_rate"),
        ({"rate": 0.0}, BackendError, "servos.rate"),
        ({"rate": 5000.0}, BackendError, "servos.rate"),
        ({"latency": math.inf}, BackendError, "servos.latency"),
        ({"stale_after": 0.004}, BackendError, "servos.stale_after"),
        ({"stale_after": 0.5}, BackendError, "servos.stale_after"),
        ({"watchdog": 0.05}, BackendError, "servos.watchdog"),
        ({"watchdog": 2.56}, BackendError, "servos.watchdog"),
        ({"watchdog": math.nan}, BackendError, "servos.watchdog"),
        ({"watchdog": 0.02}, BackendError, "servos.watchdog"),
        ({"hot_temperature": 50.0}, BackendError, "servos.hot_temperature"),
        ({"limit_margin": 1.0}, BackendError, "servos.limit_margin"),
        ({"limit_margin": -0.1}, BackendError, "servos.limit_margin"),
    ],
)
def test_values_out_of_range_are_named(fields, error, field):
    with pytest.raises(error) as caught:
        config(**fields)
    assert caught.value.field == field or caught.value.field.startswith(f"{field}[")


def test_configuration_is_frozen():
    made = config()
    assert made.watchdog_counts == 5
    assert (made.signs, made.zeros, made.offsets) == ((1, 1), (2048, 2048), (0, 0))
    with pytest.raises(ValueError, match="read-only"):
        made.limits.lower[0] = 7.0


def test_integers_of_numpy_are_integers():
    names = ("ids", "directions", "zero_positions", "homing_offsets")
    made = config(**{name: np.array([1, -1] if name == "directions" else [3, 4]) for name in names})
    assert (made.ids, made.signs, made.zeros, made.offsets) == ((3, 4), (1, -1), (3, 4), (3, 4))
    assert all(type(value) is int for name in names for value in getattr(made, name))


def test_the_constructor_touches_no_device(tmp_path):
    bus = ServoBus(ServoConfig(str(tmp_path / "missing"), **LIMITS))
    for misuse in (bus.read, lambda: bus.command([0.0, 0.0]), bus.recover, lambda: bus.statistics):
        with pytest.raises(BackendError, match="not open"):
            misuse()
    with pytest.raises(BackendError, match="no such serial device"):
        bus.open()
    bus.stop()
    bus.stop()


def test_every_fault_has_one_consequence():
    for fault in ServoFault:
        assert sum(fault in group for group in (WARNINGS, STOPPING, LATCHED)) == 1, fault
