"""Numbers and arrays from outside: text, bool and complex are none, and the error names the argument."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays, from_dtype, integer_dtypes

from doorman import Planner
from doorman.checks import number, numbers, vector, whole
from doorman.exceptions import DimensionError, DoormanError
from doorman.model import Model

NO_NUMBERS = {
    "text": "1.0", "bytes": b"1", "true": True, "numpy's true": np.True_, "complex": 1.0 + 0.0j,
    "numpy's complex": np.complex64(1), "numpy's text": np.str_("1.0"), "date": np.datetime64("2020-01-01"), "none": None,
    "dictionary": {}, "set": {1.0}, "huge": 10**400, "NaN": math.nan,
}  # fmt: skip
NUMBERS = [0.25, 1, np.float32(0.25), np.float16(0.25), np.longdouble(0.25), np.int8(1), np.uint64(1), Fraction(1, 4),
           np.array(0.25)]  # fmt: skip


@pytest.fixture(scope="module")
def planner(model: Model) -> Planner:
    return Planner(model)


# ---------------------------------------------------------------- checks


@pytest.mark.parametrize("value", NUMBERS, ids=lambda value: type(value).__name__)
def test_numbers_are_taken(value):
    assert number(value, "x") == float(value)
    np.testing.assert_array_equal(vector([value, 2.0], 2, "x"), [float(value), 2.0])
    np.testing.assert_array_equal(vector((value, value), 2, "x"), [float(value)] * 2)


@pytest.mark.parametrize("value", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_what_is_no_number_is_refused_alone_and_in_an_array(value):
    for given_ in (value, [value, 0.0], [0.0, value], np.array([value, value]), np.array([0.0, value], dtype=object)):
        with pytest.raises(DimensionError) as caught:
            vector(given_, 2, "state")
        assert caught.value.field.startswith("state") and caught.value.allowed
    for check in (number, lambda value, field: whole(value, field, 0)):
        with pytest.raises(DimensionError) as caught:
            check(value, "elapsed")
        assert caught.value.field == "elapsed" and caught.value.allowed


@settings(max_examples=30)
@given(st.data())
def test_every_type_of_array_gives_the_same_floats(data):
    kind = data.draw(integer_dtypes() | st.sampled_from(["f2", "f4", "f8", ">f8"]).map(np.dtype))
    entries = {} if kind.kind != "f" else {"allow_nan": False, "allow_infinity": False}
    array = data.draw(arrays(kind, 5, elements=from_dtype(kind, **entries)))
    expected = array.astype(np.float64)
    for given_ in (array, array.tolist(), tuple(array), array[::-1][::-1], np.array(list(array), dtype=object)):
        found = vector(given_, 5, "x")
        np.testing.assert_array_equal(found, expected)
        assert found.dtype == np.float64 and found.flags.c_contiguous and not np.shares_memory(found, array)


def test_ragged_and_endless_lists_are_refused():
    endless: list[object] = [0.0]
    endless.append(endless)
    for given_ in ([[0.0], [0.0, 1.0]], endless, [np.zeros(2), 0.0], "ab", [[["a"]]]):
        with pytest.raises(DimensionError):
            vector(given_, 2, "x")
    assert numbers([[1, 2], [3, 4]], "x").shape == (2, 2)


@pytest.mark.parametrize("value", [0.5, 3.0, np.float64(3.0), "3", True, -1, Decimal(3), None])
def test_a_whole_number_is_an_integer_from_its_least_on(value):
    with pytest.raises(DimensionError, match=r"seed.*>= 0"):
        whole(value, "seed", 0)
    assert whole(np.uint8(3), "seed", 3) == 3


# ---------------------------------------------------------------- what planner and model take


STATE = [0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 1.0, -0.6, -0.4]


def bad_states() -> dict[str, object]:
    states: dict[str, object] = {name: [*STATE[:8], value] for name, value in NO_NUMBERS.items()}
    return states | {"texts": [str(value) for value in STATE], "array of texts": np.array(STATE).astype(str),
                     "complex array": np.array(STATE, dtype=complex), "bools": np.zeros(9, dtype=bool),
                     "one text": "0 0 0 1 0 0 1 0 0", "short": STATE[:8]}  # fmt: skip


@pytest.mark.parametrize("state", bad_states().values(), ids=bad_states())
def test_no_plan_starts_from_what_is_no_state(planner, model, state):
    inputs = model.hover_input
    for use in (planner.plan, planner.replan, model.constraints, model.constraint_jacobian, model.check_state,
                lambda state: model.derivative(state, inputs), lambda state: model.step(state, inputs),
                lambda state: model.step_jacobian(state, inputs)):  # fmt: skip
        with pytest.raises(DimensionError) as caught:
            use(state)
        assert caught.value.field.startswith("state")


@pytest.mark.parametrize("value", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_no_argument_takes_what_is_no_number(planner, model, value):
    state = model.start_state
    uses = {
        "time_limit": [lambda: planner.plan(state, time_limit=value), lambda: planner.replan(state, time_limit=value)],
        "max_iterations": [lambda: planner.plan(state, max_iterations=value)],
        "elapsed": [lambda: planner.replan(state, value)],
        "margin": [lambda: planner.update_margin(value)],
        "door_angle": [lambda: planner.update_goal(value), lambda: model.on_the_way(value)],
        "disturbance": [lambda: planner.update_door(disturbance=value)],
        "damping": [lambda: planner.update_door(damping=value)],
    }
    for field, calls in uses.items():
        for call in calls:
            if value is None and field in ("elapsed", "door_angle", "disturbance", "damping") and call is calls[0]:
                continue  # not given
            with pytest.raises(DoormanError) as caught:
                call()
            assert caught.value.field == field


def test_numpys_numbers_are_numbers_of_the_planner(planner, model):
    state = model.start_state
    plan = planner.plan(state.astype(np.float32), max_iterations=np.int16(50), time_limit=np.float32(5.0))
    assert plan.usable
    planner.update_door(friction=np.float32(0.0), damping=np.int64(0))
    planner.update_margin(np.float32(0.03))
    assert planner.replan(list(state), np.float16(0.0), max_iterations=np.uint8(2)).usable
