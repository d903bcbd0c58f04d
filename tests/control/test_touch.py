"""What counts as a touch, and where a pushing vehicle is told to be: hovering at a distance, in wind, beside a jamb."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from believed import changed
from paper_door import door_normal

from doorman.control.at_the_leaf import AtTheLeaf
from doorman.control.doorway import Doorway
from doorman.control.estimation.estimator import Estimate, Estimator, Tie
from doorman.control.state_converter import StateConverter
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.mission.opening import Opening
from doorman.mission.phases.phase import Phase
from doorman.mission.schedule import PlanSchedule
from doorman.mission.sequence import Sequence
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder
from doorman.scenario import Scenario
from doorman.signals import Measurement

TICK = 0.004


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Scenario.load("push"))


@pytest.fixture(scope="module")
def converter(model: Model) -> StateConverter:
    return StateConverter(model)


@pytest.fixture(scope="module")
def schedule(model: Model) -> PlanSchedule:
    return PlanSchedule(Planner(model), 0, Recorder(None, {}))


@pytest.fixture
def swing(model: Model, schedule: PlanSchedule) -> Opening:
    return Opening(model, schedule)


def hovering(model: Model, away: float, push: float, seconds: float) -> list[Estimate]:
    """A vehicle held still `away` from the contact by rotors that press with `push`, after a second of hover."""
    estimator, angle = Estimator(model), model.start_angle
    normal, arm, rest = door_normal(angle), model.start_arm, np.zeros(3)
    place = model.coupling.vehicle_position([0.0, 0.0, model.start_yaw], angle, arm) - away * normal
    attitude = np.array([0.0, 0.0, model.start_yaw])
    weight, estimates = np.array([0.0, 0.0, model.vehicle.mass * GRAVITY]), []
    for tick in range(round((1.0 + seconds) / TICK)):
        now = tick * TICK
        tie, force = (Tie.FREE, weight) if now < 1.0 else (Tie.PUSHING, weight + push * normal)
        measurement = Measurement(now, place, rest, attitude, rest, arm, np.zeros(model.n_arm), now)
        estimator.note_force(rotation_body_to_world(attitude).T @ force)
        estimates.append(estimator.update(measurement, tie, False, TICK if tick else 0.0))
    return estimates


def test_a_tip_that_is_stopped_before_the_leafs_place_has_met_the_leaf_there(model: Model) -> None:
    """Wind has blown the leaf towards the vehicle: until it is known, the leaf's force passes for wind."""
    leaf, normal = AtTheLeaf(model), door_normal(model.start_angle)
    for advance, met in ((0.0, True), (0.02, False)):
        leaf.begin(0.0)
        estimates = hovering(model, 0.3, 1.0, 3.0)
        found = [
            leaf.blocked(replace(one, position=one.position + advance * one.time * normal)) for one in estimates[250:]
        ]
        assert any(found) is met
        assert not any(found[: round(0.9 / TICK)]), "not at once"
    estimator = Estimator(model)
    place = estimates[-1].position
    measurement = Measurement(0.0, place, np.zeros(3), np.zeros(3), np.zeros(3), model.start_arm, np.zeros(4), 0.0)
    seen = estimator.update(measurement, Tie.PUSHING, False, 0.0)
    estimator.meet_leaf(seen.tip_angle, np.array([0.2, 0.0, 0.0]))
    for tick in range(1, 25):
        known = estimator.update(
            replace(measurement, time=tick * TICK, pose_time=tick * TICK), Tie.PUSHING, False, TICK
        )
    assert known.near and known.tip_angle == pytest.approx(known.door_angle, abs=0.05)
    assert known.face_offset == pytest.approx(0.3, abs=0.03), (
        "the closed leaf's joint goes no farther: the map is wrong"
    )


def at_rest(model: Model, shift: np.ndarray) -> Estimate:
    """What is estimated at the start of the swing, with the vehicle shifted from where the plan has it."""
    last = hovering(model, 0.0, 1.0, 1.0)[-1]
    return changed(model, last, position=last.position + shift)


def test_the_gap_to_the_leaf_is_the_plans_constraint(model: Model) -> None:
    last = at_rest(model, np.zeros(3))
    gap = Doorway(model).gap(last.position, last.state[:3], last.door_angle)
    level = model.constraints([*last.state[:3], last.door_angle, 0.0, *last.arm_angles])
    assert gap == pytest.approx(-level[model.constraint_names.index("disc clear of leaf")], abs=1e-4)


def test_a_vehicle_that_drifts_towards_a_jamb_is_sent_back_before_it_is_too_near(model: Model) -> None:
    doorway, drift = Doorway(model), np.array([0.0, 0.1, 0.0])
    for bound, outwards in ((doorway.highest, drift), (doorway.lowest, -drift)):
        place = np.array([0.0, bound, 1.3]) - 0.1 * outwards
        assert doorway.inside(place, place, place, outwards)[1] * outwards[1] < place[1] * outwards[1]
        np.testing.assert_array_equal(doorway.inside(place, place, place, -outwards), place)


