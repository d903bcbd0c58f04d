"""What is done before the task itself, with the handle: a lever turned, and held while the door is moved."""

from __future__ import annotations

from doorman.scenario.sections.task import ContactSection, DoorSection, GoalSection
from doorman.scenario.values import NonNegative, Section


class TrueJointSection(Section):
    """The simulated joint, where it differs from the planner's."""

    damping: NonNegative | None = None
    """b [N m s/rad, or N s/m]. Default: the planner's."""
    friction: NonNegative | None = None
    """τ_c [N m, or N]. Default: the planner's."""
    stiffness: NonNegative | None = None
    """k [N m/rad, or N/m]. Default: the planner's."""
    preload: NonNegative | None = None
    """τ_p [N m, or N]. Default: the planner's."""


class FirstSection(Section):
    """One step: a goal on a joint of the door's URDF, and the contact with which it is moved.

    The next step begins where this one ends, with the tip still on the handle.
    """

    door: DoorSection
    """Its joint and link, and the torques in it; the URDF is that of the door."""
    contact: ContactSection = ContactSection()
    """Where the tip grips it."""
    goal: GoalSection
    """How far it is moved."""
    true: TrueJointSection = TrueJointSection()
    """What the simulated joint has."""
