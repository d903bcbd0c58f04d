"""A landing told from a crash: by how the vehicle lies, and by what the autopilot says."""

from __future__ import annotations

import math

import pytest

from doorman.flight.watches.rest import RestWatch, tells_of_crash


def watched(*looks: tuple[float, bool]) -> RestWatch:
    watch = RestWatch()
    for degrees, armed in looks:
        watch.note(math.radians(degrees), armed)
    return watch


@pytest.mark.parametrize("degrees", [25.0, 90.0, 180.0])
def test_a_vehicle_on_its_side_after_a_flight_has_crashed(degrees: float) -> None:
    assert watched((2.0, True), (30.0, True), (degrees, False)).lies


def test_one_on_its_legs_has_landed_however_it_leaned_in_the_air() -> None:
    assert not watched((2.0, True), (35.0, True), (4.0, False)).lies


def test_the_last_known_tilt_counts_where_nobody_sees_the_vehicle() -> None:
    assert watched((2.0, True), (60.0, False), (math.nan, False)).lies
    assert not watched((2.0, True), (math.nan, False)).lies


def test_nothing_has_crashed_that_runs_or_never_flew() -> None:
    assert not watched((2.0, True), (60.0, True)).lies
    assert not watched((60.0, False)).lies


@pytest.mark.parametrize("text", ["  3.1 s pixhawk: Crash: Disarming: AngErr=57>30, Accel=0.9<3.0", "Crash detected"])
def test_what_autopilots_say_of_a_crash(text: str) -> None:
    assert tells_of_crash(["taking off", text])


def test_other_words_are_no_crash() -> None:
    assert not tells_of_crash(["PreArm: crash check is on", "landing", ""])
