"""What tests record, and how two recordings are compared."""

import numpy as np

from doorman.recording import Recording

HEADER = {"scenario": {"door": {"damping": 0.5}, "goal": {"attitude": (0.0, 0.1, -1.2)}}, "seed": 3, "version": "0.1.0"}


def assert_same(left: Recording, right: Recording) -> None:
    assert left.topics == right.topics
    assert left.header == right.header
    for name in left:
        np.testing.assert_array_equal(left[name].time, right[name].time)
        assert list(left[name]) == list(right[name])
        for field, values in left[name].items():
            np.testing.assert_array_equal(values, right[name][field])
            assert values.dtype.kind == right[name][field].dtype.kind
