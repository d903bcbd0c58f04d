r"""Newtons to the normalised thrust of SET_ATTITUDE_TARGET and back, calibrated in hover.

.. math::
    \frac{f}{f_{max}} = k \tau^2 + (1 - k)\,\tau, \qquad
    f_{max} = \frac{f_{hover}}{k \tau_{hover}^2 + (1 - k)\,\tau_{hover}} \left(\frac{V}{V_{hover}}\right)^n

The shape is that of PX4's `THR_MDL_FAC`: k = 0 where the autopilot linearises the motors itself (a set `THR_MDL_FAC`,
ArduPilot's `MOT_THST_EXPO`), up to 1 where τ is the motors' signal. The factor of the voltage is for autopilots that do not
compensate the battery; n = 2 for a signal that sets the motors' voltage.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Annotated

import numpy as np

from doorman.checks import Range, check_fields
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.sample import VehicleSample
from doorman.hardware.pixhawk.setpoints import AT_REST

_CALM_TILT = math.radians(8.0)
"""Tilt of a vehicle that hovers: its cosine is 1 to a hundredth [rad]."""
_ENOUGH_READINGS = 10


def signal(thrust: float, k: float) -> float:
    """Root u ≥ 0 of k u² + (1 − k) u = τ."""
    linear = 1.0 - k
    return thrust if k < 1e-9 else (math.sqrt(linear * linear + 4.0 * k * thrust) - linear) / (2.0 * k)


@dataclass(frozen=True)
class ThrustCurve:
    """Calibrated map between newtons and normalised thrust."""

    hover_thrust: Annotated[float, Range(0.05, 0.95)]
    """τ in hover, 0 … 1."""
    hover_force: Annotated[float, Range(0.1, 1e4, "N")]
    """Thrust in hover, the weight [N]."""
    shape: Annotated[float, Range(0.0, 1.0)] = 0.0
    """k, 0 where the autopilot linearises the motors, up to 1 where τ is their signal."""
    hover_voltage: Annotated[float, Range(1.0, 1000.0, "V")] | None = None
    """Battery voltage at the calibration [V]; without it, the autopilot compensates the battery."""
    voltage_exponent: Annotated[float, Range(0.0, 4.0)] = 2.0
    """n, 2 for a signal that sets the motors' voltage."""
    min_thrust: Annotated[float, Range(0.0, 1.0)] = 0.02
    """Least τ that is sent: the motors go on turning."""
    max_thrust: Annotated[float, Range(0.0, 1.0)] = 1.0
    """Largest τ that is sent."""

    def __post_init__(self) -> None:
        check_fields(self, "pixhawk.thrust_curve.")
        for name, fits, allowed in (
            ("min_thrust", self.min_thrust <= self.max_thrust, "0 to max_thrust"),
            ("max_thrust", self.max_thrust >= self.hover_thrust, "hover_thrust to 1"),
        ):
            if not fits:
                given = getattr(self, name)
                raise BackendError("out of range", field=f"pixhawk.thrust_curve.{name}", given=given, allowed=allowed)

    def max_force(self, voltage: float = math.nan) -> float:
        """Thrust at τ = 1 [N].

        Args:
            voltage: Battery voltage [V]; NaN or absurd values are not compensated.
        """
        full = self.hover_force / self._relative(self.hover_thrust)
        if self.hover_voltage is None or not 0.5 <= voltage / self.hover_voltage <= 1.5:
            return full
        return full * float((voltage / self.hover_voltage) ** self.voltage_exponent)

    def normalised(self, force: float, voltage: float = math.nan) -> float:
        """Normalised thrust τ for a force.

        Args:
            force: f along the body's z axis [N].
            voltage: Battery voltage [V]; NaN is not compensated.

        Returns:
            τ, cut to `min_thrust` … `max_thrust`.
        """
        thrust = signal(max(0.0, force / self.max_force(voltage)), self.shape)
        return min(max(thrust, self.min_thrust), self.max_thrust)

    def beside(self, force: float, thrust: float, voltage: float = math.nan) -> float:
        """Change of the normalised thrust that a small change of the force takes.

        Args:
            force: The change [N].
            thrust: τ around which it is made, 0 … 1.
            voltage: Battery voltage [V]; NaN is not compensated.
        """
        return force / (self.max_force(voltage) * (2.0 * self.shape * thrust + 1.0 - self.shape))

    def force(self, thrust: float, voltage: float = math.nan) -> float:
        """Force f of a normalised thrust [N].

        Args:
            thrust: τ, 0 … 1.
            voltage: Battery voltage [V]; NaN is not compensated.
        """
        return self._relative(thrust) * self.max_force(voltage)

    def _relative(self, thrust: float) -> float:
        return self.shape * thrust * thrust + (1.0 - self.shape) * thrust


def hover_curve(
    samples: Sequence[VehicleSample], hover_force: float, shape: float = 0.0, compensate_battery: bool = False
) -> ThrustCurve:
    """Curve from what the autopilot commands its mixer while it hovers by itself; readings count that are slow and level."""
    calm = {
        one.thrust_target_time: one
        for one in samples
        if one.armed and one.thrust_target > 0.05 and _speed(one) <= AT_REST and _tilt(one) <= _CALM_TILT
    }.values()
    if len(calm) < _ENOUGH_READINGS:
        raise BackendError(
            "too few calm readings to calibrate hover",
            given=f"{len(calm)}{_restlessness(samples)}",
            allowed=f"at least {_ENOUGH_READINGS} at no more than {AT_REST:g} m/s and {math.degrees(_CALM_TILT):.0f}°",
        )
    voltages = [one.battery.voltage for one in calm if one.battery.voltage > 0.0]
    if compensate_battery and not voltages:
        raise BackendError("the autopilot reports no battery voltage", field="compensate_battery")
    voltage = median(voltages) if compensate_battery else None
    return ThrustCurve(median(one.thrust_target for one in calm), hover_force, shape, voltage)


def _speed(sample: VehicleSample) -> float:
    return math.hypot(*sample.velocity)


def _tilt(sample: VehicleSample) -> float:
    return float(np.abs(sample.attitude[:2]).max())


def _restlessness(samples: Sequence[VehicleSample]) -> str:
    if not samples:
        return ", and no sample"
    speed, tilt = median(map(_speed, samples)), median(map(_tilt, samples))
    return f", at {speed:.2f} m/s and a tilt of {math.degrees(tilt):.0f}°"