def test_jambs_are_as_deep_as_their_boxes_and_seen_before_they_are_met(model: Model) -> None:
    doorway, radius, depth = Doorway(model), model.vehicle.radius, model.door.frame_depth
    x, y, _ = model.door.hinge_position
    still, beside = np.zeros(3), y + model.door.width - radius
    for into in (-depth, -0.5 * depth, model.door.frame_back):
        assert doorway.gap_to_jambs(np.array([x + into, beside - 0.01, 1.3]), still) == pytest.approx(0.01, abs=1e-9)
    before = doorway.gap_to_jambs(np.array([x - depth - radius - 0.02, beside + radius, 1.3]), still)
    assert before == pytest.approx(0.02, abs=1e-9)
    behind = doorway.gap_to_jambs(np.array([x + model.door.frame_back + radius + 0.02, beside + radius, 1.3]), still)
    assert behind == pytest.approx(0.02, abs=1e-9)
    place, drift = np.array([x, beside - 0.02, 1.3]), np.array([0.0, 0.1, 0.0])
    assert doorway.gap_to_jambs(place, drift) < 0.01
    assert doorway.gap_to_jambs(place, -drift) == pytest.approx(0.02, abs=1e-9)


def test_a_tip_that_rests_on_the_leaf_is_kept_from_leaving_and_not_from_pressing(model: Model) -> None:
    leaf, last = AtTheLeaf(model), hovering(model, 0.0, 1.0, 1.0)[-1]
    leaf.begin(0.0)
    coming, leaving, pressing = (leaf.rest(replace(last, tip_speed=speed), 0.1).push for speed in (0.02, -0.05, 0.05))
    assert coming is not None and leaving is not None
    assert coming == pressing < leaving


def test_a_tip_beside_the_contact_point_is_held_where_it_is(model: Model) -> None:
    leaf, last = AtTheLeaf(model), hovering(model, 0.0, 1.0, 1.0)[-1]
    along, up = model.door.face(last.door_angle)
    beside = changed(model, last, position=last.position + 0.03 * along - 0.02 * up)
    leaf.begin(beside.yaw, beside)
    off = leaf.push(beside, 1.0).position - beside.position
    assert [along @ off, up @ off] == pytest.approx([0.0, 0.0], abs=1e-3)


def test_a_slammed_door_is_not_given_way_to_faster_than_the_supervisor_allows(model: Model) -> None:
    last = at_rest(model, np.zeros(3))

    def way_out(leaf: AtTheLeaf, speed: float) -> float:
        for aside in (0.3, -0.3):
            setpoint = leaf.give_way(replace(last, velocity=np.array([speed, aside, 0.0])))
            assert setpoint.acceleration[1] * aside < 0.0 and not setpoint.acceleration[[0, 2]].any(), "it brakes"
            assert setpoint.max_tilt == pytest.approx(0.48) and setpoint.push is None
        return float(setpoint.velocity[0])

    leaf = AtTheLeaf(model)
    assert [way_out(leaf, speed) for speed in (0.3, -1.0, -1.4)] == pytest.approx([-0.9, -1.0, -1.2])
    slow = Model(Scenario.load("push", {"safety.speed": 0.8}))
    assert [way_out(AtTheLeaf(slow), speed) for speed in (0.3, -1.0)] == pytest.approx([-0.64, -0.64])


def test_a_leaf_that_moves_on_by_itself_is_not_given_up(
    model: Model, converter: StateConverter, schedule: PlanSchedule
) -> None:
    reasons: list[str] = []
    estimator = Estimator(model)
    sequence = Sequence(model, converter, schedule, estimator, lambda _, phase, reason: reasons.append(reason))
    last = at_rest(model, np.zeros(3))
    sequence.enter(Phase.RECOVER, last, "contact lost")
    limit = 6.0  # s, as docs/mission.md says

    def flown(start: float, seconds: float, angle: float, rate: float) -> float | None:
        """Time at which it is given up."""
        for k in range(int(seconds / 0.05)):
            state = last.state.copy()
            state[3:5] = angle + rate * 0.05 * k, rate
            now = start + 0.05 * k
            away = last.position - 0.1 * door_normal(float(state[3]))
            estimate = changed(model, last, time=last.time + now, state=state, touching=False, position=away)
            sequence.step(estimate, np.zeros(3), 0.05)
            if sequence.phase is not Phase.RECOVER:
                return now
        return None

    begin, rate = model.start_angle, np.radians(-1.5)
    assert flown(0.0, 1.5 * limit, begin, rate) is None
    stands = flown(1.5 * limit, 2.0 * limit, begin + rate * 1.5 * limit, 0.0)
    assert stands == pytest.approx(2.5 * limit, abs=1.0)
    assert "recover took longer" in reasons[-1]
    sequence.enter(Phase.RECOVER, last, "contact lost")
    assert flown(0.0, 4.0 * limit, begin, rate) == pytest.approx(3.0 * limit, abs=0.1), "no leaf is followed for ever"


