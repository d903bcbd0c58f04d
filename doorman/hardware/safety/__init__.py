"""Safety supervisor: watches the flight independently of planner and controller, and takes the vehicle from them."""

from doorman.hardware.safety.observer import Observer
from doorman.hardware.safety.rules import RULES, Action, Assessor, Fault, Finding, Observation, Rule
from doorman.hardware.safety.supervisor import Supervisor

__all__ = ["RULES", "Action", "Assessor", "Fault", "Finding", "Observation", "Observer", "Rule", "Supervisor"]
