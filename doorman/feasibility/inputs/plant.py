"""Finding of the simulator: MuJoCo builds vehicle and door, or says what it refuses."""

from __future__ import annotations

import importlib.util

from doorman.exceptions import BackendError
from doorman.feasibility.report import Finding, Severity
from doorman.model import Model

_NAME = "simulator"


def plant_findings(model: Model) -> list[Finding]:
    """Whether MuJoCo builds the plant of a flight, by the rules that `open` and `simulate` meet."""
    if importlib.util.find_spec("mujoco") is None:
        return [
            Finding(
                _NAME, Severity.WARNING, "not checked: MuJoCo is not installed, and 0 of 2 URDFs were built", 0.0, 2.0, "URDFs",
                "install the extra `sim`",
            )
        ]  # fmt: skip
    from doorman.simulation import SimulatedBackend

    backend = SimulatedBackend(model)
    try:
        backend.open()
        backend.read()
    except BackendError as error:
        return [
            Finding(
                _NAME, Severity.ERROR, f"MuJoCo cannot build 1 of the 2 URDFs: {error}", 1.0, 0.0, "URDFs",
                "change what the message names",
            )
        ]  # fmt: skip
    finally:
        backend.stop()
    return [Finding(_NAME, Severity.OK, "MuJoCo builds 2 of 2 URDFs, vehicle and door", 0.0, 0.0, "URDFs")]
