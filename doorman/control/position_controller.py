r"""DOB position controller: from a setpoint to force and attitude.

.. math:: F = m(\ddot p_d + k_d\dot e + k_p e) + m g e_3 + F_R - \hat\delta

with e = p_d − p and F_R the planned force on the door. Along the door's normal δ̂ is left out: there the force is planned, and
what the plan does not know of the door is for the estimate; two observers of one torque fight each other. Tilt and thrust
saturate, and the observer uses the saturated F. Where the setpoint gives a push, it replaces F along the
normal. Beside it friction takes up whatever the tip is pressed with, and the observer's integral would wind up against it: along
the leaf δ̂ stays what it was in free flight, upwards it stays near that. So it does for a tip that grips: arm and hinge carry
whatever the thrust does not, and an integral that takes that for lift leaves them more and more of the weight. Source: Kim,
Choi and Kim, IEEE TCST 2018.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.compilation import entry
from doorman.control.kernels.control_step import (
    Control,
    ControllerInputs,
    ControllerMemory,
    ControllerNumbers,
    Found,
    wanted_force,
)
from doorman.control.observers.disturbance_observer import DisturbanceObserver
from doorman.control.under_way import Later
from doorman.kinematics.vehicles.actuation import Actuation
from doorman.kinematics.vehicles.actuation import attitude_of_force as attitude_of_force
from doorman.kinematics.vehicles.actuation import saturate as saturate
from doorman.numba_types.handles import held
from doorman.one_line import OneLine
from doorman.scenario import ControlSection
from doorman.stored_at_once import stored_at_once

_MOST_LIFT = 0.024
"""By which δ̂ of a tip on the leaf may differ up or down from that of free flight, as a share of the weight: without, one that has
slipped hops, and a vehicle that grips hangs on the handle."""


@stored_at_once
@dataclass(frozen=True, eq=False, repr=False)
class Setpoint(OneLine):
    """Where the vehicle should be and how it should move there, world frame."""

    position: Array
    """P, shape (3,) [m]."""
    velocity: Array
    """Ṗ, shape (3,) [m/s]."""
    acceleration: Array
    """P̈, shape (3,) [m/s²]."""
    yaw: float
    """ψ [rad]."""
    force: Array
    """Planned force of the tip on the door, shape (3,) [N]."""
    normal: Array
    """Unit direction in which the planned force acts and the observer is not heeded, or zero, shape (3,)."""
    arm_rates: Array
    """Ḣ_d, shape (n,) [rad/s]."""
    push: float | None = None
    """Force of the rotors along `normal`, in place of position control there [N]."""
    max_tilt: float | None = None
    """Largest tilt, in place of the settings' [rad]."""
    nudge: Array | None = None
    """Roll and pitch beside what position control asks for, shape (2,) [rad]."""


@stored_at_once
@dataclass(frozen=True, eq=False, repr=False)
class Thrust(OneLine):
    """What the controller asks of the vehicle."""

    thrust: float
    """f_t [N]."""
    attitude: Array
    """Φ_d, shape (3,) [rad]."""
    force: Array
    """Saturated F, shape (3,), world frame [N]."""
    disturbance: Array
    """δ̂, shape (3,), world frame [N]."""
    saturated: bool
    """Whether thrust or tilt was cut."""


class PositionController:
    """Position controller with a disturbance observer: m_A [kg], g [m/s²], largest thrust [N]; by default it tilts its thrust."""

    def __init__(
        self,
        mass: float,
        gravity: float,
        max_thrust: float,
        settings: ControlSection,
        actuation: Actuation | None = None,
    ) -> None:
        self.mass = mass
        self._actuation = actuation or Actuation(max_thrust)
        self.settings = settings
        self.reach = 1.0
        """Share of the largest thrust that the rotors make."""
        self.observer = DisturbanceObserver(mass, settings.observer_rate, settings.observer_damping, settings.max_push)
        self._weight = np.array([0.0, 0.0, mass * gravity])
        numbers = ControllerNumbers(
            mass=mass, weight=mass * gravity, most_lift=_MOST_LIFT * mass * gravity,
            position_gain=settings.position_gain, velocity_gain=settings.velocity_gain,
        )  # fmt: skip
        self._memory, self._inputs, self._found = ControllerMemory(), ControllerInputs(), Found()
        self._control = held(Control(self.observer.memory, numbers, self._memory, self._inputs, self._found))
        self._planned = np.zeros(3)
        """Force of the tip on the door that was planned last."""
        self._want = entry(wanted_force, self._control, 0.0, 0.0, 0.0)

    def update(
        self, position: Array, velocity: Array, setpoint: Setpoint, time_step: float, later: Later | None = None,
        made: Array | None = None,
    ) -> Thrust:  # fmt: skip
        """One period of control, in the world frame; `made` is the rotors' force since the last period [N]."""
        share = 0.0 if setpoint.push is None else 1.0
        wanted_at, wanted_speed = setpoint.position, setpoint.velocity
        if later is not None:
            wanted_at = wanted_at + _beside(setpoint.normal, later.horizon * wanted_speed - later.moved)
            wanted_speed = wanted_speed - _beside(setpoint.normal, later.gained)
        if made is not None:
            self._memory.acting = made - self._weight - self._planned
        self._planned, inputs = setpoint.force, self._inputs
        inputs.vehicle_position, inputs.vehicle_velocity = position, velocity
        inputs.position, inputs.velocity = wanted_at, wanted_speed
        inputs.acceleration, inputs.planned, inputs.normal = setpoint.acceleration, setpoint.force, setpoint.normal
        self._want(self._control, time_step, share, setpoint.push or 0.0)
        wanted, disturbance = self._found.force, self._found.disturbance.copy()
        max_tilt = self.settings.max_tilt if setpoint.max_tilt is None else setpoint.max_tilt
        force = self.reach * self._actuation.within_limits(wanted / self.reach, setpoint.yaw, max_tilt)
        self._memory.acting = force - self._weight - setpoint.force
        return Thrust(
            thrust=math.sqrt(force.dot(force)),
            attitude=self._actuation.attitude(force, setpoint.yaw),
            force=force,
            disturbance=disturbance,
            saturated=max(map(abs, (force - wanted).tolist())) > 1e-9,
        )

    def resume(self, position: Array, velocity: Array, wind: Array) -> None:
        """Begin anew, bumpless, where something else flew the vehicle."""
        self.observer.resume(position, velocity, wind)
        self._memory.acting = self._planned = np.zeros(3)
        self._memory.free = self.observer.estimate


def _beside(normal: Array, way: Array) -> Array:
    """A way along the ground, as thrust has no lag to speak of, without its share along the normal: there the leaf is pushed."""
    (into, along, up), (x, y, _) = normal.tolist(), way.tolist()
    share = into * x + along * y
    return np.array((x - share * into, y - share * along, -share * up))
