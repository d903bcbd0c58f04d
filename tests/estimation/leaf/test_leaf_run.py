"""The bank at the leaf, pose by pose: a wind that turns, a leaf at rest, a touch, a slip, and what it cannot go on from."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.estimation.leaf.leaf_filter import AT_THE_LEAF, AWAY
from doorman.estimation.leaf.numbers import leaf_numbers
from doorman.estimation.leaf.running import LeafRun
from doorman.estimation.status import Status
from doorman.gravity import GRAVITY
from doorman.model import Model

PERIOD, NOISE = 0.008, 1e-3
"""Of the poses [s], and their deviation [m]."""


@pytest.fixture(scope="module")
def model() -> Model:
    return Model("push")


class Flown:
    """A level vehicle with a still arm, whose tip is so far before the closed leaf, and the bank that sees its poses."""

    def __init__(self, model: Model, gap: float) -> None:
        self.model, self.time, self.rng = model, 0.0, np.random.default_rng(3)
        self.arm, closed = model.goal_arm, model.start_state[3]
        self.normal, self.along = np.asarray(model.door.normal(closed)), np.asarray(model.door.leaf_direction(closed))
        self.at = np.asarray(model.coupling.contact_point(closed)) - model.vehicle.tip_position(self.arm)
        self.at = self.at - gap * self.normal
        self.run = LeafRun(model, leaf_numbers(model, NOISE), 0.0, self.at, self.inputs(np.zeros(3)))

    def inputs(self, force: np.ndarray) -> np.ndarray:
        """Rotors that carry the weight, and push [N]."""
        rotors = np.asarray(force) + [0.0, 0.0, self.model.vehicle.mass * GRAVITY]
        return np.concatenate([rotors, np.zeros(9), self.arm, np.zeros(len(self.arm))])

    def pose(self, situation: str = AWAY, force: np.ndarray | float = 0.0, after: float = PERIOD) -> Status:
        self.time += after
        seen = self.at + NOISE * self.rng.normal(size=3)
        return self.run.step(self.time, seen, self.inputs(force * np.ones(3)), situation)

    def hover(self, seconds: float) -> None:
        for _ in range(round(seconds / PERIOD)):
            self.pose()

    def press(self, seconds: float, force: float = 3.0) -> list[Status]:
        return [self.pose(AT_THE_LEAF, force * self.normal) for _ in range(round(seconds / PERIOD))]

    def of(self, part: str) -> tuple[float, float]:
        return getattr(self.run.state, part), getattr(self.run.deviations, part)


def test_a_wind_that_turns_is_foreseen(model):
    """The vehicle stands still in it: what the rotors do against it says how it turns."""
    flown, rate = Flown(model, 0.5), 0.3
    for _ in range(round(8.0 / PERIOD)):
        turned = rate * (flown.time + PERIOD)
        flown.pose(force=-1.2 * np.array([math.cos(turned), math.sin(turned), 0.0]))
    found, deviation = flown.of("wind_turn")
    assert abs(found - rate) < 0.05 and deviation < 0.05
    wind = np.array([flown.run.estimate.outputs[f"wind_{axis}"][0] for axis in "xy"])
    assert np.linalg.norm(wind - 1.2 * np.array([math.cos(turned), math.sin(turned)])) < 0.3


def test_a_closed_leaf_that_nothing_touches_stays_where_it_is_known_to_be(model):
    flown = Flown(model, 0.5)
    before = flown.of("joint")
    flown.hover(6.0)
    assert flown.of("joint") == pytest.approx(before, rel=0.02)


def test_a_new_beginning_forgets_no_score(model):
    flown = Flown(model, 0.5)
    flown.hover(1.0)
    run, jumped = flown.run, np.array([0.3, 0.0, 0.0])
    flown.at += jumped
    flown.pose()
    flown.at -= jumped
    before = run.log_likelihood, run.refused, run.mean_nis
    assert before[0] != 0.0 and before[1] == 1 and 0.5 < before[2] / 3.0 < 2.0
    run.meet(None)
    assert (run.log_likelihood, run.refused, run.mean_nis) == pytest.approx(before)
    flown.hover(0.2)
    assert run.log_likelihood > before[0] and run.refused == 1


def test_a_slip_along_the_face_is_found_soon_and_none_is_invented(model):
    flown, found = Flown(model, 0.0), []
    flown.hover(1.0)
    flown.press(0.5)
    for tick in range(250):
        flown.at = flown.at + (0.1 * PERIOD * flown.along if tick >= 200 else 0.0)
        flown.press(PERIOD)
        outputs = flown.run.estimate.outputs
        found.append(outputs["slip_along"][0] / outputs["slip_along"][1])
    assert np.abs(found[:200]).max() < 5.0
    assert np.argmax(np.array(found[200:]) > 5.0) * PERIOD <= 0.15 and found[-1] > 5.0


def test_a_blow_that_no_gate_passes_is_survived(model):
    """Poses go on elsewhere: not an outlier. The filter begins anew there, and keeps what it knows of the leaf."""
    flown = Flown(model, 0.5)
    flown.hover(1.0)
    flown.at = flown.at - 0.1 * flown.normal
    statuses = [flown.pose() for _ in range(25)]
    assert statuses[0] == Status.REFUSED and statuses.count(Status.LOST) == 1
    assert statuses.index(Status.LOST) * PERIOD < 0.2 and statuses[-1] == Status.OK
    assert np.abs(flown.run.state.position - flown.at).max() < 5.0 * NOISE
    assert flown.run.refused == statuses.index(Status.LOST) + 1
    assert flown.run.log_likelihood > 0.0 and 1.0 < flown.run.mean_nis < 5.0


@pytest.mark.parametrize("gap", [0.5, 0.0])
def test_markers_that_are_swapped_for_a_while_move_nothing(model, gap):
    """3 cm for 0.6 s, in free air and with the tip on the leaf: neither a blow nor a slip."""
    flown, situation, force = Flown(model, gap), AT_THE_LEAF if gap == 0.0 else AWAY, 3.0 if gap == 0.0 else 0.0
    flown.hover(1.0)
    swap, told = np.array([0.015, -0.02, 0.016]), []
    for k in range(200):
        swapped = 80 <= k < 155
        seen = flown.at + swapped * swap + NOISE * flown.rng.normal(size=3)
        flown.time += PERIOD
        position, now = flown.run.unswapped(flown.time, seen)
        status = flown.run.step(flown.time, position, flown.inputs(force * flown.normal), situation)
        told.append((now, status, np.abs(flown.run.state.position - flown.at).max()))
    assert [now for now, _, _ in told] == [80 <= k < 155 for k in range(200)]
    assert {status for _, status, _ in told} == {Status.OK} and max(off for _, _, off in told[20:]) < 6.0 * NOISE


def test_a_frame_that_has_moved_for_good_is_believed_after_a_while(model):
    flown = Flown(model, 0.5)
    flown.hover(1.0)
    flown.at = flown.at + [0.03, 0.0, 0.0]
    for _ in range(round(1.5 / PERIOD)):
        seen = flown.at + NOISE * flown.rng.normal(size=3)
        flown.time += PERIOD
        position, now = flown.run.unswapped(flown.time, seen)
        flown.run.step(flown.time, position, flown.inputs(np.zeros(3)), AWAY)
    assert not now and np.abs(flown.run.state.position - flown.at).max() < 5.0 * NOISE


def test_bad_input_gives_a_status_and_the_filter_goes_on(model):
    flown = Flown(model, 0.5)
    flown.hover(1.0)
    true = flown.at
    flown.at = np.array([math.nan, 0.0, 0.0])
    assert flown.pose() == Status.NOT_FINITE
    flown.at = true
    assert flown.pose(force=math.nan) == Status.NOT_FINITE
    assert flown.pose() == Status.OK
    assert flown.pose(after=60.0) == Status.LOST
    assert flown.pose() == Status.OK
    assert np.isfinite(flown.run.estimate.mean).all() and np.isfinite(flown.run.estimate.deviations).all()


def test_a_leaf_that_breaks_loose_is_known_to_resist_no_more(model):
    """It bore 8 N; then it moves as if nothing but its own inertia held it."""
    flown, force = Flown(model, 0.0), 8.0
    flown.hover(1.0)
    flown.press(2.0, force)
    borne = flown.run.estimate.outputs["borne"][0]
    mass = model.vehicle.mass + model.door.inertia / model.coupling.lever_length**2
    start, broke = flown.at, flown.time
    while flown.time - broke < 0.3:
        flown.at = start + 0.5 * force / mass * (flown.time + PERIOD - broke) ** 2 * flown.normal
        flown.press(PERIOD, force)
    assert borne > 0.9 * force * model.coupling.lever_length
    assert abs(flown.of("resistance")[0]) < 0.15 * borne


def test_a_leaf_that_nobody_has_touched_does_not_move_with_a_tip_in_thin_air(model):
    """The tip comes on at 4 cm/s for 3 cm, in wind of the size of a push: no leaf goes along."""
    flown = Flown(model, 0.06)
    flown.hover(1.0)
    for _ in range(round(0.75 / PERIOD)):
        flown.at = flown.at + 0.04 * PERIOD * flown.normal
        flown.press(PERIOD, 0.0)
    known = flown.run.estimate
    assert known.probabilities["pushing"] < 1e-6
    assert math.degrees(abs(flown.run.state.joint - model.start_state[3])) < 0.3
