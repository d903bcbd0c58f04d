r"""Hand: a person who takes the leaf once in a flight, holds it with bounded force or shoves it, and lets go.

Where the leaf first is at or below `door_angle`, at :math:`\alpha_h`, the hand comes for `duration` and turns the hinge by

.. math::
    \tau = \tau_{shove} - \tau_{hold}\,\mathrm{sat}\Big(\frac{\alpha - \alpha_h}{a} + \frac{\dot\alpha}{b}\Big),
    \qquad \mathrm{sat}(s) = \min(\max(s, -1), 1) .

It gives way by a at its largest torque, and beyond that by whatever it takes.
"""

from __future__ import annotations

from doorman.scenario import HandSection
from doorman.simulation.simulator import Disturbance

_GIVES_WAY = 0.005
"""a: about 3 mm at the usual lever, as fingers do [rad]."""
_RATE = 0.05
"""b: damps a leaf of 5 kg m² held with 10 N m as 0.8 of critically [rad/s]."""


class Hand:
    """Hand of one flight."""

    def __init__(self, section: HandSection) -> None:
        self._section = section
        self._came: tuple[float, float] | None = None

    def at(self, time: float, door_angle: float, door_rate: float) -> Disturbance:
        """Torque at one time."""
        section = self._section
        if self._came is None and section.door_angle is not None and door_angle <= section.door_angle:
            self._came = time, door_angle
        if self._came is None or time >= self._came[0] + section.duration:
            return Disturbance()
        away = (door_angle - self._came[1]) / _GIVES_WAY + door_rate / _RATE
        return Disturbance(hinge_torque=section.shove - section.hold * min(max(away, -1.0), 1.0))
