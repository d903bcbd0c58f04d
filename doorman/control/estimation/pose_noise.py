r"""How noisy poses may be: what noise makes the vehicle press or draw back with must be less than what it presses with.

The filter at the leaf takes in positions with white noise σ_p every T, t after they were true. Rough air and errors of thrust
change the vehicle's velocity by q in a second. Of such a filter in its steady state, and of what t adds,

.. math:: \sigma_v^2 = \sqrt 2\, q^{3/2} \big(\sigma_p^2 T\big)^{1/4} + q^2 t

is the variance of the velocity (Kalman and Bucy 1961). The position loop turns the velocity's error into force at its crossover
ω_c. So the force at the tip is wrong by

.. math:: \sigma_F = m\,\omega_c\,\sigma_v .

A tip that presses with F leaves the leaf where the error is larger: :math:`F \ge 4\sigma_F` keeps it there.
"""

from __future__ import annotations

import math

from doorman.control.estimation.pose_age import crossover
from doorman.estimation.leaf.constants import CONSTANTS
from doorman.model import Model
from doorman.planning.whole_body.numbers import whole_body_numbers

_SIGMAS = 4.0
"""F in deviations of its error."""


def velocity_noise(position_noise: float, latency: float, interval: float, rough: float) -> float:
    """σ_v of a filter that counts on rough air of `rough`, q."""
    steady = math.sqrt(2.0) * rough**1.5 * (position_noise**2 * interval) ** 0.25
    return math.sqrt(steady + rough**2 * latency)


def force_noise(model: Model, position_noise: float, latency: float, interval: float) -> float:
    """σ_F of a tip that presses."""
    rough = model.ratios["speed"] * CONSTANTS["noise.velocity"][0]
    speed = velocity_noise(position_noise, latency, interval, rough)
    return model.vehicle.mass * crossover(model.scenario.control) * speed


def most_force_noise(model: Model) -> float:
    """σ_F up to which a tip stays on the leaf that presses as lightly as plans let it [N]; a tied one stays there."""
    return math.inf if model.contact.tied > 0.0 else whole_body_numbers(model).one("reference.least_force") / _SIGMAS
