"""What to command for a thrust, as the estimate says what the rotors make of a command.

Hover tells thrust over mass alone: a heavier vehicle needs more of the same. On a real one the hover measurement has done most of
it (`ThrustCurve`). As the battery empties it goes on, at the leaf, too: the estimate tells lift from the tip's friction. Only
a gripped leaf may carry what is missing, and the scale stays.
"""

from __future__ import annotations

from dataclasses import replace

from doorman.signals import Command

_LEAST, _MOST = 0.7, 1.3
"""Range of s: beyond, it is another vehicle."""


class LiftScale:
    """Scale of the lift in one flight, up to the largest thrust that is commanded [N]."""

    def __init__(self, max_thrust: float) -> None:
        self._max_thrust = max_thrust
        self.scale = 1.0
        """s: thrust that a command of one newton makes, as far as the believed mass is right."""

    def learn(self, lift: float) -> None:
        """Take in the lift of the rotors beyond their command, as a share of it."""
        self.scale = min(max(1.0 + lift, _LEAST), _MOST)

    def scaled(self, command: Command) -> Command:
        """What to command for a force of the rotors, up to their limit."""
        thrust = min(command.thrust / self.scale, max(self._max_thrust, command.thrust))
        if thrust == command.thrust:
            return command
        ahead, left = command.side_force
        return replace(command, thrust=thrust, side_force=(ahead / self.scale, left / self.scale))
