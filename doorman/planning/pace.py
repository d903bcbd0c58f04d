r"""How fast a leaf is to go: as `goal.duration` asks, and no faster than is safe.

**In the gripper** the leaf goes to the goal with a time constant T: in the cost its rate weighs T² of what its angle weighs. From
rest it is within 2° of the goal after about :math:`D = T\,(1 + \ln(W/2°))` on a way W.

**By a whole-body plan**, from rest, the rate grows by a to ω. With the way s to the goal it is at most

.. math::
    v(s) = \frac{2 s / T}{1 + \sqrt{1 + 2|s|/(b\,T^2)}},

which slows down by b at most, and settles with the time constant T. A tip that is not tied leaves that to the hinge: b is a share
of what resists. A swing of duration D that speeds up for a third of it, and slows down for a third, has ω = 3 W/2 D and
a = 9 W/2 D².
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from doorman.model import Model
from doorman.planning.limits import largest_push

PRESSING, TUGGING = 0.5, 0.9
"""From the touch to the opening, or to the tug by which a gripper is tried, and the tug [s]."""
RESTING = 0.5
"""Force of the shipped vehicle's tip on a leaf that it rests on: above what noise of poses passes for a touch [N]."""
OPEN = math.radians(2.0)
"""A leaf that is so near to the goal is open: there `goal.duration` ends [rad]."""
_SPEEDING_UP = 0.12
"""Share of `control.max_push` that speeds the leaf up. Estimates of what resists need a second to follow: with twice as much they
call a leaf that speeds up free of friction, and the push loses it."""
_SETTLES, _SETTLES_TIED, _SETTLES_HELD = 4.5, 3.0, 6.0
"""Least time constant of a leaf that settles at the goal, pushed, tied, and held by the paper's plan, as a multiple of the
attitude's lag: the tip and the push follow the attitude. Less takes the leaf past the goal."""
_OF_LARGEST, _TIP_SPEED = 0.8, 0.6
"""Share of the largest push or pull that speeds a tied leaf up and slows it down, and the largest speed of the shipped vehicle's
tip [m/s]."""
_IMPACT, STIFFNESS = 15.0, 1500.0
"""Force with which a tip may hit a leaf that something stops, and stiffness of the contact that plans count on, for the shipped
vehicle [N], [N/m]."""
_SLOWING_DOWN, _HARDEST = 5.0 / 6.0, 0.2
"""Share of the largest push or pull that may slow down a held leaf, and how much such a leaf slows down at most, as a
share of W/T²: heavy ones are slower by that."""
_ROUNDED = 0.1
"""Part of b T² over which the profile is rounded where it passes the goal: plans need its slope there."""
_TIME_STEP, LONGEST = 0.01, 600.0
"""Time step of a swing's integration, and the longest swing [s]."""


def time_constant_held(model: Model, safe: bool = False) -> float:
    """T of a leaf in the gripper; the least that is safe, or the one of `goal.duration` [s]."""
    lever, way = model.coupling.lever_length, model.travel.length
    moving = model.door.inertia + model.vehicle.mass * lever**2
    push = _SLOWING_DOWN * lever * largest_push(model, model.largest_tilt)
    by_force = math.sqrt(_HARDEST * way * moving / push) if push > 0.0 else 0.0
    least, duration = max(_SETTLES_HELD * model.scenario.vehicle.attitude_lag, by_force), model.scenario.goal.duration
    if safe or duration == "safe":
        return least
    return max(least, (duration - PRESSING - TUGGING) / _time_constants(model))


def duration_held(model: Model) -> float:
    """Least time from the touch until a leaf in the gripper is open [s]."""
    return PRESSING + TUGGING + time_constant_held(model, safe=True) * _time_constants(model)


def _time_constants(model: Model) -> float:
    """How many of them a leaf takes from rest to the goal."""
    return 1.0 + math.log(max(model.travel.length / OPEN, 1.0))


@dataclass(frozen=True)
class Pace:
    """Bounds of a leaf's motion, in the unit of its joint."""

    rate: float
    """ω [rad/s]."""
    acceleration: float
    """a, and the largest b [rad/s²]."""
    settling: float
    """T [s]."""
    begins: float
    """From the touch until the leaf moves [s]."""

    @classmethod
    def of(cls, model: Model, safe: bool = False) -> Pace:
        r"""Pace of `goal.duration`, or the fastest that is safe.

        A leaf that something stops is hit with the force :math:`v\sqrt{k m}` of a vehicle whose tip has the stiffness k [N/m] and
        the speed v; the impact that is allowed bounds ω. The push bounds a.
        """
        lever, mass, scale, contact = model.coupling.lever_length, model.vehicle.mass, model.scale, model.contact
        meets = _IMPACT * scale.force / math.sqrt(STIFFNESS * scale.stiffness * mass)
        rate = contact.between(meets, _TIP_SPEED * scale.speed) / lever
        largest = largest_push(model, model.largest_tilt)
        force = contact.between(_SPEEDING_UP * model.scenario.control.max_push, _OF_LARGEST * largest)
        acceleration, begins = force * lever / (model.door.inertia + mass * lever**2), PRESSING + contact.tied * TUGGING
        duration, way = model.scenario.goal.duration, model.travel.length
        if not safe and duration != "safe":
            swings = max(duration - begins, _TIME_STEP)
            rate, acceleration = min(rate, 1.5 * way / swings), min(acceleration, 4.5 * way / swings**2)
        settling = contact.between(_SETTLES, _SETTLES_TIED) * model.scenario.vehicle.attitude_lag
        return cls(rate, acceleration, settling, begins)

    def duration(self, way: float, deceleration: float) -> float:
        """Time from the touch until a leaf is open, with the largest deceleration that the hinge allows [s]."""
        time, rate, slows = self.begins, 0.0, min(deceleration, self.acceleration)
        while way > OPEN and time < LONGEST:
            rate = min(rate + self.acceleration * _TIME_STEP, self.rate)
            way -= _TIME_STEP * rate_to_goal(way, rate, slows, self.settling)
            time += _TIME_STEP
        return time


def rate_to_goal(left: Any, fastest: Any, deceleration: Any, settling: Any) -> Any:
    """v(s) below ω, in numbers or symbols; see above. The smaller of the two is rounded."""
    length = deceleration * settling**2
    way = (left**2 + (_ROUNDED * length) ** 2) ** 0.5
    slows = 2 * left / settling / (1 + (1 + 2 * way / length) ** 0.5)
    return slows * fastest / (slows**4 + fastest**4 + 1e-12) ** 0.25
