"""Records: the same named fields in kernels and in Python."""

import pickle
from typing import Any, NamedTuple, cast

import numpy as np
import pytest

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.handles import held, separate
from doorman.numba_types.records import Record, Vector3


class Memory(Record):
    """What the test's kernel remembers."""

    sum: float
    force: Vector3
    calls: int
    full: bool


class Work(NamedTuple):
    """What the test's kernel works on."""

    memory: Memory
    values: Array


@kernel
def add(memory: Memory, values: Array) -> None:
    """Sum up values, and count the calls."""
    memory.calls += 1
    for k in range(3):
        memory.sum += values[k]
        memory.force[k] = memory.sum
    memory.full = not memory.full and memory.sum > 20.0


@kernel
def add_held(work: Work) -> float:
    """The same, of a handle."""
    add(work.memory, work.values)
    return work.memory.sum


VALUES = np.array([1.0, 2.0, 4.0])


def test_a_kernel_writes_what_python_reads() -> None:
    memory = Memory(sum=1.0)
    add(memory, VALUES)
    memory.sum += 10.0
    add(memory, VALUES)
    assert memory.sum == 25.0 and memory.calls == 2 and type(memory.calls) is int and memory.full is True
    np.testing.assert_array_equal(memory.force, [19.0, 21.0, 25.0])


def test_a_handle_shares_its_record() -> None:
    memory = Memory()
    work = held(Work(memory, VALUES))
    assert add_held(work) == 7.0 and add_held(work) == 14.0
    assert memory.sum == 14.0 and memory.calls == 2


def test_copies_have_memory_of_their_own() -> None:
    memory = Memory(sum=3.0)
    memory.force[:] = VALUES
    for copy in (memory.copy(), pickle.loads(pickle.dumps(memory)), separate(Work(memory, VALUES)).memory):
        assert copy.sum == 3.0
        np.testing.assert_array_equal(copy.force, VALUES)
        copy.sum, copy.force[1] = 5.0, 0.0
        assert memory.sum == 3.0 and memory.force[1] == 2.0


def test_the_plain_function_sees_the_same_fields() -> None:
    compiled, plain = Memory(sum=0.5), Memory(sum=0.5)
    add(compiled, VALUES)
    cast(Any, add).py_func(plain, VALUES)
    assert compiled.memory == plain.memory


def test_a_record_over_an_array_shares_its_numbers() -> None:
    numbers = np.arange(6.0)
    memory = Memory.over(numbers)
    assert memory.sum == 0.0
    np.testing.assert_array_equal(memory.force, [1.0, 2.0, 3.0])
    numbers[1] = 7.0
    add(memory, VALUES)
    assert memory.force[0] == 1.0 and numbers[0] == memory.sum == 7.0
    with pytest.raises(TypeError):
        Memory.over(numbers[:4])
    numbers.flags.writeable = False
    with pytest.raises(TypeError):
        Memory.over(numbers)


def test_a_record_takes_the_values_of_another() -> None:
    memory, other = Memory(sum=2.0, calls=3), Memory()
    other.assign(memory)
    memory.calls = 4
    assert other.sum == 2.0 and other.calls == 3


def test_a_snapshot_keeps_the_values() -> None:
    memory = Memory(sum=2.0, calls=3)
    memory.force[:] = VALUES
    snapshot = memory.snapshot()
    memory.sum, memory.force[1], memory.calls = 5.0, 0.0, 4
    assert snapshot.sum == 2.0 and snapshot.calls == 3 and type(snapshot.calls) is int
    np.testing.assert_array_equal(snapshot.force, VALUES)
