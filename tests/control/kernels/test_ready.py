"""Kernels that a flight calls late are compiled when their owners are made: nothing waits for them in the air."""

import subprocess
import sys

_FLOWN = """
import numpy as np
from doorman.compilation import kernel_counts
from doorman.control.observers.disturbance_observer import DisturbanceObserver
observer = DisturbanceObserver(3.0, 2.0)
before, up = kernel_counts(), np.array([0.0, 0.0, 1.0])
observer.align(up, up, up)
print(kernel_counts() == before)
"""


def test_no_kernel_is_made_in_flight() -> None:
    ran = subprocess.run([sys.executable, "-c", _FLOWN], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "True"
