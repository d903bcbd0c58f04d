"""The simulator behind the interface of the hardware."""

from __future__ import annotations

import math
import os
import sys

import numpy as np
import pytest

from doorman.exceptions import BackendError
from doorman.hardware.interface import Command
from doorman.simulation import Disturbance, SimulatedBackend
from doorman.simulation import backend as backend_module

ARRAYS = ("position", "velocity", "attitude", "body_rates", "arm_angles", "arm_rates")


def hover(arm_rates=(0.0, 0.0, 0.0, 0.0), thrust=29.43, attitude=(0.0, 0.0, 0.0)) -> Command:
    return Command(thrust, np.array(attitude), np.array(arm_rates))


def fly(backend: SimulatedBackend, ticks: int = 200) -> list:
    measurements = []
    with backend:
        for tick in range(ticks):
            measurements.append(backend.read())
            backend.command(hover((0.1, 0.0, -0.1, 0.05), 31.0, (0.02, 0.1 * math.sin(0.05 * tick), 0.1)))
    return measurements


def test_first_read_is_the_start_and_each_one_a_period_later(model):
    with SimulatedBackend(model()) as backend:
        assert backend.truth.time == 0.0
        times = [backend.read().time for _ in range(5)]
    assert times == pytest.approx([0.0, 0.004, 0.008, 0.012, 0.016], abs=1e-12)


@pytest.mark.parametrize(
    ("physics", "controller", "steps"), [(1000.0, 250.0, 4), (1000.0, 300.0, 3), (500.0, 800.0, 1)]
)
def test_physics_divides_the_controllers_period(model, physics, controller, steps):
    overrides = {"simulation__physics_rate": physics, "simulation__controller_rate": controller}
    backend = SimulatedBackend(model(**overrides))
    assert backend.steps_per_period == steps
    with backend:
        times = [backend.read().time for _ in range(4)]
    assert times == pytest.approx(np.arange(4) / controller)


@pytest.mark.parametrize("kind", ["grip", "push"])
def test_same_seed_same_flight_to_the_bit(model, kind):
    first, second, other = (fly(SimulatedBackend(model(contact__kind=kind), seed=seed)) for seed in (7, 7, 8))
    for one, two in zip(first, second, strict=True):
        assert one.time == two.time
        assert all(np.array_equal(getattr(one, name), getattr(two, name)) for name in ARRAYS)
    assert not np.array_equal(first[0].position, other[0].position)


def test_reopening_starts_afresh(model):
    backend = SimulatedBackend(model(), seed=3)
    first, second = fly(backend, 20), fly(backend, 20)
    assert all(np.array_equal(one.position, two.position) for one, two in zip(first, second, strict=True))


def test_before_the_first_command_it_hovers(model):
    with SimulatedBackend(model(contact__kind="push")) as backend:
        for _ in range(250):
            backend.read()
        assert np.abs(backend.truth.velocity).max() < 5e-3
        assert backend.truth.collisions == 0


def test_results_are_frozen(model):
    with SimulatedBackend(model()) as backend:
        measurement = backend.read()
        for result in (measurement, backend.truth):
            with pytest.raises(AttributeError):
                result.time = 1.0
            with pytest.raises(ValueError, match="read-only"):
                result.position[0] = 1.0


def test_use_out_of_order(model):
    backend = SimulatedBackend(model())
    for use in (backend.read, lambda: backend.command(hover()), lambda: backend.truth):
        with pytest.raises(BackendError, match="open"):
            use()
    backend.stop()
    backend.open()
    with pytest.raises(BackendError, match="open already"):
        backend.open()
    backend.read()
    backend.stop()
    backend.stop()
    assert backend.truth.time == 0.0
    with pytest.raises(BackendError, match="not open"):
        backend.read()


@pytest.mark.parametrize(
    ("command", "field"),
    [
        (hover(thrust=math.nan), "thrust"),
        (hover(thrust=math.inf), "thrust"),
        (hover(attitude=(0.0, math.nan, 0.0)), "attitude"),
        (hover(attitude=(0.0, 0.0)), "attitude"),
        (hover((0.0, math.inf, 0.0, 0.0)), "arm_rates"),
        (hover((0.0, 0.0, 0.0)), "arm_rates"),
        (Command(None, np.zeros(3), np.zeros(4)), "command"),  # type: ignore[arg-type]
    ],
)
def test_bad_commands_are_refused_and_the_last_good_one_holds(model, command, field):
    with SimulatedBackend(model(contact__kind="push")) as backend:
        backend.command(hover(attitude=(0.1, 0.0, 0.0)))
        with pytest.raises(BackendError, match=field):
            backend.command(command)
        for _ in range(150):
            backend.read()
        assert backend.truth.attitude[0] == pytest.approx(0.1, abs=0.03)


def test_realtime_waits_for_the_wall_clock_and_never_runs_ahead(model, monkeypatch):
    clock = {"now": 100.0}
    slept = []

    def sleep(duration: float) -> None:
        slept.append(duration)
        clock["now"] += duration

    monkeypatch.setattr(backend_module.time, "monotonic", lambda: clock["now"])
    monkeypatch.setattr(backend_module.time, "sleep", sleep)
    with SimulatedBackend(model(), realtime=True) as backend:
        for tick in range(25):
            truth = backend.read().time
            assert truth <= clock["now"] - 100.0 + 1e-9
            if tick == 10:
                clock["now"] += 0.01  # the caller was slow
    assert sum(slept) == pytest.approx(24 * 0.004 - 0.01, abs=1e-9)


def test_unstable_physics_is_an_error_and_leaves_no_log_file(model, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blow = Disturbance(force=(1e20, 0.0, 0.0))
    with SimulatedBackend(model(), disturbance=lambda time: blow) as backend:
        backend.read()
        with pytest.raises(BackendError, match="BADQ"):
            for _ in range(5):
                backend.read()
    assert os.listdir(tmp_path) == []


def test_turning_over_is_an_error(model):
    flip = Disturbance(torque=(0.0, 20.0, 0.0))
    with SimulatedBackend(model(contact__kind="push"), disturbance=lambda time: flip) as backend:
        backend._simulator.plant.data.qpos[0] -= 5.0
        with pytest.raises(BackendError, match=r"turned over|unstable"):
            backend._simulator.plant.data.qpos[3:7] = [math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0]
            backend.read()


def test_missing_mujoco_says_what_to_install(model, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    backend = SimulatedBackend(model())
    with pytest.raises(BackendError, match=r"pip install -e '\.\[sim\]'"):
        backend.open()
