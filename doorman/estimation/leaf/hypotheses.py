"""What tip and leaf may do: one constraint each."""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.estimation.hypothesis import Hypothesis, Row
from doorman.estimation.leaf.motion import LeafMotion

FREE, BLOWN, STOPPED, PUSHING, STANDING = "free", "blown", "stopped", "pushing", "standing"
GRIPPED, HOLDING, THROWN = "gripped", "holding", "thrown"

TOUCHING = (PUSHING, STANDING, GRIPPED, HOLDING, THROWN)
"""Those in which the tip is at the leaf."""
RESTING = (STANDING, HOLDING)
"""Those of them in which the leaf does not move."""


def free(motion: LeafMotion) -> Hypothesis:
    """The tip is not behind the face, and feels nothing; the leaf moves by itself."""
    return _free(FREE, motion)


def blown(motion: LeafMotion) -> Hypothesis:
    """The same while the wind jumps, which else passes for one that turns.

    No wind jumps into a frame that a tip feels for, as it may have met that, unless it flies back faster than it bounces.
    """
    into, bounce = motion.frame.normal, 40 * motion.contact.gap_rate
    back = -ca.dot(into, motion.tip_velocity)
    met = 0.5 * (1 - ca.tanh((back - bounce) / motion.contact.gap_rate))
    wind, jump = motion.noise.wind, motion.noise.jump
    return _free(BLOWN, motion, wind + (jump - wind) * (1 - met * into[:2] ** 2))


def stopped(motion: LeafMotion) -> Hypothesis:
    """The tip is on something that does not move, and presses on it; the leaf is as it is without a tip."""
    contact, force, into = motion.contact, motion.force_on_frame, motion.frame.normal
    other = _free(STOPPED, motion)
    speed = ca.sqrt(motion.noise.velocity**2 + (motion.noise.bounce * force / motion.vehicle.mass) ** 2)
    return Hypothesis(
        STOPPED, other.dynamics - motion.column(velocity=force * into / motion.vehicle.mass),
        motion.replaced(other.noise, velocity=ca.repmat(speed, 3, 1)),
        holds=[Row("rests", ca.dot(into, motion.tip_velocity), contact.gap_rate, contact.lasts)],
        limits=[Row("presses", force, contact.pull, contact.lasts)],
    )  # fmt: skip


def _free(name: str, motion: LeafMotion, wind: Any = None) -> Hypothesis:
    contact, noise = motion.contact, motion.noise
    resists = ca.fmax(motion.resistance, 0) / motion.inertia
    moves = ca.tanh(motion.rate_to_goal / (contact.creeps + contact.brakes * resists))
    drawn = noise.drawn * resists * ca.tanh(motion.opening / contact.ajar)
    rate = ca.sqrt((noise.rate * moves) ** 2 + drawn**2)
    return Hypothesis(
        name, motion.dynamics(0, -motion.reference.sense * resists * moves, contact.settles),
        _noise(motion, 0, 0, rate, noise.resistance * moves, wind),
        limits=[Row("outside", motion.gap, contact.inside, contact.lasts)],
    )  # fmt: skip


def pushing(motion: LeafMotion) -> Hypothesis:
    """The tip is on the face and moves with it; it presses and does not pull."""
    contact, force = motion.contact, motion.force_on_moving
    acts = force + motion.blow_on_moving
    return Hypothesis(
        PUSHING, motion.dynamics(acts, motion.pushed(acts), contact.friction_lasts),
        _noise(motion, force, _rubbing(motion, force), motion.noise.rate, _letting_go(motion)),
        holds=_on_the_face(motion, force, motion.gap),
        limits=[Row("presses", force, contact.pull, contact.lasts)],
    )  # fmt: skip


def standing(motion: LeafMotion) -> Hypothesis:
    """The tip is on a leaf that rests: what it presses with says nothing of the resistance."""
    contact, force = motion.contact, motion.force_on_standing
    acts = force + motion.blow_on_standing
    return Hypothesis(
        STANDING,
        motion.dynamics(acts, -motion.door_rate / contact.settles, contact.friction_lasts, motion.stuck(force)),
        _noise(motion, force, _rubbing(motion, force), 0.1 * motion.noise.rate, _giving(motion, force)),
        holds=_on_the_face(motion, force, motion.gap), limits=[Row("presses", force, contact.pull, contact.lasts)],
    )  # fmt: skip


def gripped(motion: LeafMotion) -> Hypothesis:
    """The tip's place on the leaf is fixed; it presses or pulls."""
    contact, force = motion.contact, motion.force_on_moving
    return Hypothesis(
        GRIPPED, motion.dynamics(force, motion.pushed(force), contact.friction_lasts, bears=contact.borne),
        _noise(motion, force, _gripping(motion, force), motion.noise.rate), holds=_in_the_grip(motion, force),
    )  # fmt: skip


