"""Observers and filters on motions whose truth is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from paper_door import door_normal

from doorman.control.estimation.beliefs import Beliefs, ContactThresholds
from doorman.control.estimation.contact_monitor import ContactMonitor
from doorman.control.estimation.door_filter import ANGLE, FRICTION, STIFFNESS, DoorFilter
from doorman.control.estimation.estimator import Estimator, Tie
from doorman.control.observers.disturbance_observer import DisturbanceObserver
from doorman.control.observers.vehicle_observer import VehicleObserver
from doorman.control.state_converter import StateConverter
from doorman.gravity import GRAVITY
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.signals import Measurement

TICK = 0.004


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Scenario.load("push"))


def observe(latency: float, gap: tuple[float, float] = (9.0, 9.0)) -> tuple[VehicleObserver, np.ndarray, np.ndarray]:
    """A point mass pushed about, seen late and not at all in the gap; observer, true position and velocity at the end."""
    mass, wind = 3.0, np.array([0.8, -0.4, 0.2])
    observer = VehicleObserver(mass, 15.0)
    position, velocity, force = np.zeros(3), np.array([0.1, 0.0, 0.0]), np.zeros(3)
    past: list[np.ndarray] = []
    seen_at = 0.0
    for tick in range(1500):
        now = tick * TICK
        past.append(position.copy())
        late = max(tick - round(latency / TICK), 0)
        if not gap[0] <= now < gap[1]:
            seen_at, seen = late * TICK, past[late]
        observer.update(seen, seen_at, now, force, TICK if tick else 0.0)
        force = 1.5 * np.array([math.sin(now), math.cos(2.0 * now), 0.0])
        velocity = velocity + TICK * (force + wind) / mass
        position = position + TICK * velocity
    return observer, past[-1], velocity


def test_the_vehicle_observer_finds_velocity_and_wind() -> None:
    observer, position, velocity = observe(0.0)
    np.testing.assert_allclose(observer.position, position, atol=2e-3)
    np.testing.assert_allclose(observer.velocity, velocity, atol=5e-3)
    np.testing.assert_allclose(observer.outer_force, [0.8, -0.4, 0.2], atol=0.02)


@pytest.mark.parametrize("latency", [0, 5])
@pytest.mark.parametrize("blow", [0.0, 0.5])
@pytest.mark.parametrize("gap", [0.048, 0.104, 0.2])
def test_what_happens_in_a_gap_is_caught_up_with_and_not_overshot(gap: float, blow: float, latency: int) -> None:
    """A blow while the cameras see nothing: from the first pose after it on, the estimate is near and comes nearer."""
    observer, velocity, tick = VehicleObserver(3.0, 15.0), np.array([0.3, 0.0, 0.0]), 0.004
    before, path, seen = 0.8, [np.zeros(3)], 0
    for k in range(round((before + gap + 0.5) / tick)):
        now = k * tick
        if now >= before + blow * gap - 1e-9:
            velocity = np.array([-0.3, 0.0, 0.0])
        path.append(path[-1] + tick * velocity)
        blind = before < now < before + gap - 1e-9
        seen = seen if blind or k % 2 else max(k - latency, 0)
        observer.update(path[seen], seen * tick, now, np.zeros(3), tick if k else 0.0)
        if k == 0:
            observer.velocity[:] = velocity
        if now >= before + gap + 0.5 * tick:
            assert abs(observer.position[0] - path[k][0]) < 0.3 * gap + 0.3 * latency * tick + 0.002, now
            assert -1.0 < observer.velocity[0] < 0.31, now
    assert observer.velocity[0] == pytest.approx(-0.3, abs=0.05)


@pytest.mark.parametrize("apart", [0.004, 0.008, 0.1, 0.2])
def test_an_error_fades_as_designed_however_far_apart_positions_are(apart: float) -> None:
    """Three poles at exp(-15 T): what is left of an error after k positions, at most k² of its k-th power."""
    observer = VehicleObserver(3.0, 15.0)
    observer.update(np.zeros(3), 0.0, 0.0, np.zeros(3), 0.0)
    observer.velocity[:], errors, poses = [1.0, 0.0, 0.0], [], 40
    for k in range(1, poses + 1):
        observer.update(np.zeros(3), k * apart, k * apart, np.zeros(3), apart)
        errors.append(abs(observer.velocity[0]))
    kept = math.exp(-15.0 * apart)
    for k in (10, 20, 40):
        assert errors[k - 1] < 4.0 * k**2 * kept ** (k - 3) + 1e-12


def test_late_positions_do_not_shift_the_estimate() -> None:
    observer, position, _ = observe(0.02)
    np.testing.assert_allclose(observer.position, position, atol=5e-3)
    np.testing.assert_allclose(observer.outer_force, [0.8, -0.4, 0.2], atol=0.05)


@pytest.mark.parametrize("apart", [0.005, 0.01, 0.05])
@pytest.mark.parametrize("age", [0.04, 0.06, 0.1, 0.2, 0.4])
def test_an_error_fades_however_late_positions_are(age: float, apart: float) -> None:
    """Of a vehicle that stands: what is wrong about it is forgotten, with old positions as with new ones, only later."""
    observer = VehicleObserver(3.0, 15.0)
    observer.update(np.zeros(3), 0.0, age, np.zeros(3), 0.0)
    observer.velocity[:], observer.outer_force[:] = [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]
    worst, patience = 0.0, 1.0 + 40.0 * age
    for k in range(1, round(patience / apart)):
        observer.update(np.zeros(3), k * apart, k * apart + age, np.zeros(3), apart)
        worst = max(worst, abs(observer.position[0]))
    assert worst < 10.0 * age
    assert abs(observer.velocity[0]) < 0.02
    assert abs(observer.position[0]) < 0.02 * age + 0.002


@pytest.mark.parametrize(("delay", "on", "off"), [(0.15, 0.15, 0.15), (0.1, 0.32, 0.08), (0.18, 0.2, 0.2)])
def test_delays_that_come_and_go_do_not_excite_the_observer(delay: float, on: float, off: float) -> None:
    observer, tick, seen = VehicleObserver(3.0, 15.0), 0.01, -1.0
    observer.update(np.zeros(3), seen, 0.0, np.zeros(3), 0.0)
    observer.velocity[:], errors = [0.1, 0.0, 0.0], []
    for k in range(1, round(6.0 / tick)):
        now = k * tick
        seen = max(seen, now - (delay if now % (on + off) < on else 0.005))
        observer.update(np.zeros(3), seen, now, np.zeros(3), tick)
        errors.append(abs(observer.velocity[0]))
    assert max(errors) < 0.5
    assert max(errors[-50:]) < 0.02


def test_a_gap_is_bridged_by_the_model() -> None:
    observer, position, velocity = observe(0.0, (5.75, 6.0))
    np.testing.assert_allclose(observer.position, position, atol=5e-3)
    np.testing.assert_allclose(observer.velocity, velocity, atol=1e-2)


def test_one_look_after_a_long_pause_is_not_lasting_evidence() -> None:
    monitor = ContactMonitor(ContactThresholds())
    monitor.declare(True)
    assert monitor.update(0.0, 0.2), "it has not been watched meanwhile"


def test_a_standing_leaf_is_followed_through_a_long_pause(model: Model) -> None:
    tracked = DoorFilter(model, Beliefs.of(model))
    start = tracked.angle
    for k in range(50):
        tracked.update(1.0, True, start, k * TICK, k * TICK, TICK)
    tracked.update(1.0, True, start - 0.006, 0.4, 0.4, 0.2)
    assert -0.002 < start - 0.006 - tracked.angle < 0.006 - 0.003, "nearer, and not past it"
    assert abs(tracked.rate) < 0.03


def test_contact_state_has_hysteresis_in_force_and_time() -> None:
    settings = ContactThresholds()
    monitor = ContactMonitor(settings)
    between = 0.5 * (settings.touched_above + settings.lost_below)
    assert not any(monitor.update(between, TICK) for _ in range(100))
    assert not monitor.update(1.0, TICK)  # one spike is no contact
    touched = [monitor.update(1.0, TICK) for _ in range(50)]
    assert touched[-1] and touched.index(True) * TICK <= 0.1
    assert all(monitor.update(between, TICK) for _ in range(100))
    lost = [monitor.update(0.0, TICK) for _ in range(50)]
    assert not lost[-1] and lost.index(False) * TICK <= 0.1


def test_a_force_that_noise_cannot_explain_counts_at_once(rng: np.random.Generator) -> None:
    settings = ContactThresholds()
    calm, noisy = ContactMonitor(settings), ContactMonitor(settings)
    for _ in range(2000):
        calm.listen(0.02 * rng.standard_normal(), TICK)
        noisy.listen(0.2 * rng.standard_normal(), TICK)
    above = 1.1 * settings.certain_above
    assert not calm.update(0.9 * settings.certain_above, TICK)
    assert calm.update(above, TICK)
    assert not noisy.update(above, TICK)
    assert [noisy.update(1.1 * settings.touched_above, TICK) for _ in range(20)].index(True) * TICK == pytest.approx(
        settings.touched_after, abs=2 * TICK
    )


def test_little_force_will_do_where_a_touch_is_expected_and_only_there() -> None:
    settings = ContactThresholds()
    force, here, beyond = 1.1 * settings.arrived_above, 0.5 * settings.arrived_within, 2.0 * settings.arrived_within

    def calm() -> ContactMonitor:
        monitor = ContactMonitor(settings)
        for _ in range(2000):
            monitor.listen(0.0, TICK)
        return monitor

    monitor = calm()
    assert not monitor.update(force, TICK, here), "none is expected"
    monitor.expect()
    assert not any(monitor.update(force, TICK, beyond) for _ in range(100)), "not there yet"
    assert not monitor.update(0.9 * settings.arrived_above, TICK, here)
    assert monitor.update(force, TICK, here)
    monitor.declare(False)
    assert not any(monitor.update(force, TICK, here) for _ in range(100)), "it is expected once"

    noisy = calm()
    for sign in [1.0, -1.0] * 1000:
        noisy.listen(sign * force, TICK)
    noisy.expect()
    assert not noisy.update(force, TICK, here), "noise explains it"
    assert noisy.update(1.05 * settings.arrived_deviations * force, TICK, here)


class Swing:
    """A true door, pushed at the tip, integrated finely; its tip is measured with noise."""

    def __init__(self, model: Model, wind: tuple[float, float] = (0.0, 0.0), **hinge: float) -> None:
        self.wind, self.half_width = wind, 0.5 * model.door.width
        self.lever = model.coupling.distance_from_hinge
        self.vehicle = model.vehicle.mass * self.lever**2
        self.angle, self.rate, self.rest = math.pi / 2, 0.0, math.pi / 2
        self.hinge = hinge

    @property
    def wind_torque(self) -> float:
        return self.half_width * (self.wind[1] * math.cos(self.angle) - self.wind[0] * math.sin(self.angle))

    def step(self, push: float, touching: bool) -> None:
        hinge = self.hinge
        inertia = hinge["inertia"] + (self.vehicle if touching else 0.0)
        for _ in range(10):
            drive = -self.lever * push * touching - hinge["stiffness"] * (self.angle - self.rest)
            drive -= hinge["damping"] * self.rate
            drive += self.wind_torque
            if self.rate == 0.0 and abs(drive) <= hinge["friction"]:
                continue
            sign = math.copysign(1.0, self.rate if self.rate != 0.0 else drive)
            rate = self.rate + 0.1 * TICK * (drive - hinge["friction"] * sign) / inertia
            self.rate = 0.0 if self.rate * rate < 0.0 else rate
            self.angle += 0.1 * TICK * self.rate


def filtered(
    model: Model, swing: Swing, seed: int, lost_after: float = math.inf, felt: tuple[float, float] = (0.0, 0.0)
) -> DoorFilter:
    """Filter after a push that changes, 8 s long; the tip leaves the leaf for good after a while.

    The vehicle feels a wind before the touch.
    """
    door, generator = DoorFilter(model, Beliefs()), np.random.default_rng(seed)
    strength = (swing.hinge["friction"] + swing.hinge["damping"] * 0.1) / swing.lever
    for tick in range(round(min(8.0, lost_after + 2.0) / TICK)):
        now = tick * TICK
        touching = now < lost_after
        push = strength + (0.7 if now % 4.0 < 2.0 else -0.4 * strength)
        push += (swing.hinge["stiffness"] * (swing.rest - swing.angle) + swing.wind_torque) / swing.lever
        swing.step(push, touching)
        noise = generator.standard_normal(2) * (0.1, 0.003)
        door.update(push + noise[0], touching, swing.angle + noise[1], now, now, TICK, wind=np.array([*felt, 0.0]))
    return door


HINGES = [
    {"inertia": 5.28, "damping": 0.5, "friction": 0.5, "stiffness": 0.0},
    {"inertia": 9.6, "damping": 0.1, "friction": 1.2, "stiffness": 0.0},
    {"inertia": 2.9, "damping": 1.8, "friction": 0.4, "stiffness": 1.0},
    {"inertia": 6.0, "damping": 1.0, "friction": 2.0, "stiffness": 1.5},
]


@pytest.mark.parametrize("hinge", HINGES)
def test_the_door_filter_follows_the_door_and_is_honest_about_its_hinge(model: Model, hinge: dict[str, float]) -> None:
    inside = {name: 0 for name in hinge}
    for seed in range(4):
        swing = Swing(model, **hinge)
        door = filtered(model, swing, seed)
        assert swing.angle < math.pi / 2 - 0.1, "the door has moved"
        assert door.angle == pytest.approx(swing.angle, abs=math.radians(0.3))
        assert door.rate == pytest.approx(swing.rate, abs=0.02)
        estimate = door.hinge()
        for name in hinge:
            off = abs(getattr(estimate, name) - hinge[name])
            inside[name] += off <= 2.0 * getattr(estimate, f"{name}_deviation")
    assert sum(inside.values()) >= 14, inside


def test_the_hinge_is_known_better_after_than_before(model: Model) -> None:
    before = DoorFilter(model, Beliefs()).hinge()
    after = filtered(model, Swing(model, **HINGES[0]), 1).hinge()
    assert after.friction_deviation < 0.6 * before.friction_deviation
    assert after.inertia_deviation < 0.9 * before.inertia_deviation
    assert after.friction == pytest.approx(0.5, abs=0.3)


def test_what_friction_leaves_of_the_closer_has_its_own_deviation(model: Model) -> None:
    door = DoorFilter(model, Beliefs())
    door.state[ANGLE], door.state[FRICTION], door.state[STIFFNESS] = model.start_angle - 1.2, 0.8, 0.5
    pair = np.ix_([FRICTION, STIFFNESS], [FRICTION, STIFFNESS])
    door.covariance[pair] = [[0.16, -0.05], [-0.05, 0.09]]
    hinge = door.hinge()
    assert hinge.spare == pytest.approx(0.8 - 1.2 * 0.5)
    assert hinge.spare_deviation == pytest.approx(
        math.sqrt(np.array([1.0, -1.2]) @ door.covariance[pair] @ [1.0, -1.2])
    )
    assert hinge.torque_deviation == pytest.approx(math.sqrt(np.array([1.0, 1.2]) @ door.covariance[pair] @ [1.0, 1.2]))


def test_a_door_that_stood_by_itself_is_not_predicted_to_shut(model: Model) -> None:
    door = DoorFilter(model, Beliefs())
    door.state[ANGLE], door.state[FRICTION], door.state[STIFFNESS] = model.start_angle - 1.2, 0.2, 0.5
    door.stays()
    for k in range(1000):
        door.update(0.0, False, 0.3, 0.004 * k, 0.004 * k, 0.004)
    assert door.angle == pytest.approx(model.start_angle - 1.2)
    before = DoorFilter(model, Beliefs())
    before.stays()
    assert before.hinge() == DoorFilter(model, Beliefs()).hinge(), "a strong friction is not changed"


@pytest.mark.parametrize("inertia", [2.9, 5.3, 9.6])
def test_a_door_that_comes_loose_with_a_jerk_is_not_taken_for_a_light_one(model: Model, inertia: float) -> None:
    """Swung and braked by a grip, seen 24 ms late: the rate lags behind where the filter begins to follow it."""
    swing = Swing(model, inertia=inertia, damping=0.3, friction=0.3, stiffness=0.0)
    door, angles = DoorFilter(model, Beliefs()), [swing.angle] * 6
    for tick in range(round(2.4 / TICK)):
        now = tick * TICK
        push = 6.0 if now < 1.2 else -3.5
        swing.step(push, True)
        angles.append(swing.angle)
        door.update(push, True, angles[-7], now - 6 * TICK, now, TICK)
    assert door.inertia == pytest.approx(inertia, rel=0.15)
    assert door.rate == pytest.approx(swing.rate, abs=0.02)


@pytest.mark.parametrize("hinge", HINGES[:3])
def test_a_seal_says_nothing_of_the_hinge(model: Model, hinge: dict[str, float]) -> None:
    """It resists with 5 N m over 2°, and a push that overcomes it swings the leaf beyond."""
    swing = Swing(model, **hinge)
    door, generator = DoorFilter(model, Beliefs()), np.random.default_rng(3)
    for tick in range(round(9.0 / TICK)):
        now, sealed = tick * TICK, math.pi / 2 - swing.angle < math.radians(2.0)
        swing.hinge = hinge | {"friction": 5.0 + hinge["friction"]} if sealed else hinge
        steady = (hinge["friction"] + 0.1 * hinge["damping"]) / swing.lever
        push = 3.0 * now if sealed else steady + (0.4 if now % 3.0 < 1.5 else -0.3 * steady)
        push += 0.0 if sealed else hinge["stiffness"] * (swing.rest - swing.angle) / swing.lever
        swing.step(push, True)
        noise = generator.standard_normal(2) * (0.1, 0.003)
        door.update(push + noise[0], True, swing.angle + noise[1], now, now, TICK)
    estimate = door.hinge()
    assert math.pi / 2 - swing.angle > 0.2
    for name, true in hinge.items():
        assert abs(getattr(estimate, name) - true) <= 2.0 * getattr(estimate, f"{name}_deviation"), name
    assert estimate.friction < hinge["friction"] + 0.6


@pytest.mark.parametrize("inertia", [3.0, 9.0])
def test_a_vehicle_that_turns_about_the_tip_it_holds_learns_the_leafs_inertia_none_the_less(
    model: Model, inertia: float
) -> None:
    """Door and heading swing together; the forces are those that Newton asks for."""
    converter = StateConverter(model)
    estimator, lever, mass = Estimator(model, converter), model.coupling.distance_from_hinge, model.vehicle.mass
    arm, step, still = model.start_arm, 1e-3, np.zeros(model.n_arm)

    def angle(t: float) -> float:
        s = min(max(t / 2.5, 0.0), 1.0)
        return math.pi / 2 - 1.2 * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)

    def heading(t: float) -> float:
        return -0.9 * (angle(0.0) - angle(t - 0.4)) / 1.2

    def place(t: float) -> np.ndarray:
        return model.coupling.vehicle_position([0.0, 0.0, heading(t)], angle(t), arm)

    for tick in range(round(3.2 / TICK)):
        t = tick * TICK
        velocity = (place(t + step) - place(t - step)) / (2.0 * step)
        acceleration = (place(t + step) - 2.0 * place(t) + place(t - step)) / step**2
        rate, swing = (
            (angle(t + step) - angle(t - step)) / (2.0 * step),
            ((angle(t + step) - 2.0 * angle(t) + angle(t - step)) / step**2),
        )
        resistance = 0.3 * rate + 0.3 * math.tanh(rate / 0.01)
        tip = -(inertia * swing + resistance) / lever * door_normal(angle(t))
        force = mass * (acceleration + np.array([0.0, 0.0, GRAVITY])) + tip
        turning = np.array([0.0, 0.0, (heading(t + step) - heading(t - step)) / (2.0 * step)])
        attitude = np.array([0.0, 0.0, heading(t)])
        measurement = Measurement(t, place(t), velocity, attitude, turning, arm, still, t)
        estimate = estimator.update(measurement, force, Tie.GRIPPED, TICK if tick else 0.0)
    assert estimate.hinge.inertia == pytest.approx(inertia, rel=0.2)


def test_a_vehicle_that_pitches_about_the_tip_it_holds_does_not_swing_the_leaf(model: Model) -> None:
    """At 2 Hz, the leaf stands: neither its rate nor its hinge's torque follows the body's turning."""
    estimator, arm, still = Estimator(model, StateConverter(model)), model.start_arm, np.zeros(model.n_arm)
    angle, step, rates, torques = 1.2, 1e-3, [], []

    def pitch(t: float) -> float:
        return 0.04 * math.sin(4.0 * math.pi * t)

    def place(t: float) -> np.ndarray:
        return model.coupling.vehicle_position([0.0, pitch(t), 0.0], angle, arm)

    for tick in range(round(4.0 / TICK)):
        t = tick * TICK
        velocity = (place(t + step) - place(t - step)) / (2.0 * step)
        thrust = model.vehicle.mass * GRAVITY * np.array([math.sin(pitch(t)), 0.0, math.cos(pitch(t))])
        turning = np.array([0.0, (pitch(t + step) - pitch(t - step)) / (2.0 * step), 0.0])
        measurement = Measurement(t, place(t), velocity, np.array([0.0, pitch(t), 0.0]), turning, arm, still, t)
        estimate = estimator.update(measurement, thrust, Tie.GRIPPED, TICK if tick else 0.0)
        if t > 1.0:
            rates.append(abs(estimate.door_rate))
            torques.append(estimate.door_disturbance)
    assert max(rates) < 0.005
    assert np.ptp(torques) < 1.2


def test_wind_on_the_leaf_does_not_pass_for_friction_where_the_vehicle_feels_it(model: Model) -> None:
    def off(sign: float, felt: float) -> tuple[float, float]:
        swing = Swing(model, (0.8 * sign, -0.6 * sign), inertia=6.0, damping=0.5, friction=1.2, stiffness=0.0)
        found = filtered(model, swing, 3, felt=(felt * swing.wind[0], felt * swing.wind[1])).hinge()
        return abs(found.friction + found.stiffness * (swing.rest - swing.angle) - 1.2), found.torque_deviation

    for sign in (-1.0, 1.0):
        error, deviation = off(sign, felt=0.7)
        assert error < deviation
        assert error < 0.5 * off(sign, felt=0.0)[0]


def test_a_strong_wind_on_the_vehicle_is_expected_on_the_leaf_too(model: Model) -> None:
    def expected(felt: float, share: float) -> float:
        door = DoorFilter(model, Beliefs(leaf_wind=(1.0, 0.5), leaf_wind_share=share))
        door.update(0.3, True, math.pi / 2, 0.0, 0.0, TICK, wind=np.array([0.0, felt, 0.0]))
        return float(np.linalg.norm(door.state[7:]))

    assert [expected(felt, 0.0) for felt in (0.0, 0.5, 2.0)] == pytest.approx([0.0, 1.0, 1.0])
    assert [expected(felt, 0.7) for felt in (0.0, 0.5, 2.0)] == pytest.approx([0.0, 0.65, 1.7])
    assert [expected(felt, 1.0) for felt in (0.0, 0.5, 2.0)] == pytest.approx([0.0, 0.5, 2.0])


def test_wind_makes_the_filter_less_sure(model: Model) -> None:
    hinges = [filtered(model, Swing(model, **HINGES[0]), 1, felt=felt).hinge() for felt in ((0.0, 0.0), (1.5, 0.0))]
    assert hinges[1].friction_deviation > 1.1 * hinges[0].friction_deviation
    assert hinges[1].torque_deviation > 1.1 * hinges[0].torque_deviation


def test_a_door_that_was_lost_is_followed_by_the_model(model: Model) -> None:
    swing = Swing(model, **HINGES[0])
    door = filtered(model, swing, 2, lost_after=4.0)
    assert door.angle == pytest.approx(swing.angle, abs=math.radians(2.0))
    assert door.rate == 0.0 and swing.rate == 0.0


def test_a_standing_door_teaches_nothing(model: Model) -> None:
    door = DoorFilter(model, Beliefs())
    for tick in range(500):
        door.update(0.3, True, math.pi / 2, tick * TICK, tick * TICK, TICK)
    assert door.hinge() == DoorFilter(model, Beliefs()).hinge()
    assert door.angle == pytest.approx(math.pi / 2)


def test_the_disturbance_observer_is_aligned_without_a_bump() -> None:
    observer, velocity = DisturbanceObserver(3.0, 3.0), np.array([0.05, 0.02, 0.0])
    position, force = np.zeros(3), np.zeros(3)
    for _ in range(800):
        observer.update(position, force, TICK)
        position = position + TICK * velocity  # the force is balanced by a disturbance of its opposite
        force = np.array([1.0, 0.0, 0.5])
    normal, wind = np.array([1.0, 0.0, 0.0]), np.array([0.3, 9.0, 9.0])
    observer.align(normal, wind, velocity)
    np.testing.assert_allclose(observer.estimate, [0.3, 0.0, -0.5], atol=0.01)
    after = observer.update(position + TICK * velocity, np.array([-0.3, 0.0, 0.5]), TICK)
    np.testing.assert_allclose(after, [0.3, 0.0, -0.5], atol=0.02)
