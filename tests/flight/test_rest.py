"""A landing told from whatever else a vehicle that is down may be: by place, tilt, and what the autopilot says."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.flight.ends import Rest, RestWatch, tells_of_crash
from doorman.hardware.mocap import PoseQuality
from doorman.hardware.safety import Observation
from doorman.hardware.vehicle import Places
from doorman.model import Model
from doorman.scenario import Scenario

MODEL = Model(Scenario.load("paper"))
PLACES = Places.of(MODEL)
DOOR = MODEL.door
SILL = DOOR.hinge_position + np.array([-0.5 * DOOR.frame_depth, 0.5 * DOOR.width, 0.0])
STOOD = 0.31
"""Where the cameras see the vehicle before it flies, whatever the model says [m]."""
PERIOD = 0.02


def at(x: float, y: float, z: float, degrees: float = 1.0, sees: bool = True) -> Observation:
    pose = PoseQuality.MEASURED if sees else PoseQuality.LOST
    return Observation(now=0.0, position=np.array([x, y, z]), speed=0.0, tilt=math.radians(degrees), pose=pose)


PAD = at(PLACES.pad[0], PLACES.pad[1], STOOD)
HOVER = at(PLACES.hover[0], PLACES.hover[1], STOOD + 1.0)
LOW = replace(PAD, position=PAD.position + [0.6, 0.1, 0.02])
"""On the floor, elsewhere."""


def watched(*looks: tuple[Observation, bool, bool], seconds: float = 2.0) -> RestWatch:
    """Each for so long: what is seen, whether motors run, whether it is to come down."""
    watch, now = RestWatch(MODEL), 0.0
    for seen, runs, lands in looks:
        for _ in range(round(seconds / PERIOD)):
            now += PERIOD
            watch.note(replace(seen, now=now), runs, lands)
    return watch


def ended(down: Observation, *, lands: bool = True) -> RestWatch:
    """A flight that came down there."""
    return watched((PAD, False, False), (HOVER, True, False), (down, True, lands), (down, False, lands))


def test_a_vehicle_that_stands_on_the_floor_has_landed_wherever_it_was_to() -> None:
    for place in (PAD, LOW):
        watch = ended(place)
        assert watch.judged is Rest.STANDS and watch.still and not watch.words


def test_a_look_from_the_air_says_nothing_of_one_that_lands_unseen() -> None:
    watch = RestWatch(MODEL, lambda: 9.0)
    for now, seen, runs in ((1.0, PAD, False), (2.0, HOVER, True), (7.9, HOVER, True)):
        watch.note(replace(seen, now=now), runs, True)
    assert watch.judged is Rest.UNSEEN and not watch.words


@pytest.mark.parametrize("degrees", [25.0, 90.0, 180.0])
def test_one_on_its_side_has_crashed(degrees: float) -> None:
    watch = ended(replace(LOW, tilt=math.radians(degrees)))
    assert watch.judged is Rest.TILTED and watch.words
    assert f"{degrees:.0f}°" in watch.words


@pytest.mark.parametrize("height", [0.0, 0.02, 0.4])
def test_one_in_the_doorway_lies_on_the_sill_however_low_that_is(height: float) -> None:
    assert ended(at(SILL[0], SILL[1], STOOD + height, 6.0)).judged is Rest.ON_SILL


def test_one_that_is_held_up_has_not_landed() -> None:
    watch = ended(replace(LOW, position=LOW.position + [0.0, 0.0, 0.15]))
    assert watch.judged is Rest.HELD_UP and f"{STOOD:.2f} m" in watch.words


def test_one_that_came_down_unasked_has_not_landed_although_it_stands() -> None:
    assert ended(LOW, lands=False).judged is Rest.DROPPED


def test_cameras_that_do_not_see_it_or_lie_say_nothing_of_its_place() -> None:
    sill = at(SILL[0], SILL[1], STOOD + 0.4)
    for watch in (ended(replace(sill, pose=PoseQuality.LOST)), ended(replace(sill, pose=None))):
        assert watch.judged is Rest.UNSEEN and not watch.still and not watch.words
    assert ended(replace(sill, divergence=0.3)).judged is Rest.UNSEEN, "the autopilot is elsewhere"
    assert ended(replace(sill, divergence=0.01)).judged is Rest.ON_SILL
    lost_aloft = watched(
        (PAD, False, False), (HOVER, True, False), (replace(HOVER, pose=PoseQuality.LOST), False, True)
    )
    assert lost_aloft.judged is Rest.UNSEEN, "it was 1 m up when it was seen last"


def test_what_leans_in_the_air_or_never_flew_is_no_crash() -> None:
    leaning = replace(HOVER, tilt=math.radians(35.0))
    assert watched((PAD, False, False), (leaning, True, False), (LOW, False, True)).judged is Rest.STANDS
    assert watched((replace(PAD, tilt=1.0), False, False)).judged is Rest.UNSEEN


def test_one_that_moves_is_not_down() -> None:
    watch = watched((PAD, False, False), (HOVER, True, False))
    for step in range(100):
        seen = replace(HOVER, now=4.0 + (step + 1) * PERIOD, position=HOVER.position - [0.0, 0.0, 0.005 * step])
        watch.note(seen, True, True)
    assert not watch.still


@pytest.mark.parametrize("text", ["  3.1 s pixhawk: Crash: Disarming: AngErr=57>30, Accel=0.9<3.0", "Crash detected"])
def test_what_autopilots_say_of_a_crash(text: str) -> None:
    assert tells_of_crash(["taking off", text])


def test_other_words_are_no_crash() -> None:
    assert not tells_of_crash(["PreArm: crash check is on", "landing", ""])
