"""The leaf's own angle, as a sensor of the door measures it, and what a recording holds of it."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.recording import Recording

LEAF = "leaf"
"""Name of the measurement: q at its own time. A gap that it tells is no contact, for tip and face keep their distance in one."""


def recorded_readings(recording: Recording) -> Array:
    """Readings that were believed, each once: when it came and was true [s], q [rad] and its deviation, shape (k, 4)."""
    if "door_sensor" not in recording:
        return np.empty((0, 4))
    sensed = recording["door_sensor"]
    new = np.concatenate([[True], np.diff(sensed["leaf_time"]) > 0.0]) & sensed["believed"].astype(bool)
    rows = np.column_stack([sensed.time, sensed["leaf_time"], sensed["door_angle"], sensed["deviation"]])[new]
    return np.asarray(rows[np.isfinite(rows).all(axis=1)])
