"""The estimates at the leaf on motions whose truth is known: wind, contact, forces, and what the hinge resists with."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, write_edited

from doorman.control.estimation.beliefs import Beliefs
from doorman.control.estimation.door_filter import DoorFilter
from doorman.control.estimation.leaf_estimator import LeafEstimate, LeafEstimator
from doorman.control.state_converter import StateConverter
from doorman.gravity import GRAVITY
from doorman.model import Model
from doorman.planning.limits import largest_push
from doorman.scenario import Scenario
from doorman.signals import Measurement

Array = np.ndarray
TICK = 0.004
CLOSED = math.pi / 2


@pytest.fixture(scope="module", params=["push", "push_left"])
def model(request: pytest.FixtureRequest) -> Model:
    return Model(request.param)


class Vehicle:
    """A level vehicle that moves as it is told, and what its estimator makes of that."""

    def __init__(self, model: Model) -> None:
        self.model, self.estimator = model, LeafEstimator(model, StateConverter(model))
        self.time, self.yaw = 0.0, model.start_yaw
        self.place: Array | None = None
        self.velocity = np.zeros(3)

    def at(self, distance: float, angle: float = CLOSED) -> Array:
        """Position with the tip this far before the leaf."""
        posture = self.model.on_the_way(angle)
        place = self.model.coupling.vehicle_position([0.0, 0.0, self.yaw], angle, posture[5:])
        return np.asarray(place - distance * self.model.door.normal(angle))

    def fly(
        self,
        seconds: float,
        place: Array,
        outer: Array,
        seeks: bool = True,
        to: Array | None = None,
        wanted: float = 0.0,
        reads: float | None = None,
    ) -> LeafEstimate:
        """Move from one place to another at a steady speed, with an outer force that the rotors hold against.

        A force sensor in the tip reads the same all the time.
        """
        steps = round(seconds / TICK)
        to = place if to is None else to
        rotors = np.array([0.0, 0.0, self.model.vehicle.mass * GRAVITY]) - outer
        for k in range(1, steps + 1):
            self.time += TICK
            position = place + k / steps * (to - place)
            measured = Measurement(
                self.time, position, np.zeros(3), np.array([0.0, 0.0, self.yaw]), np.zeros(3), self.model.start_arm,
                np.zeros(self.model.n_arm), self.time, tip_force=reads,
            )  # fmt: skip
            known = self.estimator.update(measured, rotors, TICK, seeks, wanted)
        return known


def test_wind_is_learnt_in_free_flight_and_is_no_contact(model: Model) -> None:
    vehicle, wind = Vehicle(model), np.array([0.7, -0.4, 0.2])
    known = vehicle.fly(4.0, vehicle.at(0.3), wind)
    np.testing.assert_allclose(known.wind, wind, atol=0.03)
    assert not known.touching and known.normal_force == 0.0


def pressed(
    vehicle: Vehicle, force: float, wind: Array, aside: Array | float = 0.0, offset: float | None = None
) -> LeafEstimate:
    """Comes to the closed leaf and presses, once the wind is known; with a force sensor, if it has an offset."""
    normal, read = vehicle.model.door.normal(CLOSED), None if offset is None else force + offset
    vehicle.fly(3.0, vehicle.at(0.2), wind, seeks=False, reads=offset)
    vehicle.fly(1.5, vehicle.at(0.2), wind, to=vehicle.at(0.0), reads=offset)
    return vehicle.fly(1.5, vehicle.at(0.0), wind - force * normal + aside, reads=read)


def test_a_tip_that_is_stopped_touches_and_its_force_is_what_the_rotors_press_with(model: Model) -> None:
    vehicle, wind = Vehicle(model), np.array([0.5, 0.3, 0.0])
    known = pressed(vehicle, 1.2, wind)
    assert known.touching
    assert known.normal_force == pytest.approx(1.2, abs=0.15)
    np.testing.assert_allclose(known.wind, wind, atol=0.25)
    assert known.door_angle == pytest.approx(CLOSED, abs=0.005)


def test_far_from_the_leaf_a_blow_is_no_contact(model: Model) -> None:
    vehicle = Vehicle(model)
    vehicle.fly(2.0, vehicle.at(0.3), np.zeros(3))
    assert not vehicle.fly(1.0, vehicle.at(0.3), -1.5 * model.door.normal(CLOSED)).touching


def first_met(model: Model, distance: float) -> LeafEstimate:
    """A tip that is stopped this far before the leaf's place."""
    vehicle, normal = Vehicle(model), model.door.normal(CLOSED)
    vehicle.fly(3.0, vehicle.at(0.2), np.zeros(3), seeks=False)
    vehicle.fly(2.0, vehicle.at(0.2), np.zeros(3), to=vehicle.at(distance))
    return vehicle.fly(1.5, vehicle.at(distance), -1.2 * normal)


