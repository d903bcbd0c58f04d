"""Banks of one kind of task: printed once in a process, each with numbers and a memory of its own."""

from __future__ import annotations

import numpy as np

from doorman import Model, Scenario
from doorman.estimation.estimate import FilterEstimate
from doorman.estimation.filter import Filter
from doorman.estimation.leaf.kernels.report import LeafReport
from doorman.estimation.leaf.leaf_filter import GAINS, SLIPS, WINDS, leaf_filter
from doorman.estimation.leaf.numbers import PLACES, first_state, leaf_numbers, part


def bank_of(damping: float) -> tuple[Filter, np.ndarray, np.ndarray]:
    model = Model(Scenario.load("push", {"door.damping": damping, "goal.door_angle": f"{60 + damping:g} deg"}))
    numbers = leaf_numbers(model, 1e-3)
    mean, deviations = first_state(model, numbers, model.hover_offset)
    return leaf_filter(model, numbers), mean.floats, deviations.floats


def flown(bank: Filter, mean: np.ndarray, deviations: np.ndarray) -> FilterEstimate:
    bank.start(0.0, mean, deviations)
    inputs = np.concatenate([[0.0, 0.0, 28.0], np.zeros(bank._memory.coming.size - 3)])
    for tick in range(1, 40):
        bank.measure("pose", 0.004 * tick, mean[:3] + 1e-3 * tick)
        bank.step(0.004 * tick, inputs)
    return bank.estimate()


def test_a_bank_knows_nothing_of_another_of_its_kind() -> None:
    first, *start = bank_of(0.5)
    alone = flown(first, *start)
    second, *other_start = bank_of(2.0)
    flown(second, *other_start)
    again, *start = bank_of(0.5)
    assert not again.running
    found = flown(again, *start)
    np.testing.assert_array_equal(found.report, alone.report)
    np.testing.assert_array_equal(first.estimate().report, alone.report)
    assert first.parameters.size == second.parameters.size and (first.parameters != second.parameters).any()


def test_what_it_tells_is_read_by_name() -> None:
    bank, *start = bank_of(0.5)
    found = flown(bank, *start)
    report = LeafReport.of(found)
    for record, expected in ((report.state, found.mean), (report.deviations, found.deviations)):
        np.testing.assert_array_equal(record.floats, expected)
        np.testing.assert_array_equal(record.velocity, expected[PLACES["velocity"]])
        assert [record.joint] == part(expected[None], "joint").tolist() == expected[PLACES["joint"]].tolist()
    outputs = {name: value for name, (value, _) in found.outputs.items()}
    assert report.outputs.normal_force == outputs["normal_force"] and report.outputs.borne == outputs["borne"]
    for field, names in (("wind", WINDS), ("slip", SLIPS), ("gains", GAINS)):
        assert getattr(report.outputs, field).tolist() == [outputs[name] for name in names]
    assert report.outputs.floats.size == len(outputs) and report.chances.tolist() == list(found.probabilities.values())