def test_a_heading_that_is_lost_ends_the_opening(model: Model, swing: Opening) -> None:
    last = at_rest(model, np.zeros(3))

    def reason(degrees: float) -> str:
        state = last.state.copy()
        state[2] = model.start_yaw + np.radians(degrees)
        return swing.stuck(replace(last, state=state))

    assert [reason(degrees) for degrees in (0.0, 38.0, -38.0)] == ["", "", ""]
    assert all("heading is lost" in reason(degrees) for degrees in (42.0, -42.0, 170.0))


@pytest.mark.parametrize(("first", "swung"), [(6.0, False), (0.0, True)])
def test_a_door_has_swung_only_where_it_is_more_open_than_at_the_start(
    model: Model, swing: Opening, first: float, swung: bool
) -> None:
    """A tip that is stopped before the leaf shows a door that closes to its place: nobody holds that one when it stands."""
    last, start, rate = at_rest(model, np.zeros(3)), model.start_angle, np.radians(2.0)
    swing.resume(last.time)
    given_up = None
    for k in range(320):
        spent, state = 0.05 * k, last.state.copy()
        moves = spent < 3.0
        state[3:5] = start + np.radians(first) - rate * min(spent, 3.0), -rate * moves
        estimate = replace(last, time=last.time + spent, state=state, door_disturbance=-1.0, tip_angle=float(state[3]))
        swing.update(estimate)
        if swing.stuck(estimate):
            given_up = spent
            break
    assert given_up == pytest.approx(13.0, abs=0.5)
    assert swing.may_go_on(estimate) is swung


def test_rotors_that_fly_into_the_leaf_are_noticed_in_time(model: Model) -> None:
    """A tip that is past the leaf's edge, or has turned away, does not keep the disc off it."""
    leaf, calm = AtTheLeaf(model), hovering(model, 0.1, 0.0, 0.1)[-1]
    normal, radius = door_normal(calm.door_angle), model.vehicle.radius
    place = model.door.contact_point(calm.door_angle, model.coupling.distance_from_hinge, model.coupling.height)

    def flying(gap: float, speed: float, touching: bool = False, door_rate: float = 0.0) -> Estimate:
        state = calm.state.copy()
        state[:2], state[4] = 0.0, door_rate
        position = place - (radius + gap) * normal
        return changed(model, calm, position=position, velocity=speed * normal, state=state, touching=touching)

    assert not leaf.hits_the_rotors(flying(0.06, 0.1))
    assert leaf.hits_the_rotors(flying(0.06, 0.2)), "it cannot brake before"
    assert not leaf.hits_the_rotors(flying(0.02, 0.0))
    assert leaf.hits_the_rotors(flying(0.01, -0.1))
    away = -0.2 / model.coupling.distance_from_hinge
    assert not leaf.hits_the_rotors(flying(0.06, 0.2, door_rate=away)), "the leaf swings away as fast"
    assert not leaf.hits_the_rotors(flying(0.02, 0.2, touching=True)), "the tip keeps it off"
    assert leaf.hits_the_rotors(flying(0.01, 0.0, touching=True))
    before = flying(0.06, 0.2)
    before = replace(before, tip=before.contact_point - 0.01 * normal)
    assert not leaf.hits_the_rotors(before), "the tip meets the leaf first"
    assert leaf.hits_the_rotors(replace(flying(0.03, 0.0), face_offset=0.015)), (
        "the face stands before its place in the map"
    )
    turning = np.array([0.0, 0.0, np.radians(80.0)])  # about the tip, by which the vehicle comes nearer to the leaf
    turned = flying(0.06, 0.0, touching=True)
    assert not leaf.hits_the_rotors(replace(turned, attitude_rates=0.0 * turning))
    askew = changed(model, turned, state=turned.state + np.eye(len(turned.state))[2] * 0.6)
    assert leaf.hits_the_rotors(replace(askew, attitude_rates=turning)), "it turns on"
    assert not leaf.hits_the_rotors(replace(askew, attitude_rates=-turning)), "it turns back"


@pytest.mark.parametrize("turned", [-0.3, 0.1])
def test_an_opened_door_is_eased_at_the_heading_that_held_it(model: Model, turned: float) -> None:
    """A vehicle that is turned meanwhile is told to go back to where its heading had it, and not after its turn."""
    known, leaf = hovering(model, 0.0, 4.0, 0.6)[-1], AtTheLeaf(model)
    along, _ = model.door.face(known.door_angle)
    known = replace(known, touching=True, tip_force=known.tip_force + 1.0 * along)
    state = known.state.copy()
    state[2] += turned
    later = replace(known, state=state)
    leaf.begin(float(known.state[2]), known, 4.0)
    straight, after = leaf.push(known, 4.0), leaf.push(later, 4.0)
    assert after.position == pytest.approx(straight.position, abs=1e-9) and after.yaw == straight.yaw
    beside = [float(along @ leaf.push(later, push).force) for push in (4.0, 2.0, 0.0)]
    assert beside[0] > 0.4 and beside == pytest.approx([beside[0], 0.5 * beside[0], 0.0], abs=1e-9)
    leaf.begin(float(known.state[2]), known)
    moved = leaf.push(later, 4.0).position - straight.position
    assert np.linalg.norm(moved) > 0.02, "a touch keeps the tip's place, whatever the heading"
