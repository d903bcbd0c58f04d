"""Scenario: URDFs, contact, start, goal and options of one task, checked when read from TOML.

Every key has a default (the paper's task); an unknown key is an error that names its nearest neighbour. Angles are in rad,
everything else in SI units.
"""

from doorman.scenario.scenario import Scenario
from doorman.scenario.sections.campaign import CampaignSection, Distribution
from doorman.scenario.sections.flight import (
    ContactStateSection,
    ControlSection,
    EstimationSection,
    MissionSection,
    MissionTimeOutsSection,
)
from doorman.scenario.sections.planning import LimitsSection, PlannerSection, PushSection, WeightsSection
from doorman.scenario.sections.reality import RealitySection
from doorman.scenario.sections.safety import SafetySection
from doorman.scenario.sections.simulation import (
    GustSection,
    HandSection,
    NoiseSection,
    SensorsSection,
    SimulationSection,
    WashSection,
)
from doorman.scenario.sections.task import ContactSection, DoorSection, GoalSection, StartSection, VehicleSection

__all__ = [
    "CampaignSection",
    "ContactSection",
    "ContactStateSection",
    "ControlSection",
    "Distribution",
    "DoorSection",
    "EstimationSection",
    "GoalSection",
    "GustSection",
    "HandSection",
    "LimitsSection",
    "MissionSection",
    "MissionTimeOutsSection",
    "NoiseSection",
    "PlannerSection",
    "PushSection",
    "RealitySection",
    "SafetySection",
    "Scenario",
    "SensorsSection",
    "SimulationSection",
    "StartSection",
    "VehicleSection",
    "WashSection",
    "WeightsSection",
]
