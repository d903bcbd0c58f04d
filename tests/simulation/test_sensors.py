"""What motion capture, servos and gyroscope say of a known motion: late, held, with gaps, and the same for the same seed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from quiet_noise import quiet_noise

from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.scenario import NoiseSection, Scenario, SensorsSection
from doorman.simulation import SimulatedBackend, Truth
from doorman.simulation.sensors import Sensors

TICK = 0.004
N = 4
QUIET = quiet_noise()
ARRAYS = ("position", "velocity", "attitude", "body_rates", "arm_angles", "arm_rates")


def truth(time: float) -> Truth:
    """A motion whose every number tells the time."""
    three, arm = np.array([1.0, 2.0, 3.0]), np.arange(1.0, N + 1)
    return Truth(
        time=time, position=time * three, velocity=three + time, attitude=0.1 * time * three, body_rates=0.1 * three + time,
        door_angle=1.0, door_rate=0.0, arm_angles=time * arm, arm_rates=arm + time, tip_force=np.zeros(3),
        tip_normal_force=0.0, touching=False, max_pull=0.0, collisions=0, collision_pairs=(), only_tip_on_frame=False,
        rotor_thrusts=np.zeros(6),
    )  # fmt: skip


def measured(ticks: int, noise: NoiseSection = QUIET, seed: int = 0, **delivery: object) -> list:
    sensors = Sensors(noise, seed, SensorsSection(**delivery))
    return [sensors.measure(truth(k * TICK)) for k in range(ticks)]


def test_by_default_every_tick_has_the_present_pose_and_the_noise_of_the_seed():
    noise = NoiseSection()
    generator = np.random.default_rng(5)
    for k, one in enumerate(measured(50, noise, seed=5)):
        true, draws = truth(k * TICK), generator.standard_normal(12 + 2 * N)
        parts = np.split(draws, [3, 6, 9, 12, 12 + N])
        for name, part in zip(ARRAYS, parts, strict=True):
            np.testing.assert_array_equal(getattr(one, name), getattr(true, name) + getattr(noise, name) * part)
        assert one.pose_time == one.time == k * TICK


def test_pose_and_arm_are_late_and_body_rates_are_not():
    for k, one in enumerate(measured(40, latency=0.02)):
        seen = truth(max(k - 5, 0) * TICK)
        for name in ("position", "velocity", "attitude", "arm_angles", "arm_rates"):
            np.testing.assert_array_equal(getattr(one, name), getattr(seen, name), err_msg=name)
        np.testing.assert_array_equal(one.body_rates, truth(k * TICK).body_rates)
        assert one.time == k * TICK
        assert one.pose_time == pytest.approx((k - 5) * TICK if k >= 5 else -0.02)


@pytest.mark.parametrize(("rate", "ages"), [(125.0, {0, 1}), (100.0, {0, 1, 2}), (250.0, {0}), (4000.0, {0})])
def test_a_slow_pose_is_held(rate, ages):
    run = measured(1000, rate=rate)
    assert {round((one.time - one.pose_time) / TICK) for one in run} == ages
    assert len({one.pose_time for one in run}) == pytest.approx(min(rate * 4.0, 1000), abs=1)
    for one in run:
        np.testing.assert_array_equal(one.position, truth(one.pose_time).position)
        np.testing.assert_array_equal(one.arm_angles, truth(one.time).arm_angles)


def test_in_a_gap_the_last_pose_repeats_to_the_bit():
    run = measured(25_000, NoiseSection(), seed=3, dropout_rate=2.0)
    ages = np.array([round((one.time - one.pose_time) / TICK) for one in run])
    assert 45 <= ages.max() <= 50  # 200 ms
    for before, after in zip(run, run[1:], strict=False):
        held = after.pose_time == before.pose_time
        assert (
            held == np.array_equal(after.position, before.position) == np.array_equal(after.attitude, before.attitude)
        )
        assert not np.array_equal(after.arm_angles, before.arm_angles)
    assert np.mean(ages > 0) == pytest.approx(0.1 / (0.5 + 0.1), rel=0.25)


def test_a_differenced_velocity_is_that_of_the_poses_seen():
    noise = NoiseSection(position=0.001)
    run = measured(4000, noise, seed=2, rate=125.0, dropout_rate=1.0, velocity="differenced")
    np.testing.assert_array_equal(run[0].velocity, truth(0.0).velocity)
    poses = list({one.pose_time: one for one in run}.values())
    for last, one in zip(poses, poses[1:], strict=False):
        np.testing.assert_allclose(
            one.velocity, (one.position - last.position) / (one.pose_time - last.pose_time), rtol=1e-9
        )
    errors = np.array([one.velocity - [1.0, 2.0, 3.0] for one in poses[1:]])
    assert errors.std() == pytest.approx(0.001 * np.sqrt(2) / 0.008, rel=0.1)
    assert np.abs(errors.mean()) < 0.01


def test_the_backend_delivers_as_the_scenario_says(model, monkeypatch):
    for name in ("velocity", "body_rates", "arm_angles", "arm_rates"):
        monkeypatch.setattr(NoiseSection, name, 0.0)
    quiet = {f"simulation__noise__{name}": 0.0 for name in NoiseSection.model_fields}
    late = model(simulation__sensors__latency=0.02, **quiet)
    with SimulatedBackend(late) as backend:
        truths, run = [], []
        for _ in range(20):
            run.append(backend.read())
            truths.append(backend.truth)
    for k in range(5, 20):
        np.testing.assert_array_equal(run[k].position, truths[k - 5].position)
        np.testing.assert_array_equal(run[k].body_rates, truths[k].body_rates)
        assert run[k].pose_time == truths[k - 5].time


def test_jitter_delays_every_pose_by_another_time_and_lets_none_overtake():
    run = measured(3000, latency=0.02, jitter=0.03)
    ages = np.array([one.time - one.pose_time for one in run[20:]])
    assert 0.02 - 1e-9 <= ages.min() and ages.max() < 0.05 + 2 * TICK and len(set(ages.round(4))) > 4
    assert (np.diff([one.pose_time for one in run]) >= 0.0).all()
    arms = np.array([one.arm_angles[0] for one in run[20:]])
    np.testing.assert_allclose(arms, [one.time - 0.02 for one in run[20:]])


def pressed(seed: int, **delivery: object) -> list:
    sensors = Sensors(NoiseSection(), seed, SensorsSection(**delivery))
    return [sensors.measure(replace(truth(k * TICK), tip_normal_force=0.01 * k)) for k in range(4000)]


def test_the_tip_is_felt_with_noise_of_the_seed_where_it_has_a_sensor():
    true = 0.01 * np.arange(4000)
    first, again, other = (np.array([one.tip_force for one in pressed(seed, tip_force=True)]) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.1
    errors = first - true
    assert errors.mean() == pytest.approx(0.0, abs=0.005) and errors.std() == pytest.approx(0.05, rel=0.1)


def test_a_sensor_of_the_tip_leaves_all_other_readings_as_they_were():
    without, sensed = pressed(1, latency=0.02), pressed(1, latency=0.02, tip_force=True)
    assert all(one.tip_force is None for one in without)
    for one, two in zip(without, sensed, strict=True):
        assert all(np.array_equal(getattr(one, name), getattr(two, name)) for name in ARRAYS)


def test_servos_with_play_say_where_their_stops_are():
    sensors = Sensors(QUIET, 0, backlash=0.1)
    said = []
    for tick, angle in enumerate((0.0, 0.04, 0.2, 0.16, 0.08, 0.0)):
        one = replace(truth(tick * TICK), arm_angles=np.full(N, angle))
        said.append(float(sensors.measure(one).arm_angles[0]))
    np.testing.assert_allclose(said, [0.0, 0.0, 0.15, 0.15, 0.13, 0.05], atol=1e-12)


def test_a_gripper_has_no_force_sensor_and_a_tip_that_pushes_may():
    keys = {"simulation.sensors.tip_force": True}
    assert Model(Scenario.load("push", keys)).scenario.simulation.sensors.tip_force
    with pytest.raises(ScenarioError, match=r"simulation\.sensors\.tip_force.*push"):
        Model(Scenario.load("paper", keys))