@pytest.mark.parametrize("face", [0.03, 0.0, -0.03])
def test_the_first_touch_of_a_closed_leaf_says_where_its_face_stands(model: Model, face: float) -> None:
    known = first_met(model, face)
    assert known.touching and known.face_offset == pytest.approx(face, abs=0.005)
    assert known.door_angle == pytest.approx(CLOSED, abs=0.005)


def test_a_leaf_that_is_met_far_behind_its_place_is_ajar(model: Model) -> None:
    """Wind has opened it: its face is where the model has it, and its angle is another."""
    known = first_met(model, -0.07)
    assert known.touching and abs(known.face_offset) < 0.01
    off = 0.07 / model.coupling.distance_from_hinge
    assert abs(known.door_angle - CLOSED) == pytest.approx(off, abs=0.02)


@pytest.mark.parametrize(("upper", "touches"), [(1.5708, False), (1.7, True)])
def test_no_leaf_is_met_before_the_end_of_its_joint(upper: float, touches: bool, tmp_path: Path) -> None:
    door = write_edited(tmp_path / "door.urdf", DOOR, ('upper="1.5708"', f'upper="{upper}"'))
    known = first_met(Model(Scenario.load("push", {"door.urdf": str(door)})), 0.066)
    assert known.touching is touches


def test_a_pull_in_contact_is_wind(model: Model) -> None:
    vehicle = Vehicle(model)
    assert pressed(vehicle, 1.0, np.zeros(3)).touching
    normal = model.door.normal(CLOSED)
    known = vehicle.fly(2.0, vehicle.at(0.0), 1.0 * normal)  # as no leaf would: towards it
    assert known.wind @ normal > 0.5


def test_friction_takes_no_more_than_its_share_and_the_rest_is_wind(model: Model) -> None:
    vehicle, along = Vehicle(model), model.door.leaf_direction(CLOSED)
    little = pressed(vehicle, 2.0, np.zeros(3), -0.5 * along)
    assert little.friction_force[0] == pytest.approx(0.5, abs=0.15) and abs(little.wind @ along) < 0.15
    much = vehicle.fly(4.0, vehicle.at(0.0), -2.0 * model.door.normal(CLOSED) - 3.0 * along)
    assert abs(much.friction_force[0]) < 1.3 and much.wind @ along < -1.2


def test_a_door_that_sticks_is_believed_to_resist_more_and_more_up_to_a_bound(model: Model) -> None:
    vehicle = Vehicle(model)
    first = pressed(vehicle, 1.0, np.zeros(3)).resistance
    push = -1.0 * model.door.normal(CLOSED)
    later = vehicle.fly(1.0, vehicle.at(0.0), push, wanted=0.1).resistance
    last = vehicle.fly(6.0, vehicle.at(0.0), push, wanted=0.1).resistance
    largest = largest_push(model, model.scenario.control.max_tilt) * model.coupling.lever_length
    assert 0.5 < later - first < 0.8 and last == pytest.approx(largest), "a seal is pushed with all that is allowed"


