r"""Findings of a tip that presses on a lever, a knob or a valve: friction keeps it there, and holds what it holds.

The vehicle presses plumb. Where the lever slopes by θ, a force λ across it comes with :math:`\lambda\tan\theta` along it, which
friction bears up to :math:`\mu\lambda`; the vehicle takes off what its yaw torque makes at the tip.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.feasibility.report import Finding, found
from doorman.feasibility.swing.geometry import force_needed, yaw_force
from doorman.model import Model
from doorman.planning.pace import RESTING

_ALONG_THE_WAY = 15
"""Angles at which the slope is looked at."""


def slip_findings(model: Model) -> list[Finding]:
    """Whether friction keeps the tip on the slope of a lever that it presses on."""
    if model.contact.tied > 0.0 or not model.door.in_plane:
        return []
    friction, way = model.scenario.contact.friction, np.linspace(model.travel.start, model.travel.goal, _ALONG_THE_WAY)
    aside = yaw_force(model)
    needed, angle = max(
        (max(_along(model, angle) - aside, 0.0) / _across(model, angle), angle) for angle in way.tolist()
    )
    slope = math.degrees(math.acos(min(abs(float(model.door.normal(angle)[2])), 1.0)))
    return [found(
        "friction at the lever", needed <= friction,
        f"at {model.door.in_words(angle)} the lever slopes by {slope:.0f}°: a tip that presses on it needs a friction of "
        f"{needed:.2f}, and contact.friction is {friction:.2f}",
        needed, friction, "", 'choose a goal or a contact where the lever lies flatter, or contact.kind = "grip"',
    )]  # fmt: skip


def hold_findings(step: Model, following: Model) -> list[Finding]:
    """A lever that is pressed springs back as the tip leaves: what friction holds of what the next step needs."""
    if step.contact.tied > 0.0:
        return []
    angle, joint = step.goal_angle, following.door.section.hinge
    across, along, needed = _across(step, angle), _along(step, angle), force_needed(following)
    left = math.sqrt(max((step.scenario.contact.friction * across) ** 2 - along**2, 0.0))
    return [found(
        "hold", False,
        f"the tip would press on the lever with {across:.1f} N and be kept by friction alone, which leaves "
        f"{left:.1f} N for '{joint}' of {needed:.1f} N that it needs; plans do not rely on that",
        left, needed, "N", 'hold the lever for the next step: contact.kind = "grip"',
    )]  # fmt: skip


def _across(model: Model, angle: float) -> float:
    """Force across the lever that turns it, by the plant's friction, no less than that of a tip that rests [N]."""
    resists = model.travel.ahead(model.door.hinge_torque(angle, 0.0)) + model.friction.largest
    return max(resists / model.coupling.lever_length, RESTING * model.scale.force)


def _along(model: Model, angle: float) -> float:
    """Force along the lever of a plumb force that turns it [N]."""
    upright = abs(float(model.door.normal(angle)[2]))
    return _across(model, angle) * math.sqrt(max(1.0 - upright**2, 0.0)) / max(upright, 1e-3)
