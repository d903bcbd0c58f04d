r"""The vehicle's attitude loop, by three numbers: its lag τ behind setpoints of roll and pitch, its dead time d, and its shape.

.. math::
    \dot\omega(t) = \kappa_r\big(\kappa_a(\phi_d(t - d) - \phi(t)) - \omega(t)\big), \qquad
    \kappa_a = \frac{1}{\tau}, \qquad \kappa_r = \frac{\varrho}{\tau}

A Pixhawk's with default gains has ϱ = 2.8. One with less overshoots, and gives way to a moment more: its stiffness goes with
ϱ/τ².

The dead time is not lag: until it has passed, nothing happens. Link, estimator and motors of an autopilot make it.

Whole-body plans, the observer of the tilt, look-aheads and the check take what is *believed* of the loop from here. The simulated
loop has the same shape with numbers of its own (`simulation.attitude_lag`).
"""

from __future__ import annotations

from dataclasses import dataclass

USUAL_LAG = 0.1
"""Lag of a Pixhawk with default gains on motors with a lag of 0.03 s [s]."""
USUAL_RATIO = 2.8
"""κ_r by κ_a of a Pixhawk with default gains: 4ζ² with a damping ζ of 0.84."""
_FOLLOWS = 2.5
"""Stiffness by κ_a κ_r: the derivative, which the motors' lag asks for, is in the gain of the rates."""
TESTED_LAG, TESTED_DEAD_TIME = 0.25, 0.1
"""Loops up to these were flown in contact, with what is believed of them measured in hover [s]; docs/decisions/016."""


@dataclass(frozen=True)
class AttitudeLoop:
    """Numbers of the loop."""

    lag: float
    """τ [s]."""
    dead_time: float = 0.0
    """d [s]."""
    feedback: float = 0.0
    """Lag of its feedback, which alone answers a moment, where feed-forward makes it follow commands sooner [s]."""
    ratio: float = USUAL_RATIO
    """ϱ, κ_r by κ_a."""

    @property
    def shaping(self) -> float:
        """Time constant of the low-pass that makes a quicker loop follow commands as its feedback answers a moment [s].

        Plans count on one lag for both. They answer the noise of an estimated force, too: a vehicle that follows at once chatters
        on the leaf, so none is planned with as quicker than the usual one.
        """
        return max(USUAL_LAG - self.lag, self.feedback - self.lag, 0.0)

    def planned(self, time_step: float) -> AttitudeLoop:
        """The loop with shaped commands, as steps of this length can follow it [s]: lag and dead time keep their sum."""
        lag = self.lag + self.shaping
        resolved = max(lag, self.ratio * time_step)
        return AttitudeLoop(resolved, max(self.dead_time + lag - resolved, 0.0), ratio=self.ratio)

    @property
    def quickness(self) -> float:
        """How much quicker it is than the usual one."""
        return USUAL_LAG / self.lag

    @property
    def gain(self) -> float:
        """κ_a: rate of roll and pitch by their error [1/s]."""
        return 10.0 * self.quickness

    @property
    def rate_gain(self) -> float:
        """κ_r of the rate loop with the rotors' lag: angular acceleration by the rate's error [1/s]."""
        return 10.0 * self.ratio * self.quickness

    @property
    def stiffness(self) -> float:
        """Angular acceleration with which it answers an error that stays, per radian [1/s²]."""
        return _FOLLOWS * self.gain * self.rate_gain

    @property
    def acceleration_look_ahead(self) -> float:
        """How much ahead of the state the acceleration that is fed forward is taken from the plan [s]."""
        return 0.12 / self.quickness + self.dead_time

    @property
    def look_ahead(self) -> float:
        """How much ahead of the state yaw and the force that is fed forward are taken from the plan [s]."""
        return 0.2 / self.quickness + self.dead_time
