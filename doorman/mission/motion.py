"""Smooth reference motions in free flight: to the door, and back out of the doorway."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.doorway import Doorway
from doorman.control.position_controller import Setpoint
from doorman.control.state_converter import StateConverter
from doorman.mission.schedule import TimedPlan
from doorman.model import Model

Array = NDArray[np.float64]

_ACCELERATION = 0.25
"""Of a reference motion [m/s²]."""
_YAW_RATE = 0.4
"""[rad/s]."""
_ARM_GAIN = 2.0
_ARM_RATE = 0.5
"""Of the arm in free flight [1/s], [rad/s]."""
_ROOM = 0.05
"""Between disc and jambs on the way out [m]."""
_BACK = 0.25
"""Way straight back from the leaf before the way out [m]."""


class Glide:
    """Reference that moves to targets with bounded speed and acceleration.

    Args:
        position: Where it starts, at rest, shape (3,), world frame [m].
        yaw: ψ [rad].
    """

    def __init__(self, position: Array, yaw: float) -> None:
        self.position = position.copy()
        self.velocity = np.zeros(3)
        self.yaw = yaw

    def to(self, target: Array, yaw: float, speed: float, arm_rates: Array, time_step: float) -> Setpoint:
        """Advance by one period towards a target.

        Args:
            target: Shape (3,), world frame [m].
            yaw: ψ there [rad].
            speed: Largest [m/s].
            arm_rates: Ḣ_d, shape (n,) [rad/s].
            time_step: [s].

        Returns:
            The setpoint.
        """
        away = target - self.position
        distance = float(np.linalg.norm(away))
        wanted = np.zeros(3)
        if distance > 1e-9:
            wanted = min(speed, math.sqrt(_ACCELERATION * distance), 2.0 * distance) / distance * away
        change = wanted - self.velocity
        size = float(np.linalg.norm(change))
        if size > _ACCELERATION * time_step:
            change *= _ACCELERATION * time_step / size
        self.velocity = self.velocity + change
        self.position = self.position + time_step * self.velocity
        self.yaw += float(np.clip(yaw - self.yaw, -_YAW_RATE * time_step, _YAW_RATE * time_step))
        acceleration = change / time_step if time_step > 0.0 else np.zeros(3)
        none = np.zeros(3)
        return Setpoint(self.position.copy(), self.velocity.copy(), acceleration, self.yaw, none, none, arm_rates)

    def near(self, target: Array, tolerance: float) -> bool:
        """Whether the reference has come this near to a target [m]."""
        return bool(np.linalg.norm(target - self.position) < tolerance)


def arm_rates_to(target: Array, arm_angles: Array) -> Array:
    """Joint rates towards a posture on the straight line, which a saturated joint would leave, shape (n,) [rad/s]."""
    rates = _ARM_GAIN * (target - arm_angles)
    return np.asarray(rates * min(1.0, _ARM_RATE / max(float(np.abs(rates).max()), 1e-9)))


def in_the_doorway(model: Model, position: Array) -> bool:
    """Whether some of the rotor disc is between the jambs, where a leaf that shuts reaches it.

    Args:
        model: Model of the scenario.
        position: P, shape (3,), world frame [m].
    """
    before = model.door.in_doorway(position - model.door.hinge_position)[0]
    return bool(
        model.door.upright and model.door.side == "push" and before > -model.door.frame_depth - model.vehicle.radius
    )


def planned_speed_back(converter: StateConverter, current: TimedPlan | None, now: float) -> float:
    """Speed with which a plan draws the tip back along the leaf's normal [m/s].

    Args:
        converter: The state converter.
        current: The plan that is followed.
        now: [s].
    """
    rate = 0.0 if current is None else converter.door_rate(current.plan, now - current.start)
    return max(0.0, converter.model.coupling.lever_length * rate)


def way_out(model: Model, position: Array, door_angle: float) -> list[Array]:
    """Way from the leaf to a hover outside: straight out between the jambs, and back from the leaf first before the doorway.

    A vehicle that pulls goes back along the leaf's normal to where the leaf, however it swings, does not reach it. One that has
    moved a slide or a hatch goes back along the normal of its face.

    Args:
        model: Model of the scenario.
        position: P, shape (3,), world frame [m].
        door_angle: α [rad].

    Returns:
        Targets of O_B, each of shape (3,), world frame [m].
    """
    if not model.door.upright:
        return [position - model.scenario.mission.hover_distance * model.door.normal(door_angle)]
    if model.door.side == "pull":
        return _out_of_swing(model, position, door_angle)
    door, doorway = model.door, Doorway(model, margin=_ROOM)
    outside = -model.vehicle.radius - model.scenario.mission.hover_distance

    def placed(components: Array) -> Array:
        return door.hinge_position + door.from_doorway(components)

    into, _, up = door.in_doorway(position - door.hinge_position)
    if in_the_doorway(model, position):
        # away from the hinge, where a leaf that shuts comes from
        beside = 0.5 * (doorway.middle + max(doorway.highest, doorway.middle))
        out, beyond = placed(np.array([outside, beside, up])), doorway.beyond(position)
        if door.normal(door_angle) @ door.into < 0.0:  # straight out leads into a leaf that is open beyond 90°
            return [placed(np.array([into, beside, up])), out]
        return [out] if beyond == 0.0 else [position - beyond * door.along, out]
    back = position - _BACK * door.normal(door_angle)
    into, along, _ = door.in_doorway(back - door.hinge_position)
    return [back, placed(np.array([min(into, outside), along, up]))]


def _out_of_swing(model: Model, position: Array, door_angle: float) -> list[Array]:
    """Way back from a leaf that may come after the vehicle: along its normal, out of the leaf's circle, before the wall."""
    door, radius = model.door, model.vehicle.radius
    back = position - _BACK * door.normal(door_angle)
    into, along, up = door.in_doorway(position - door.hinge_position)
    away = door.in_doorway(-door.normal(door_angle))[:2]
    reach, at = door.width + radius + _ROOM, np.array([into, along])
    forward = float(at @ away)
    room = forward**2 + reach**2 - float(at @ at)
    far = max(math.sqrt(max(room, 0.0)) - forward, model.scenario.mission.hover_distance)
    into, along = at + far * away
    out = np.array([min(into, -door.frame_depth - radius - _ROOM), along, up])
    return [back, door.hinge_position + door.from_doorway(out)]
