"""What is known in flight, on motions whose truth is known: wind, contact, forces, leaf and hinge."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.exceptions import DoormanError
from doorman.gravity import GRAVITY
from doorman.model import Model
from doorman.signals import LeafReading, Measurement

Array = np.ndarray
TICK, CLOSED = 0.004, math.pi / 2
NOISE = 3e-4
"""Of the poses [m]."""


@pytest.fixture(scope="module", params=["push", "push_left"])
def model(request: pytest.FixtureRequest) -> Model:
    return Model(request.param)


class Vehicle:
    """A level vehicle that moves as it is told, and what its estimator makes of that."""

    def __init__(self, model: Model, latency: float = 0.0) -> None:
        self.model, self.estimator = model, Estimator(model)
        self.time, self.yaw, self.latency = 0.0, model.start_yaw, latency
        self.poses: list[tuple[float, Array]] = []
        self.leaf: float | None = None  # where a sensor sees it, as its joint counts, 20 ms late
        self.rng = np.random.default_rng(7)

    def at(self, distance: float, angle: float = CLOSED) -> Array:
        """Position with the tip this far before the leaf."""
        model = self.model
        place = model.coupling.vehicle_position([0.0, 0.0, self.yaw], angle, model.start_arm)
        return np.asarray(place - distance * model.door.normal(angle))

    def measurement(self, place: Array, reads: float | None = None) -> Measurement:
        """Of now, with a pose that is late."""
        self.poses.append((self.time, place + NOISE * self.rng.normal(size=3)))
        posed, seen = next(pose for pose in reversed(self.poses) if pose[0] <= self.time - self.latency + 1e-9)
        leaf = None if self.leaf is None else LeafReading(self.leaf, self.time - 0.02, 0.002)
        return Measurement(
            self.time, seen, np.zeros(3), np.array([0.0, 0.0, self.yaw]), np.zeros(3), self.model.start_arm,
            np.zeros(self.model.n_arm), posed, tip_force=reads, leaf=leaf,
        )  # fmt: skip

    def fly(
        self, seconds: float, place: Array, outer: Array, tie: Tie = Tie.PUSHING, to: Array | None = None,
        reads: float | None = None,
    ) -> Estimate:  # fmt: skip
        """Move from one place to another at a steady speed, with an outer force that the rotors hold against."""
        steps, to = round(seconds / TICK), place if to is None else to
        rotors = np.array([0.0, 0.0, self.model.vehicle.mass * GRAVITY]) - outer
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        in_body = np.array([cosine * rotors[0] + sine * rotors[1], cosine * rotors[1] - sine * rotors[0], rotors[2]])
        self.poses = self.poses or [(-1.0, place)]
        for k in range(1, steps + 1):
            self.time += TICK
            self.estimator.note_force(in_body)
            measured = self.measurement(place + k / steps * (to - place), reads)
            known = self.estimator.update(measured, tie, False, TICK)
        return known


def pressed(
    vehicle: Vehicle, force: float, wind: Array, aside: Array | float = 0.0, offset: float | None = None
) -> Estimate:
    """Comes to the closed leaf and presses, once the wind is known; with a force sensor, if it has an offset."""
    normal, read = vehicle.model.door.normal(CLOSED), None if offset is None else force + offset
    vehicle.fly(3.0, vehicle.at(0.2), wind, Tie.FREE, reads=offset)
    vehicle.fly(1.5, vehicle.at(0.2), wind, to=vehicle.at(0.0), reads=offset)
    return vehicle.fly(1.5, vehicle.at(0.0), wind - force * normal + aside, reads=read)


def test_wind_is_learnt_in_free_flight_and_is_no_contact(model: Model) -> None:
    vehicle, wind = Vehicle(model), np.array([0.7, -0.4, 0.2])
    known = vehicle.fly(4.0, vehicle.at(0.3), wind)
    np.testing.assert_allclose(known.wind[:2], wind[:2], atol=0.1)
    lifted = known.wind[2] + known.lift * model.vehicle.weight
    assert lifted == pytest.approx(0.2, abs=0.05), "draught and lift: nothing tells one from the other in still hover"
    assert not known.touching and abs(known.normal_force) < 0.05 and not known.near


def test_a_tip_that_is_stopped_touches_and_its_force_is_what_the_rotors_press_with(model: Model) -> None:
    vehicle, wind = Vehicle(model), np.array([0.5, 0.3, 0.0])
    known = pressed(vehicle, 1.2, wind)
    assert known.touching and known.near
    assert known.normal_force == pytest.approx(1.2, abs=0.2)
    np.testing.assert_allclose(known.wind, wind, atol=0.25)
    np.testing.assert_allclose(known.tip_force @ model.door.normal(CLOSED), known.normal_force, atol=0.05)
    assert known.door_angle == pytest.approx(CLOSED, abs=0.005)


def test_far_from_the_leaf_a_blow_is_no_contact(model: Model) -> None:
    vehicle = Vehicle(model)
    vehicle.fly(2.0, vehicle.at(0.3), np.zeros(3))
    assert not vehicle.fly(1.0, vehicle.at(0.3), -1.5 * model.door.normal(CLOSED)).touching


@pytest.mark.parametrize("off", [0.004, -0.01])
def test_a_leaf_is_met_where_it_stands(model: Model, off: float) -> None:
    """A little before its place, or behind it: tip and leaf are one."""
    vehicle, normal = Vehicle(model), model.door.normal(CLOSED)
    vehicle.fly(3.0, vehicle.at(0.2), np.zeros(3), Tie.FREE)
    vehicle.fly(2.0, vehicle.at(0.2), np.zeros(3), to=vehicle.at(off))
    known = vehicle.fly(1.5, vehicle.at(off), -1.2 * normal)
    assert known.touching and known.normal_force == pytest.approx(1.2, abs=0.25)
    assert known.tip_angle == pytest.approx(known.door_angle, abs=0.003)


def test_a_measured_leaf_is_known_before_it_is_met(model: Model) -> None:
    vehicle, door = Vehicle(model), model.door
    before = vehicle.fly(1.0, vehicle.at(0.5), np.zeros(3), Tie.FREE)
    vehicle.leaf = door.joint_value(CLOSED - 0.3)
    known = vehicle.fly(1.0, vehicle.at(0.5), np.zeros(3), Tie.FREE)
    assert known.door_angle == pytest.approx(CLOSED - 0.3, abs=0.005) and not known.touching
    assert known.angle_deviation < 0.5 * before.angle_deviation and known.door_rate == pytest.approx(0.0, abs=0.02)


def test_a_frame_that_is_known_before_the_first_pose_fixes_the_face(model: Model) -> None:
    """A leaf that is met 4 cm behind its place then stands ajar; else its face is thought to be elsewhere."""
    faces = []
    for knows in (True, False):
        vehicle = Vehicle(model)
        if knows:
            vehicle.estimator.know_the_face()
        vehicle.fly(3.0, vehicle.at(0.2), np.zeros(3), Tie.FREE)
        vehicle.fly(1.5, vehicle.at(0.2), np.zeros(3), to=vehicle.at(-0.01))
        known = vehicle.fly(1.5, vehicle.at(-0.01), -1.2 * model.door.normal(CLOSED))
        faces.append(abs(known.face_offset))
    assert faces[0] < 0.5 * faces[1]


def test_a_leaf_that_stands_resists_with_more_than_it_bears(model: Model) -> None:
    """So a door that sticks is pushed harder and harder, by steps that end where it moves."""
    vehicle = Vehicle(model)
    first = pressed(vehicle, 1.0, np.zeros(3))
    bears = first.normal_force * model.coupling.lever_length
    assert bears < first.resistance < bears + 0.6
    harder = vehicle.fly(1.5, vehicle.at(0.0), -3.0 * model.door.normal(CLOSED))
    assert harder.resistance > 3.0 * model.coupling.lever_length - 0.3


def test_friction_takes_a_share_of_the_normal_force(model: Model) -> None:
    vehicle, along = Vehicle(model), model.door.leaf_direction(CLOSED)
    known = pressed(vehicle, 2.0, np.zeros(3), -0.5 * along)
    assert known.friction_force[0] == pytest.approx(0.5, abs=0.25) and abs(known.wind @ along) < 0.25


def test_a_tip_that_leaves_touches_no_longer(model: Model) -> None:
    vehicle = Vehicle(model)
    assert pressed(vehicle, 1.0, np.zeros(3)).touching
    gone = vehicle.fly(1.0, vehicle.at(0.0), np.zeros(3), Tie.LEAVING, to=vehicle.at(0.1))
    assert not gone.touching and gone.normal_force == pytest.approx(0.0, abs=0.02)
    assert gone.door_angle == pytest.approx(CLOSED, abs=0.01), "the leaf has stayed"


def test_poses_that_are_late_are_carried_on_to_now(model: Model) -> None:
    vehicle = Vehicle(model, latency=0.04)
    speed = 0.3 * np.asarray(model.door.along)
    begun = vehicle.at(0.4)
    vehicle.fly(1.0, begun, np.zeros(3), Tie.FREE)
    known = vehicle.fly(2.0, begun, np.zeros(3), Tie.FREE, to=begun + 2.0 * speed)
    np.testing.assert_allclose(known.velocity, speed, atol=0.02)
    np.testing.assert_allclose(known.position, begun + 2.0 * speed, atol=0.003)


def test_the_heading_goes_on_without_jumps(model: Model) -> None:
    vehicle = Vehicle(model)
    for turn in (0.0, 3.0, 3.3):
        vehicle.yaw = math.remainder(model.start_yaw + turn, 2.0 * math.pi)
        known = vehicle.fly(2.0, np.array([-1.0, 0.0, 1.0]), np.zeros(3), Tie.FREE)
    assert known.yaw == pytest.approx(model.start_yaw + 3.3, abs=0.01)


def test_a_mission_that_begins_in_contact_knows_it_at_once(model: Model) -> None:
    vehicle = Vehicle(Model(model.scenario.replace(mission__start="contact")))
    assert vehicle.fly(TICK, vehicle.at(0.0), -0.5 * model.door.normal(CLOSED)).touching


def test_a_force_sensor_tells_wind_that_turns_in_contact_from_the_push(model: Model) -> None:
    off = []
    for offset in (None, 0.3):
        vehicle, normal = Vehicle(model), model.door.normal(CLOSED)
        pressed(vehicle, 1.0, np.zeros(3), offset=offset)
        reads = None if offset is None else 1.0 + offset
        known = vehicle.fly(4.0, vehicle.at(0.0), -2.0 * normal, reads=reads)  # 1 N more, which is wind
        off.append(abs(known.normal_force - 1.0))
    assert off[1] < 0.5 < off[0]


def test_what_is_not_finite_is_an_error_that_names_it(model: Model) -> None:
    vehicle = Vehicle(model)
    vehicle.fly(0.1, vehicle.at(0.3), np.zeros(3))
    vehicle.time += TICK
    bad = replace(vehicle.measurement(vehicle.at(0.3)), attitude=np.array([0.0, math.nan, 0.0]))
    with pytest.raises(DoormanError, match="attitude"):
        vehicle.estimator.update(bad, Tie.FREE, False, TICK)


def test_a_clock_that_jumps_is_survived_and_what_is_known_of_the_leaf_stays(model: Model) -> None:
    vehicle = Vehicle(model)
    before = pressed(vehicle, 1.0, np.zeros(3))
    vehicle.time += 20.0
    after = vehicle.fly(0.5, vehicle.at(0.0), -1.0 * model.door.normal(CLOSED))
    assert not after.lost and np.isfinite(after.state).all()
    assert after.door_angle == pytest.approx(before.door_angle, abs=0.01)


def test_a_bank_without_a_meaning_says_so_once_and_begins_anew(model: Model) -> None:
    vehicle = Vehicle(model)
    vehicle.fly(1.0, vehicle.at(0.3), np.zeros(3))
    vehicle.estimator._bank._memory.kept_covariances[:] = math.nan  # what no input is known to bring about
    assert vehicle.fly(TICK, vehicle.at(0.3), np.zeros(3)).lost
    assert not vehicle.fly(0.5, vehicle.at(0.3), np.zeros(3)).lost


def test_the_speed_of_the_tip_leaves_out_tilting(model: Model) -> None:
    vehicle = Vehicle(model)
    vehicle.fly(0.5, vehicle.at(0.05), np.zeros(3), Tie.FREE)
    seen = vehicle.measurement(vehicle.at(0.05))
    nods = replace(seen, time=seen.time + 1e-6, pose_time=seen.pose_time, body_rates=np.array([0.0, 0.6, 0.0]))
    still = vehicle.estimator.update(seen, Tie.FREE, False, TICK)
    tilting = vehicle.estimator.update(nods, Tie.FREE, False, TICK)
    assert tilting.attitude_rates[1] == pytest.approx(0.6)
    assert tilting.tip_speed == pytest.approx(still.tip_speed, abs=1e-3)
