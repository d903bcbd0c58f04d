"""Late measurements, gates, bad input, situations: what a filter does in use."""

from __future__ import annotations

import copy
import math

import casadi as ca
import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys
from puck import DEVIATIONS, MEASURED, NUMBERS, START, puck_filter, radar

from doorman.estimation import Filter, Hypothesis, Measurement, Output, ProcessModel, Row, Status
from doorman.exceptions import DoormanError

STEP, U = 0.02, np.array([0.2, 0.1])


def readings(count):
    """Radar readings with stamps between the ticks, of a puck that moves on."""
    rng = np.random.default_rng(5)
    return [
        ((k + 0.6) * STEP, radar(START + STEP * k * np.array([1, 0.1, 0, 0, 0])) + MEASURED * rng.normal(size=2))
        for k in range(count)
    ]


def flown(late, count=60, swap=False):
    """A flight whose readings come so many ticks late; the last ticks bring them all."""
    bank = puck_filter()
    bank.start(0.0, START, DEVIATIONS, inputs=U)
    seen = readings(count)
    for k in range(count + 10):
        come = [seen[i] for i in range(len(seen)) if i + late == k]
        if swap and k % 2 == 0:  # pairs come in the wrong order
            come = [seen[i] for i in (k - late + 1, k - late) if 0 <= i < len(seen) and i % 2 in (0, 1)]
        elif swap:
            come = []
        for time, value in come:
            if time < bank.time + 0.5:
                assert bank.measure("radar", time, value) is Status.OK
        assert bank.step((k + 1) * STEP, U) is Status.OK
    found = bank.estimate()
    numbers = (found.mean, found.covariance, np.array(list(found.probabilities.values())), bank.log_likelihood)
    return b"".join(np.asarray(each).tobytes() for each in numbers), bank.score("radar")


def test_late_readings_leave_the_same_bits_as_those_in_time():
    in_time, score = flown(0)
    assert score.fused == 60
    assert flown(0)[0] == in_time
    for late in (1, 2, 7):
        assert flown(late) == (in_time, score)
    assert flown(4, swap=True) == (in_time, score)


def test_a_late_reading_changes_the_estimate_at_once():
    bank = puck_filter()
    bank.start(0.0, START, DEVIATIONS, inputs=U)
    for k in range(6):
        bank.step((k + 1) * STEP, U)
    before = bank.estimate()
    bank.measure("radar", 0.5 * STEP, radar(START))
    bank.step(7 * STEP, U)
    after = bank.estimate()
    assert after.deviations[0] < 0.5 * before.deviations[0]
    assert bank.score("radar").fused == 1


def test_a_reading_beyond_the_gate_is_refused_and_told_once():
    bank = puck_filter()
    bank.start(0.0, START, DEVIATIONS)
    for k in range(10):
        bank.measure("radar", (k + 1) * STEP, radar(START + (k + 1) * STEP * np.array([1, 0.1, 0, 0, 0])))
        assert bank.step((k + 1) * STEP, (0.0, 0.0)) is Status.OK
    known = bank.estimate()
    bank.measure("radar", 10.5 * STEP, radar(START + np.array([1.5, 1.0, 0, 0, 0])))
    assert bank.step(11 * STEP, (0.0, 0.0)) is Status.REFUSED
    assert bank.estimate().mean[0] == pytest.approx(known.mean[0] + STEP, abs=0.01)
    bank.measure("radar", 10.2 * STEP, radar(START + 10.2 * STEP * np.array([1, 0.1, 0, 0, 0])))
    assert bank.step(12 * STEP, (0.0, 0.0)) is Status.OK
    assert (bank.score("radar").fused, bank.score("radar").refused) == (11, 1)