class Loosened:
    """A leaf that its seal held while it was pushed with this force, and that nothing holds from then on."""

    def __init__(self, model: Model, force: float) -> None:
        self.vehicle = vehicle = Vehicle(model)
        pressed(vehicle, force, np.zeros(3))
        normal = model.door.normal(CLOSED)
        self.stuck = vehicle.fly(3.0, vehicle.at(0.0), -force * normal, wanted=0.1)
        whole = model.door.inertia / model.coupling.lever_length**2 + model.vehicle.mass
        speed, place, self.way = 0.0, vehicle.at(0.0), 0.0
        weight = np.array([0.0, 0.0, model.vehicle.mass * GRAVITY])
        for _ in range(round(0.6 / TICK)):
            vehicle.time += TICK
            speed += TICK * force / whole
            self.way += TICK * speed
            measured = Measurement(
                vehicle.time, place + self.way * normal, np.zeros(3), np.array([0.0, 0.0, vehicle.yaw]), np.zeros(3),
                model.start_arm, np.zeros(model.n_arm), vehicle.time,
            )  # fmt: skip
            self.known = vehicle.estimator.update(measured, weight + force * normal, TICK, True, 0.1)


@pytest.mark.parametrize("force", [4.0, 6.0])
def test_a_seal_that_gives_way_is_noticed_at_once_and_is_no_wind(model: Model, force: float) -> None:
    """The push that held against it would fling a leaf that resists no more."""
    leaf = Loosened(model, force)
    assert leaf.stuck.resistance > 2.0 and 0.02 < leaf.way < 0.2
    assert leaf.known.resistance < 1.0
    assert abs(leaf.known.wind @ model.door.normal(CLOSED)) < 0.2


def test_noise_of_the_poses_is_no_seal_that_gives_way_on_an_open_leaf(model: Model) -> None:
    """The push that holds the leaf against its closer must not end: the leaf would swing back."""
    vehicle, push = Vehicle(model), -3.0 * model.door.normal(CLOSED)
    pressed(vehicle, 3.0, np.zeros(3))
    there = vehicle.at(0.0) + 0.2 * model.door.normal(CLOSED)
    swung = vehicle.fly(3.0, vehicle.at(0.0), push, to=there, wanted=0.1)
    ahead = there + 0.015 * model.door.normal(CLOSED)
    jerked = vehicle.fly(0.06, there, push, to=ahead, wanted=0.1)
    later = vehicle.fly(0.1, ahead, push, wanted=0.1)
    assert jerked.door_rate < swung.door_rate
    assert min(jerked.resistance, later.resistance) > 0.7 * swung.resistance


@pytest.mark.parametrize(("force", "stays"), [(2.5, True), (0.0, False)])
def test_a_leaf_that_drives_the_tip_back_is_in_contact_as_long_as_its_force_is_felt(
    model: Model, force: float, stays: bool
) -> None:
    """A closer that is stronger than its friction follows the tip; where nothing is felt, the tip has left the leaf."""
    vehicle, normal = Vehicle(model), model.door.normal(CLOSED)
    pressed(vehicle, 3.0, np.zeros(3))
    ahead = vehicle.at(0.0) + 0.1 * normal
    vehicle.fly(2.0, vehicle.at(0.0), -3.0 * normal, to=ahead, wanted=0.1)
    back = ahead - 0.06 * normal
    assert 0.06 / model.coupling.lever_length > 0.07
    known = vehicle.fly(1.5, ahead, -force * normal, to=back)
    assert known.touching == stays
    if stays:
        assert abs(known.wind @ normal) < 0.5


def test_wind_that_jumps_before_the_first_touch_is_no_leaf(model: Model) -> None:
    """It stops the tip as a leaf does, but a closed leaf does not drive it back."""
    vehicle, normal, wind = Vehicle(model), model.door.normal(CLOSED), np.array([0.0, 0.0, 0.0])
    vehicle.fly(3.0, vehicle.at(0.2), wind, seeks=False)
    vehicle.fly(2.0, vehicle.at(0.2), wind, to=vehicle.at(0.05))
    jumped = wind - 1.2 * normal
    assert vehicle.fly(0.3, vehicle.at(0.05), jumped).touching
    known = vehicle.fly(0.6, vehicle.at(0.05), jumped, to=vehicle.at(0.08))
    assert not known.touching
    assert known.wind @ normal < -0.6


