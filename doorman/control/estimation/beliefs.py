"""What a flight believes before it has measured anything: deviations, noise and priors of its observers and filters.

They are those of the shipped vehicle before a room door; `Beliefs.of` carries forces to the vehicle, and torques to the hinge.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from doorman.model import Model

VEHICLE_OBSERVER_RATE = 15.0
"""Bandwidth of the observer of velocity and outer force: less is late for the touch, more is noise of poses [rad/s]."""
WIND_RATE = 1.0
"""Bandwidth of the wind's estimate in free flight; in contact the estimate fades to the average of free flight at this rate
[rad/s]."""


@dataclass(frozen=True)
class Beliefs:
    """Prior and noise of the filter of the door. A pair is a mean and a standard deviation."""

    angle_deviation: float = 0.01
    """Of the door's angle at the start [rad]."""
    angle_noise: float = 0.005
    """Of the angle that the tip measures [rad]."""
    push_noise: float = 0.5
    """Density of the push's noise in still air [N s^½]."""
    push_noise_in_wind: float = 0.2
    """Growth of that density with the wind on the vehicle [s^½]."""
    torque_deviation: float = 0.05
    """Of other torques in the hinge, which come and go, in still air [N m]."""
    torque_deviation_in_wind: float = 0.15
    """Growth of that deviation with the wind on the vehicle [m]."""
    torque_time: float = 2.0
    """Correlation time of these torques [s]."""
    leaf_wind: tuple[float, float] = (1.0, 0.5)
    """Wind on the leaf, in the direction of the wind on the vehicle, where there is any [N]."""
    leaf_wind_share: float = 0.7
    """Share by which its mean is nearer to the wind on the vehicle: 0 leaves it, 1 expects the same on both."""
    leaf_wind_deviation: float = 0.25
    """Of the wind on the leaf, in every direction [N]."""
    damping: tuple[float, float] = (0.7, 0.7)
    """b of the hinge; the mean is what `[door]` or the URDF names, if anything [N m s/rad]."""
    friction: tuple[float, float] = (0.8, 0.6)
    """τ_c of the hinge; the mean is what `[door]` or the URDF names, if anything [N m]."""
    stiffness: tuple[float, float] = (0.5, 0.7)
    """k of a closer that is relaxed at the start; the mean is what `[door]` or the URDF names, if anything [N m/rad]."""
    inertia_deviation: float = 0.5
    """Of I_D, as a share of the URDF's."""

    @classmethod
    def of(cls, model: Model) -> Beliefs:
        """Those of a scenario's vehicle and door."""
        usual, hinge = cls(), model.hinge_scale

        def sized(pair: tuple[float, float]) -> tuple[float, float]:
            return hinge * pair[0], hinge * pair[1]

        return replace(
            usual, push_noise=model.scale.force * usual.push_noise, torque_deviation=hinge * usual.torque_deviation,
            damping=sized(usual.damping), friction=sized(usual.friction), stiffness=sized(usual.stiffness),
        )  # fmt: skip


@dataclass(frozen=True)
class ContactThresholds:
    """When the tip counts as pressing on the leaf."""

    touched_above: float = 0.35
    """Estimated normal force above which the tip touches [N]."""
    touched_after: float = 0.06
    """Time above that force after which the tip touches [s]."""
    certain_above: float = 0.2
    """Estimated normal force above which the tip touches at once, if it also exceeds `certain_deviations` [N]."""
    certain_deviations: float = 5.0
    """Number of standard deviations of the same estimate in free flight."""
    arrived_within: float = 0.003
    """Distance from the leaf's believed place within which the tip has arrived [m]."""
    arrived_above: float = 0.12
    """Estimated normal force above which a tip that has arrived touches at once, if it also exceeds `arrived_deviations` [N]."""
    arrived_deviations: float = 1.3
    """Number of the same standard deviations."""
    lost_below: float = 0.08
    """Estimated normal force below which contact is lost [N]."""
    lost_after: float = 0.05
    """Time below that force after which contact is lost [s]."""

    @classmethod
    def of(cls, model: Model) -> ContactThresholds:
        """Those of a scenario's vehicle: forces in proportion to its weight."""
        usual, force = cls(), model.scale.force
        forces = (each.name for each in fields(cls) if each.name.endswith(("_above", "_below")))
        return replace(usual, **{name: force * getattr(usual, name) for name in forces})
