"""Finding of the simulator: MuJoCo builds vehicle and door, or says what it refuses."""

from __future__ import annotations

import importlib.util

from doorman.exceptions import BackendError
from doorman.feasibility.report import Finding, Severity, found
from doorman.model import Model


def plant_finding(model: Model) -> Finding:
    """Whether MuJoCo builds the plant of a flight, by the rules that `open` and `simulate` meet."""
    if importlib.util.find_spec("mujoco") is None:
        message = "not checked: MuJoCo is not installed, and 0 of 2 URDFs were built"
        return found("simulator", False, message, 0.0, 2.0, "URDFs", "install the extra `sim`", Severity.WARNING)
    from doorman.simulation import SimulatedBackend

    backend, failure = SimulatedBackend(model), ""
    try:
        backend.open()
        backend.read()
    except BackendError as error:
        failure = f"MuJoCo cannot build 1 of the 2 URDFs: {error}"
    finally:
        backend.stop()
    message = failure or "MuJoCo builds 2 of 2 URDFs, vehicle and door"
    return found("simulator", not failure, message, float(bool(failure)), 0.0, "URDFs", "change what the message names")