@pytest.mark.parametrize("alone", [True, False])
def test_a_tip_that_sets_off_as_if_no_leaf_hung_on_it_has_left_it(model: Model, alone: bool) -> None:
    """A wind that has begun to blow as hard as the leaf resisted passes for the leaf, but has no inertia."""
    vehicle, normal = Vehicle(model), model.door.normal(CLOSED)
    pressed(vehicle, 2.5, np.zeros(3))
    there, sets_off = vehicle.at(0.0) + 0.2 * normal, 1.3 if alone else 0.5
    vehicle.fly(3.0, vehicle.at(0.0), -2.5 * normal, to=there, wanted=0.1)
    leaf = 0.0 if alone else model.door.inertia / model.coupling.lever_length**2
    force = 2.5 + (model.vehicle.mass + leaf) * sets_off
    weight, left = np.array([0.0, 0.0, model.vehicle.mass * GRAVITY]), False
    for k in range(1, round(0.4 / TICK) + 1):
        vehicle.time += TICK
        measured = Measurement(
            vehicle.time, there + 0.5 * sets_off * (k * TICK) ** 2 * normal, np.zeros(3),
            np.array([0.0, 0.0, vehicle.yaw]), np.zeros(3), model.start_arm, np.zeros(model.n_arm), vehicle.time,
        )  # fmt: skip
        known = vehicle.estimator.update(measured, weight + force * normal, TICK, True, 0.1)
        left = left or not known.touching
    assert left == alone
    assert (known.wind @ normal < -1.0) == alone


def test_a_leaf_that_stands_beyond_the_goal_is_pushed_less_and_less() -> None:
    """A closer that is stronger than its friction then brings it back."""
    near = Model(Scenario.load("push", {"goal.door_angle": 1.4}))
    vehicle, normal, goal = Vehicle(near), near.door.normal(CLOSED), near.goal_angle
    pressed(vehicle, 2.0, np.zeros(3))
    beyond = vehicle.at(0.0) + (CLOSED - goal + 0.05) * near.coupling.lever_length * normal
    there = vehicle.fly(3.0, vehicle.at(0.0), -2.0 * normal, to=beyond, wanted=0.1)
    assert there.touching and there.door_angle < goal - 0.02
    early = vehicle.fly(0.3, beyond, -2.0 * normal).resistance
    assert vehicle.fly(3.0, beyond, -2.0 * normal).resistance < 0.6 * early


def test_what_the_hinge_resists_with_is_doubted_as_the_wind_is(model: Model) -> None:
    """An unknown force of the wind in contact passes for torque: half a minute later it is less certain."""
    vehicle, force = Vehicle(model), -2.0 * model.door.normal(CLOSED)
    early = pressed(vehicle, 2.0, np.zeros(3)).hinge
    late = vehicle.fly(20.0, vehicle.at(0.0), force).hinge
    assert late.torque_deviation > early.torque_deviation


def test_what_the_hinge_resists_with_is_doubted_more_the_farther_the_leaf_has_swung(model: Model) -> None:
    """A hinge that leans or binds resists with more or less elsewhere, and a filter that averages does not see it."""
    vehicle, push = Vehicle(model), -2.0 * model.door.normal(CLOSED)
    pressed(vehicle, 2.0, np.zeros(3))
    there = vehicle.at(0.0) + 0.3 * model.door.normal(CLOSED)
    known = vehicle.fly(4.0, vehicle.at(0.0), push, to=there)
    assert known.hinge.torque_deviation > 0.7 * math.sqrt((CLOSED - known.door_angle) / 3.0) > 0.2


@pytest.mark.parametrize(("stiffness", "damping"), [(2.5, 0.0), (0.0, 9.0)])
def test_what_plans_are_told_of_a_hinge_holds_the_closer_that_the_scenario_names(
    stiffness: float, damping: float
) -> None:
    """They know nothing else of it: a leaf that moves steadily resists with what it is pushed with."""
    named = Model(Scenario.load("push", {"door.stiffness": stiffness, "door.damping": damping}))
    vehicle, force, lever = Vehicle(named), 3.0, named.coupling.lever_length
    pressed(vehicle, force, np.zeros(3))
    normal = named.door.normal(CLOSED)
    there = vehicle.at(0.0) + 0.2 * normal
    known = vehicle.fly(4.0, vehicle.at(0.0), -force * normal, to=there)
    assert known.touching and known.resistance == pytest.approx(force * lever, abs=0.35)