def test_bad_input_is_told_by_a_status_and_changes_nothing():
    bank = puck_filter()
    bank.start(0.0, START, DEVIATIONS, inputs=U)
    for k in range(40):
        assert bank.step((k + 1) * STEP, U) is Status.OK
    before = bank.estimate()
    now = bank.time
    assert bank.measure("radar", now, [math.nan, 0.0]) is Status.NOT_FINITE
    assert bank.measure("radar", math.nan, [1.0, 0.0]) is Status.NOT_FINITE
    assert bank.measure("radar", 0.0, [1.0, 0.0]) is Status.TOO_OLD
    assert bank.measure("radar", now + 1.0, [1.0, 0.0]) is Status.CLOCK
    assert bank.step(now + STEP, [math.inf, 0.0]) is Status.NOT_FINITE
    assert bank.step(math.inf, U) is Status.NOT_FINITE
    assert bank.step(now, U) is Status.CLOCK
    assert bank.step(now - 1.0, U) is Status.CLOCK
    assert bank.step(now + 100.0, U) is Status.CLOCK
    assert bank.estimate().mean.tobytes() == before.mean.tobytes()
    statuses = [bank.measure("speed", now, [1.0]) for _ in range(100)]
    assert statuses[0] is Status.OK and statuses[-1] is Status.TOO_MANY
    assert bank.step(now + STEP, U) is Status.OK


def test_a_hypothesis_that_loses_its_meaning_is_dropped_and_comes_back():
    bank = puck_filter()
    bank.start(0.0, START, DEVIATIONS, inputs=U)
    bank.step(STEP, U)
    bank.parameters[2] = math.nan
    try:
        assert bank.step(2 * STEP, U) is Status.DROPPED
        found = bank.estimate()
        assert found.probabilities["rail"] == 0.0 and np.isfinite(found.mean).all()
        bank.parameters[2] = NUMBERS[2]
        assert bank.step(3 * STEP, U) is Status.OK
        assert 0.0 < bank.estimate().probabilities["rail"] < 0.1
        bank.parameters[0] = bank.parameters[2] = math.nan
        assert bank.step(4 * STEP, U) is Status.LOST
        assert not bank.running and math.isnan(bank.time)
        assert bank.step(5 * STEP, U) is Status.NOT_STARTED
        assert bank.measure("speed", 5 * STEP, [1.0]) is Status.NOT_STARTED
        with pytest.raises(DoormanError, match="does not run"):
            bank.estimate()
    finally:
        bank.parameters[:] = NUMBERS
    bank.start(0.0, START, DEVIATIONS)
    assert bank.step(STEP, U) is Status.OK


def test_situations_leave_the_hypotheses_that_they_allow():
    bank = puck_filter()
    bank.start(0.0, START, DEVIATIONS, situation="table")
    bank.step(STEP, U)
    assert bank.estimate().probabilities == {"free": 1.0, "rail": 0.0}
    bank.allow("rail")  # which has no chance so far, and begins with what is known
    bank.step(2 * STEP, U)
    assert bank.estimate().probabilities == {"free": 0.0, "rail": 1.0}
    assert bank.estimate().mean[0] == pytest.approx(START[0] + 2 * STEP * START[2], abs=0.01)
    bank.allow("anywhere")
    bank.step(3 * STEP, U)
    assert 0.0 < bank.estimate().probabilities["free"] < 0.1


def test_inputs_that_are_known_late_act_as_if_they_had_been_known():
    bank = puck_filter()
    ends = []
    for known in (U, np.zeros(2)):
        bank.start(0.0, START, DEVIATIONS, inputs=known)
        bank.acted(U)
        bank.step(STEP, U)
        ends.append(bank.estimate().mean)
    assert ends[0].tobytes() == ends[1].tobytes()


def test_a_state_stays_above_its_end():
    bank = puck_filter()
    bank.start(0.0, [*START[:4], -2.999], [*DEVIATIONS[:4], 3.0], situation="table")
    for k in range(20):
        bank.measure("radar", (k + 1) * STEP, radar(START))
        bank.step((k + 1) * STEP, U)
        assert bank.estimate().mean[4] >= -3.0