def holding(motion: LeafMotion) -> Hypothesis:
    """The tip grips a leaf that rests."""
    contact, force = motion.contact, motion.force_on_standing
    return Hypothesis(
        HOLDING,
        motion.dynamics(
            force, -motion.door_rate / contact.settles, contact.friction_lasts, motion.stuck(force), contact.borne
        ),
        _noise(motion, force, _gripping(motion, force), 0.1 * motion.noise.rate),
        holds=_in_the_grip(motion, force),
    )  # fmt: skip


def thrown(motion: LeafMotion) -> Hypothesis:
    """The tip grips a leaf that a hand or a gust throws or catches, and moves with it."""
    contact, force = motion.contact, motion.force_on_moving
    noise = _noise(motion, force, _gripping(motion, force), motion.noise.throw, speed=motion.noise.thrown_along)
    return Hypothesis(
        THROWN, motion.dynamics(force, motion.pushed(force), contact.friction_lasts, bears=contact.borne), noise,
        holds=_in_the_grip(motion, force),
    )  # fmt: skip


def switching(motion: LeafMotion, names: tuple[str, ...]) -> dict[tuple[str, str], Any]:
    """Rates among hypotheses: a tip touches where it is near, and a leaf stops or moves on. One that rests is met at rest."""
    switch = motion.switch
    touching = [name for name in names if name in TOUCHING and name != THROWN]
    moves = ca.tanh(motion.rate_to_goal / motion.contact.creeps) ** 2
    closeness = 0.5 * (1 + ca.tanh(2 * (switch.near - motion.gap) / switch.near))
    rates: dict[tuple[str, str], Any] = {(FREE, BLOWN): switch.jump, (BLOWN, FREE): switch.calm}
    rates.update({(FREE, STOPPED): switch.far, (STOPPED, FREE): switch.lose})
    reached = ca.fmin(ca.fmax(2 * (1 - motion.gap / switch.reach), 0), 1)
    for name in touching:
        rates[FREE, name] = (switch.far * reached + switch.make * closeness) * (1 - moves if name in RESTING else moves)
        rates[name, FREE] = switch.slip if name in (GRIPPED, HOLDING) else switch.lose
        rates.update({(name, other): switch.stop for other in touching if other != name})
    if THROWN in names:
        rates.update({(name, THROWN): switch.throw for name in (GRIPPED, HOLDING)})
        rates.update({(THROWN, GRIPPED): switch.calm, (THROWN, HOLDING): switch.calm, (THROWN, FREE): switch.slip})
    return rates


def _noise(
    motion: LeafMotion, force: Any, friction: Any, rate: Any, resistance: Any = None, wind: Any = None, speed: Any = None
) -> Any:  # fmt: skip
    noise = motion.noise
    wind = ca.repmat(noise.wind, 2, 1) if wind is None else wind
    if speed is None:
        speed = ca.sqrt(noise.velocity**2 + (noise.bounce * force / motion.vehicle.mass) ** 2)
    return motion.column(
        velocity=ca.repmat(speed, 3, 1), wind=ca.vertcat(wind, noise.draught),
        wind_turn=noise.wind_turn, gust=noise.gust * ca.sqrt(2 / noise.gust_lasts), lift=noise.lift, joint_rate=rate,
        resistance=noise.resistance if resistance is None else resistance, log_inertia=noise.inertia, face=noise.face,
        friction=ca.repmat(friction, 2, 1),
    )  # fmt: skip


def _rubbing(motion: LeafMotion, force: Any) -> Any:
    """Noise with which the tip's friction takes any share of the normal force [N per √s]."""
    contact = motion.contact
    return contact.friction * ca.fmax(force, contact.pull) * ca.sqrt(2 / contact.friction_lasts)


def _gripping(motion: LeafMotion, force: Any) -> Any:
    """The same of a grip, which needs no normal force."""
    return _rubbing(motion, ca.fabs(force) + motion.contact.held * motion.weight)


def _giving(motion: LeafMotion, force: Any) -> Any:
    """Noise of the resistance of a leaf that rests: a seal, a latch or a hand that it bears may give way at once."""
    return motion.noise.resistance + motion.noise.gives * ca.fabs(motion.borne(force))


def _letting_go(motion: LeafMotion) -> Any:
    """The same of a leaf that has just left its stop: what held it lets go within the first degrees, at once or not."""
    near_stop = 1 - ca.tanh(ca.fmax(motion.opening, 0) / motion.contact.ajar)
    return motion.noise.resistance + motion.noise.gives * near_stop * ca.fmax(motion.resistance, 0)


def _in_the_grip(motion: LeafMotion, force: Any) -> list[Row]:
    """The tip does not move on the face."""
    return [
        *_on_the_face(motion, force, motion.gap - motion.reach),
        Row("fixed", motion.slip, motion.contact.slip_rate, motion.contact.lasts),
    ]


def _on_the_face(motion: LeafMotion, force: Any, gap: Any) -> list[Row]:
    """Tip and face keep their distance, as far as the tip's compliance lets them, and have one speed once they have met."""
    contact = motion.contact
    speed = ca.sqrt(contact.gap_rate**2 + motion.meets**2)
    return [
        Row("touches", gap + force / contact.stiffness, contact.gap, contact.lasts),
        Row("moves_along", motion.gap_rate, speed, contact.lasts),
    ]
