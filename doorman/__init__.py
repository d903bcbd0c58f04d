"""doorman: aerial manipulators that open hinged doors."""

from doorman.exceptions import DoormanError
from doorman.mission import simulate
from doorman.model import Model
from doorman.ocp.planner import Plan, Planner
from doorman.ocp.solution import PlanStatus
from doorman.recording import Recording
from doorman.scenario import Scenario

__all__ = ["DoormanError", "Model", "Plan", "PlanStatus", "Planner", "Recording", "Scenario", "simulate"]
__version__ = "0.1.0"
