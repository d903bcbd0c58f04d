"""Scenario: URDFs, contact, start, goal and options of one task, checked when read from TOML.

Every key has a default (the paper's task); an unknown key is an error that names its nearest neighbour. Angles are in rad,
everything else in SI units.
"""

from doorman.scenario.scenario import Scenario
from doorman.scenario.sections.campaign import CampaignSection, Distribution
from doorman.scenario.sections.estimation import EstimationSection
from doorman.scenario.sections.first import FirstSection, TrueJointSection
from doorman.scenario.sections.laboratory import SafetySection
from doorman.scenario.sections.reality import RealitySection
from doorman.scenario.sections.simulation import (
    GustSection,
    HandSection,
    NoiseSection,
    SensorsSection,
    SimulationSection,
    WashSection,
)
from doorman.scenario.sections.task import (
    BesideSection,
    ContactSection,
    DoorSection,
    GoalSection,
    LatchSection,
    MissionSection,
    MissionTimeOutsSection,
    StartSection,
)
from doorman.scenario.sections.vehicle import (
    ControlSection,
    LimitsSection,
    PlannerSection,
    VehicleSection,
    WeightsSection,
)

__all__ = [
    "BesideSection",
    "CampaignSection",
    "ContactSection",
    "ControlSection",
    "Distribution",
    "DoorSection",
    "EstimationSection",
    "FirstSection",
    "GoalSection",
    "GustSection",
    "HandSection",
    "LatchSection",
    "LimitsSection",
    "MissionSection",
    "MissionTimeOutsSection",
    "NoiseSection",
    "PlannerSection",
    "RealitySection",
    "SafetySection",
    "Scenario",
    "SensorsSection",
    "SimulationSection",
    "StartSection",
    "TrueJointSection",
    "VehicleSection",
    "WashSection",
    "WeightsSection",
]
