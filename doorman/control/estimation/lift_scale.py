r"""What the rotors make of a commanded thrust, learnt in free flight.

.. math::
    \dot s = \omega\,\frac{s\,F_{out,z}}{m g}

with the vertical outer force of an observer that believes s f of a command f: what lifts less than it is told sinks, until the
command is 1/s of what is wanted. Hover tells thrust over mass alone: a heavier vehicle needs more of the same. On a real one
the hover measurement has done most of it (`ThrustCurve`); here it goes on as the battery empties, in every phase in which the tip
is free. At the leaf the tip may carry what is missing, so nothing is learnt there.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.signals import Command

Array = NDArray[np.float64]

_RATE = 0.6
"""ω [rad/s]: slower than the disturbance observer, which holds the height meanwhile; 3 s of hover learn most of it."""
_SHORT = 1e-6
"""Share of the weight by which rotors make less than was wanted."""
_LEAST, _MOST = 0.7, 1.3
"""Of s: beyond, it is another vehicle."""


class LiftScale:
    """Scale of the lift in one flight.

    Args:
        weight: m g [N].
        max_thrust: Largest thrust that is commanded [N].
    """

    def __init__(self, weight: float, max_thrust: float) -> None:
        self._weight, self._max_thrust = weight, max_thrust
        self.scale = 1.0
        """s: thrust that a command of one newton makes, as far as the believed mass is right."""

    def learn(self, upwards: float, time_step: float) -> None:
        """Take in what is felt in free flight."""
        share = 1.0 - math.exp(-_RATE * time_step)
        self.scale = min(max(self.scale * (1.0 + share * upwards / self._weight), _LEAST), _MOST)

    def scaled(self, command: Command) -> Command:
        """What to command for a force of the rotors."""
        thrust = self.command(command.thrust)
        if thrust == command.thrust:
            return command
        ahead, left = (side / self.scale for side in command.side_force)
        return Command(thrust, command.attitude, command.arm_rates, command.grip, (ahead, left))

    def made(self, wanted: Command, told: Command) -> Array:
        """What the rotors make of a command, which is less than was wanted where they can do no more."""
        short = self.scale * told.thrust < wanted.thrust - _SHORT * self._weight
        return self.scale * told.body_force if short else wanted.body_force

    @property
    def reach(self) -> float:
        """Share of the largest thrust that the rotors make of the largest command."""
        return min(self.scale, 1.0)

    def command(self, thrust: float) -> float:
        """What to command for a thrust [N]."""
        return min(thrust / self.scale, max(self._max_thrust, thrust))
