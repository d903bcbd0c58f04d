"""doorman: aerial manipulators that open hinged doors.

A public name brings in its module when it is first asked for, and so does a package, such as `doorman.ocp`: `import doorman`
itself loads nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the types of the names below; no layer hides an import here
    from doorman.campaign.batch import simulate_batch
    from doorman.exceptions import DoormanError
    from doorman.mission.simulate import simulate
    from doorman.model import Model
    from doorman.ocp.problem.terms import Constraint, Cost, Residual
    from doorman.ocp.solvers.solution import PlanStatus
    from doorman.planning.planner import Plan, Planner
    from doorman.recording import Recording
    from doorman.scenario import Scenario

__all__ = [
    "Constraint", "Cost", "DoormanError", "Model", "Plan", "PlanStatus", "Planner", "Recording", "Residual", "Scenario",
    "simulate", "simulate_batch",
]  # fmt: skip
__version__ = "0.2.0"

_MODULES = {
    "Constraint": "doorman.ocp.problem.terms",
    "Cost": "doorman.ocp.problem.terms",
    "DoormanError": "doorman.exceptions",
    "Model": "doorman.model",
    "Plan": "doorman.planning.planner",
    "PlanStatus": "doorman.ocp.solvers.solution",
    "Planner": "doorman.planning.planner",
    "Recording": "doorman.recording",
    "Residual": "doorman.ocp.problem.terms",
    "Scenario": "doorman.scenario",
    "simulate": "doorman.mission",
    "simulate_batch": "doorman.campaign.batch",
}

_PACKAGES = (
    "campaign", "cli", "collision", "control", "dynamics", "exceptions", "feasibility", "flight", "hardware", "kinematics",
    "learning", "mission", "model", "numba_types", "ocp", "planning", "recording", "rig", "ros2", "scenario", "signals",
    "simulation", "summary", "visualization",
)  # fmt: skip

if not TYPE_CHECKING:  # a type checker would take any name for granted

    def __getattr__(name: str) -> object:
        if name in _PACKAGES:
            return importlib.import_module(f"{__name__}.{name}")  # which makes it an attribute of this one
        if name not in _MODULES:
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'", name=name)
        value = getattr(importlib.import_module(_MODULES[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_PACKAGES})
