"""What tip and leaf may do: one constraint each."""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.estimation.hypothesis import Hypothesis, Row
from doorman.estimation.leaf.motion import LeafMotion

FREE, PUSHING, STANDING, GRIPPED = "free", "pushing", "standing", "gripped"

TOUCHING = (PUSHING, STANDING, GRIPPED)
"""Those in which the tip feels a force."""

_ROUNDING = 0.02
"""Rate below which a free leaf's friction fades [rad/s]: it must not chatter about rest."""


def free(motion: LeafMotion) -> Hypothesis:
    """The tip is not behind the face, and feels nothing; the leaf moves by itself."""
    contact, noise = motion.contact, motion.noise
    slowed = ca.fmax(motion.resistance, 0) * ca.tanh(motion.rate_to_goal / _ROUNDING) / motion.inertia
    return Hypothesis(
        FREE, motion.dynamics(0, -motion.reference.sense * slowed, contact.settles), _noise(motion, 0, noise.rate),
        limits=[Row("outside", motion.gap, contact.inside, contact.lasts)],
    )  # fmt: skip


def pushing(motion: LeafMotion) -> Hypothesis:
    """The tip is on the face and moves with it; it presses and does not pull."""
    contact, force = motion.contact, motion.force_on_moving
    return Hypothesis(
        PUSHING, motion.dynamics(force, motion.pushed(force), contact.friction_lasts), holds=_on_the_face(motion, force),
        limits=[Row("presses", force, contact.pull, contact.lasts)],
    )  # fmt: skip


def standing(motion: LeafMotion) -> Hypothesis:
    """The tip is on a leaf that rests: what it presses with says nothing of the resistance."""
    contact, force = motion.contact, motion.force_on_standing
    return Hypothesis(
        STANDING, motion.dynamics(force, -motion.door_rate / contact.settles, contact.friction_lasts),
        _noise(motion, motion.noise.friction, 0.1 * motion.noise.rate),
        holds=_on_the_face(motion, force), limits=[Row("presses", force, contact.pull, contact.lasts)],
    )  # fmt: skip


def gripped(motion: LeafMotion) -> Hypothesis:
    """The tip's place on the leaf is fixed; it presses or pulls."""
    contact, force = motion.contact, motion.force_on_moving
    slips = ca.vertcat(
        ca.dot(motion.leaf_direction, motion.slip_velocity), ca.dot(motion.leaf.up, motion.slip_velocity)
    )
    return Hypothesis(
        GRIPPED, motion.dynamics(force, motion.pushed(force), contact.friction_lasts),
        holds=[*_on_the_face(motion, force), Row("fixed", slips, contact.gap_rate, contact.lasts)],
    )  # fmt: skip


def switching(motion: LeafMotion, names: tuple[str, ...]) -> dict[tuple[str, str], Any]:
    """Rates among hypotheses: a tip touches where it is near, and a leaf stops or moves on."""
    switch = motion.switch
    touching = [name for name in names if name in TOUCHING]
    closeness = 0.5 * (1 + ca.tanh(2 * (switch.near - motion.gap) / switch.near))
    rates: dict[tuple[str, str], Any] = {}
    for name in touching:
        rates[FREE, name] = (switch.far + switch.make * closeness) / len(touching)
        rates[name, FREE] = switch.lose
        rates.update({(name, other): switch.stop for other in touching if other != name})
    return rates


def noise_of(motion: LeafMotion) -> Any:
    """Noise of a tip that touches."""
    return _noise(motion, motion.noise.friction, motion.noise.rate)


def _noise(motion: LeafMotion, friction: Any, rate: Any) -> Any:
    noise = motion.noise
    return ca.vertcat(
        ca.SX.zeros(3), *[noise.velocity] * 3, *[noise.wind] * 3, 0, rate, noise.resistance, noise.inertia, noise.face,
        friction, friction,
    )  # fmt: skip


def _on_the_face(motion: LeafMotion, force: Any) -> list[Row]:
    """Tip and face touch, as far as the tip's compliance lets them."""
    contact = motion.contact
    return [
        Row("touches", motion.gap + force / contact.stiffness, contact.gap, contact.lasts),
        Row("moves_along", motion.gap_rate, contact.gap_rate, contact.lasts),
    ]