def test_a_tip_that_does_not_seek_the_leaf_does_not_touch_it(model: Model) -> None:
    vehicle = Vehicle(model)
    assert pressed(vehicle, 1.0, np.zeros(3)).touching
    assert not vehicle.fly(0.1, vehicle.at(0.0), -1.0 * model.door.normal(CLOSED), seeks=False).touching


def test_a_leaf_that_was_left_is_sought_where_it_stood(model: Model) -> None:
    vehicle, wind = Vehicle(model), np.zeros(3)
    pressed(vehicle, 1.2, wind)
    way = math.copysign(0.02, model.goal_angle - model.start_angle)
    opened = CLOSED + 20 * way
    for k in range(1, 21):
        on_the_way = [CLOSED + step * way for step in (k - 1, k)]
        push = wind - 1.2 * model.door.normal(on_the_way[0])
        known = vehicle.fly(0.5, vehicle.at(0.0, on_the_way[0]), push, to=vehicle.at(0.0, on_the_way[1]), wanted=0.04)
    assert known.touching and known.door_angle == pytest.approx(opened, abs=0.03)
    left = known.door_angle
    vehicle.fly(2.0, vehicle.at(0.0, opened), wind, seeks=False, to=vehicle.at(0.3))
    known = vehicle.fly(0.1, vehicle.at(0.3), wind)
    assert not known.touching and known.door_angle == pytest.approx(left, abs=0.01)


def test_the_heading_goes_on_without_jumps(model: Model) -> None:
    vehicle, seen = Vehicle(model), []
    for k in range(200):
        vehicle.yaw = math.remainder(3.0 + 0.005 * k, 2.0 * math.pi)
        seen.append(float(vehicle.fly(TICK, vehicle.at(0.5), np.zeros(3)).attitude[2]))
    assert np.abs(np.diff(seen)).max() < 0.01 and seen[-1] - seen[0] == pytest.approx(0.995, abs=0.01)


@pytest.fixture(scope="module")
def drawer() -> Model:
    return Model("shipped:drawer_close")


def met(drawer: Model, before: float, force: float) -> LeafEstimate:
    """A tip that comes to the open drawer's front, which stands so far before its place, and presses."""
    vehicle, angle = Vehicle(drawer), drawer.travel.start
    vehicle.fly(3.0, vehicle.at(0.2, angle), np.zeros(3), seeks=False)
    vehicle.fly(1.5, vehicle.at(0.2, angle), np.zeros(3), to=vehicle.at(before, angle))
    return vehicle.fly(1.5, vehicle.at(before, angle), -force * drawer.door.normal(angle))


@pytest.mark.parametrize("before", [0.02, 0.0, -0.02])
def test_the_front_of_a_drawer_is_met_where_it_stands(drawer: Model, before: float) -> None:
    known = met(drawer, before, 1.2)
    assert known.touching and known.face_offset == pytest.approx(before, abs=0.005)
    assert known.door_angle == pytest.approx(drawer.travel.start, abs=0.005)
    assert known.normal_force == pytest.approx(1.2, abs=0.25)
    assert known.lever == pytest.approx(drawer.door.per_angle)


def test_a_flap_that_stands_open_has_the_friction_that_its_weight_needs() -> None:
    """Nothing else says so before the touch."""
    keys = {"contact.kind": "push", "contact.frame": None, "contact.side": "pull", "contact.distance_from_hinge": 0.5,
            "start.opening": 0.5, "goal.opening": 0.0}  # fmt: skip
    flap = Model(Scenario.load("shipped:hatch", keys))
    weight = abs(flap.door.weight_torque(flap.travel.start))
    known = met(flap, 0.0, 1.0)
    assert weight > 1.5
    assert known.touching and known.door_angle == pytest.approx(flap.travel.start, abs=0.005)
    assert known.resistance > weight
    assert known.normal_force == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize(("beyond", "moves"), [(-0.02, True), (0.3, False)])
