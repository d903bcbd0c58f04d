"""doorman: aerial manipulators that open hinged doors.

A public name brings in its module on its first use, and so does a package, such as `doorman.ocp`: `import doorman`
itself loads nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from doorman.lazy_names import lazy_names

if TYPE_CHECKING:  # the types of the names below; no layer hides an import here
    from doorman.campaign.batch import simulate_batch
    from doorman.exceptions import DoormanError
    from doorman.mission.simulate import simulate
    from doorman.model import Model
    from doorman.ocp.problem.terms import Constraint, Cost, Residual
    from doorman.ocp.solvers.solution import PlanStatus
    from doorman.planning.plan import Plan
    from doorman.planning.planner import Planner
    from doorman.recording import Recording
    from doorman.scenario import Scenario

__all__ = [
    "Constraint", "Cost", "DoormanError", "Model", "Plan", "PlanStatus", "Planner", "Recording", "Residual", "Scenario",
    "simulate", "simulate_batch",
]  # fmt: skip
__version__ = "0.2.0"

_MODULES = {
    "Constraint": "ocp.problem.terms",
    "Cost": "ocp.problem.terms",
    "DoormanError": "exceptions",
    "Model": "model",
    "Plan": "planning.plan",
    "PlanStatus": "ocp.solvers.solution",
    "Planner": "planning.planner",
    "Recording": "recording",
    "Residual": "ocp.problem.terms",
    "Scenario": "scenario",
    "simulate": "mission",
    "simulate_batch": "campaign.batch",
}

_PACKAGES = (
    "campaign", "cli", "collision", "compilation", "control", "door_sensor", "dynamics", "estimation", "exceptions",
    "feasibility", "flight", "hardware", "kinematics", "learning", "mission", "model", "numba_types", "ocp", "planning",
    "postures", "recording", "rig", "ros2", "scenario", "signals", "simulation", "summary", "visualization",
)  # fmt: skip

if not TYPE_CHECKING:  # a type checker would take any name for granted
    __getattr__, __dir__ = lazy_names(__name__, _MODULES, _PACKAGES)
