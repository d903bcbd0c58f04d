"""How the attitude follows its setpoints, as a flight measured it in its hover."""

from __future__ import annotations

import numpy as np

from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.recording import Recording


def recorded_loop(recording: Recording) -> AttitudeLoop | None:
    """The mean of both axes; None if the flight measured none."""
    if "attitude_loop" not in recording:
        return None
    found = recording["attitude_loop"]
    return AttitudeLoop(float(np.mean(found["lag"][-1])), float(np.mean(found["dead_time"][-1])))