def test_a_tip_beside_the_range_of_the_joint_has_not_passed_the_leaf(drawer: Model, beyond: float, moves: bool) -> None:
    """A tip that slipped off a drawer's front is farther in than the drawer can be."""
    leaf = DoorFilter(drawer, Beliefs.of(drawer))
    first, end = leaf.angle, drawer.door.lower_limit
    leaf.passed(end - beyond)
    assert leaf.angle == pytest.approx(end - beyond if moves else first)


@pytest.mark.parametrize("size", [1.5, 3.0])
def test_an_observer_of_the_hinge_that_is_off_teaches_nothing(model: Model, size: float) -> None:
    """What the hinge bears is not known then; to take it for zero would make a torque of the wind that presses."""
    scenario = Scenario.load(model.scenario.name, {"control.door_observer_rate": 0.0})
    vehicle, normal = Vehicle(Model(scenario)), model.door.normal(CLOSED)
    before = vehicle.estimator._wind.state[4]
    known = pressed(vehicle, 1.0, size * normal)
    assert known.touching and float(normal @ known.wind) == pytest.approx(size, abs=0.3)
    assert vehicle.estimator._wind.state[4] == before


@pytest.mark.parametrize("start", ["hover", "contact"])
def test_a_mission_that_begins_in_contact_knows_it_at_once(start: str) -> None:
    vehicle = Vehicle(Model(Scenario.load("push", {"mission.start": start})))
    known = vehicle.fly(TICK, vehicle.at(0.0), np.zeros(3))
    assert known.touching == (start == "contact")


OFFSET = 0.15
"""Of the force sensor in the tip [N]."""


@pytest.mark.parametrize("offset", [None, OFFSET])
def test_wind_that_turns_in_contact_is_told_from_the_push_with_a_force_sensor_alone(
    model: Model, offset: float | None
) -> None:
    """Wind that draws the vehicle away takes over from the leaf's reaction: nothing else shows it."""
    vehicle, normal, along = Vehicle(model), model.door.normal(CLOSED), model.door.leaf_direction(CLOSED)
    assert pressed(vehicle, 1.5, along, offset=offset).touching
    read = None if offset is None else 0.5 + offset
    known = vehicle.fly(4.0, vehicle.at(0.0), -normal - 0.5 * normal, reads=read)
    assert known.touching
    off = abs(float(known.wind @ normal) + 1.0)
    assert off > 0.6 if offset is None else off < 0.3
    if offset is not None:
        assert known.normal_pull == pytest.approx(0.5, abs=0.1)


def test_a_force_sensor_tells_a_tip_that_rests_from_wind_that_stops_the_vehicle(model: Model) -> None:
    """A gust at the leaf is felt as a touch would be, but for the sensor."""
    touches = []
    for reads in (None, 0.0):
        vehicle = Vehicle(model)
        vehicle.fly(3.0, vehicle.at(0.2), np.zeros(3), seeks=False, reads=reads)
        vehicle.fly(1.5, vehicle.at(0.2), np.zeros(3), to=vehicle.at(0.005), reads=reads)
        known = vehicle.fly(0.6, vehicle.at(0.005), -1.5 * model.door.normal(CLOSED), reads=reads)
        touches.append(known.touching)
    assert touches == [True, False]
    assert known.wind @ model.door.normal(CLOSED) < -0.3


@pytest.mark.parametrize(("offset", "least", "most"), [(0.05, 0.03, 0.12), (0.4, 0.25, 0.5)])
def test_an_offset_of_the_force_sensor_that_no_free_flight_has_shown_stays_in_doubt(
    offset: float, least: float, most: float
) -> None:
    """A mission that begins in contact cannot learn it: the wind is known no better than that."""
    model = Model(Scenario.load("push", {"mission.start": "contact", "estimation.tip_force_offset": offset}))
    vehicle, normal = Vehicle(model), model.door.normal(CLOSED)
    vehicle.fly(20.0, vehicle.at(0.0), -1.5 * normal, reads=1.5)
    doubt = math.sqrt(float(normal @ vehicle.estimator._wind.covariance[:3, :3] @ normal))
    assert least < doubt < most