def test_covariances_stay_symmetric_and_positive_with_hardly_any_noise():
    bank = puck_filter()
    bank.parameters[1] = 1e-9
    try:
        bank.start(0.0, START, 1e4 * DEVIATIONS, situation="table")
        for k in range(300):
            bank.measure("radar", (k + 1) * STEP, radar(START + (k + 1) * STEP * np.array([1, 0.1, 0, 0, 0])))
            bank.measure("speed", (k + 1) * STEP, [1.0])
            assert bank.step((k + 1) * STEP, U) <= Status.REFUSED
            covariance = bank.estimate().covariance
            scale = np.sqrt(np.diag(covariance))
            assert (covariance == covariance.T).all()
            assert np.linalg.eigvalsh(covariance / np.outer(scale, scale)).min() > -1e-9
    finally:
        bank.parameters[1] = NUMBERS[1]


def test_a_tick_allocates_nothing():
    bank, value = puck_filter(), radar(START)
    bank.start(0.0, START, DEVIATIONS)
    for k in range(5):
        bank.step((k + 1) * STEP, U)
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats()
    for k in range(5, 100):
        bank.measure("radar", (k - 3) * STEP, value)
        bank.step((k + 1) * STEP, U)
    assert rtsys.get_allocation_stats() == before


def model():
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    return x, ProcessModel(x, u, ca.vertcat(x[1], u), [0.0, 0.1])


def test_a_hypothesis_that_no_situation_allows_is_named():
    _, process = model()
    with pytest.raises(DoormanError) as error:
        Filter(process, hypotheses=[Hypothesis("free"), Hypothesis("stuck")], allowed={"approach": ["free"]})
    assert error.value.given == "stuck" and error.value.allowed == "free"


@pytest.mark.parametrize(
    "wrong",
    [
        {"switching": {("free", "stuk"): 1.0}},
        {"allowed": {"approach": ["fre"]}},
        {"hypotheses": [Hypothesis("free"), Hypothesis("free")]},
        {"hypotheses": [Hypothesis("free", dynamics=ca.SX.sym("other", 2))]},
        {"hypotheses": [Hypothesis("free", holds=[Row("row", ca.SX.sym("other"), 1.0)])]},
        {"hypotheses": [Hypothesis("not a name")]},
        {"measurements": [Measurement("place", ca.SX.sym("other"), 1.0)]},
        {"measurements": [Measurement("place", ca.SX(2, 1), [1.0, 2.0, 3.0])]},
        {"measurements": [Measurement("place", 0.0, 1.0, under={"gripped": 0.0})]},
        {"outputs": [Output("force", 1.0, under={"gripped": 0.0})]},
        {"parameters": [1.0]},
        {"ticks": 1},
        {"longest_step": 0.0},
    ],
)
def test_misuse_is_an_error_at_construction(wrong):
    _, process = model()
    with pytest.raises(DoormanError):
        Filter(process, **{"hypotheses": [Hypothesis("free"), Hypothesis("stuck")], **wrong})


def test_misuse_of_a_running_filter_is_an_error():
    bank = puck_filter()
    bank.start(0.0, START, DEVIATIONS)
    for wrong in (
        lambda: bank.measure("lidar", 0.01, [1.0]),
        lambda: bank.measure("radar", 0.01, [1.0, 2.0, 3.0]),
        lambda: bank.step(0.01, [1.0]),
        lambda: bank.acted([math.nan, 0.0]),
        lambda: bank.allow("kitchen"),
        lambda: bank.score("lidar"),
        lambda: bank.start(0.0, START[:3], DEVIATIONS),
        lambda: bank.start(0.0, START, -np.eye(5)),
        lambda: bank.start(0.0, START, DEVIATIONS, probabilities={"rial": 1.0}),
    ):
        with pytest.raises(DoormanError):
            wrong()
    with pytest.raises(TypeError):
        copy.deepcopy(bank)
