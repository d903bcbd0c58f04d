r"""Findings about the rotors: the thrust that is left while they turn the vehicle, against its weight.

The mixer keeps roll and pitch before thrust. A torque τ about x and y is made by :math:`f_i = B^+_{i,1:3}\,\tau` more of rotor
i, so the most thrust that carries it is

.. math::
    L(\tau) = \min_i \frac{f_{\max,i} - B^+_{i,1:3}\,\tau}{B^+_{i,0}}

and a vehicle whose :math:`L` is less than its weight sinks as long as it turns. The onboard loop asks for
:math:`\tau = I_A K_p K_a \theta` where its attitude is off by θ. A gripped tip resists that turn, and carries weight, until a
joint of the arm slips: with :math:`F_z = \min_k (\tau_{\max,k} - \tau_{g,k}) / |J_{d,zk}|` at the tip, d ahead of O_B, and the
torques :math:`\tau_g` of the arm's own weight, the torque is :math:`F_z d_x` at most.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.exceptions import BackendError
from doorman.feasibility.report import Finding, found, warning_if
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.rotor_layout import RotorLayout, rotor_layout
from doorman.model import Model
from doorman.planning.pace import RESTING
from doorman.simulation.plant.onboard.attitude_loop import AttitudeGains
from doorman.simulation.plant.plant import hover_wrench

FIRST_TURN = 0.1
"""Largest tilt that the first plans ask of a vehicle at the leaf [rad]."""
_CLEAR = 1.3
"""Ratio of largest thrust and weight below which gusts, a heavier door or a weak battery can make a vehicle sink."""

_NEAR = 0.1
"""Ratio beyond what is needed below which a warning says so."""
_HELD = 0.9
"""Share of a joint's torque limit that is counted on."""
_OFFSET = 0.01
"""Offset of the centre of mass that brings a warning [m]."""


def lift_findings(model: Model) -> list[Finding]:
    """Whether the rotors carry the vehicle while they steer it."""
    try:
        layout = rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)
    except BackendError as error:
        advice = "use at least four rotor frames around O_B, in both senses of rotation"
        return [found("rotors", False, str(error), float(len(model.vehicle.rotors)), 4.0, "rotors", advice)]
    return [_thrust_reserve(model, layout), _center_of_mass(model, layout)]


def lift_left(layout: RotorLayout, torque: Array) -> float:
    """Largest thrust with which the rotors make a torque."""
    inverse = layout.inverse
    return float(((layout.max_thrusts - inverse[:, 1:3] @ torque) / inverse[:, 0]).min())


def _thrust_reserve(model: Model, layout: RotorLayout) -> Finding:
    """Thrust in hand over the weight, while the vehicle answers the touch."""
    weight = model.vehicle.weight
    ratio = model.vehicle.max_thrust / weight
    turn, why = _first_turn(model)
    lift = lift_left(layout, hover_wrench(model)[1:3] + np.array([0.0, _turning_torque(model, turn)]))
    carried = _HELD * _carried(model)
    needed = ratio + (weight - carried - lift) / weight
    clear = max(needed + _NEAR, _CLEAR)
    message = f"the largest thrust of {model.vehicle.max_thrust:.1f} N is {ratio:.2f} times the weight"
    if sinks := ratio < needed:
        held = f", and the arm's joints hold {carried:.1f} N at the tip" if carried > 0.0 else ""
        message += (
            f"; while the rotors turn the vehicle by {math.degrees(turn):.1f}°, {why}, they lift {max(lift, 0.0):.1f} N "
            f"of {weight:.1f} N{held}: the vehicle sinks"
        )
    return found(
        "thrust reserve", ratio >= clear, message, ratio, needed if sinks else clear, "",
        "use stronger rotors (vehicle.max_thrust) or less mass", warning_if(not sinks),
    )  # fmt: skip


def _first_turn(model: Model) -> tuple[float, str]:
    """Error of the attitude that the onboard loop has to answer at the touch, and why [rad]."""
    control = model.scenario.control
    if model.contact.tied > 0.0:
        return FIRST_TURN, "as the first plans do with the tip tied"
    stop = model.vehicle.mass * control.velocity_gain[0] * model.scenario.mission.touch_speed / model.vehicle.weight
    push = RESTING * model.scale.force / model.vehicle.weight
    return min(max(stop, push), FIRST_TURN), "as the controller does when the touch stops the tip"


def _turning_torque(model: Model, turn: float) -> float:
    """Torque about the pitch axis with which the onboard loop answers an error of the pitch, until a tied arm slips [N m]."""
    true = model.scenario.simulation
    quickest = min(model.attitude_loop.lag, true.attitude_lag)  # the quicker a loop, the more it asks of the rotors
    gains = AttitudeGains.of(AttitudeLoop(quickest), true.motor_time_constant)
    torque = float(model.vehicle_inertia[1, 1]) * gains.rate[1] * gains.attitude[1] * turn
    slips = _carried(model) * abs(float(model.vehicle.tip_position(model.start_arm)[0]))
    return min(torque, slips) if model.contact.tied > 0.0 else torque


def _carried(model: Model) -> float:
    """Weight that the arm carries by a tied tip before one of its joints slips [N]."""
    levers = np.abs(model.vehicle.tip_jacobian(model.start_arm)[2])
    limits = np.where(model.vehicle.torque_limits > 0.0, model.vehicle.torque_limits, np.inf)
    limits = np.maximum(limits - np.abs(weight_on_joints(model, model.start_state)), 0.0)
    holds = np.divide(limits, levers, out=np.full_like(limits, np.inf), where=levers > 1e-9)
    return model.contact.tied * min(float(holds.min(initial=np.inf)), model.vehicle.weight)


def _center_of_mass(model: Model, layout: RotorLayout) -> Finding:
    r"""In free flight the rotors alone hold :math:`c \times f_t e_3` of a centre of mass c beside O_B, and the weight."""
    centers = [model.vehicle.center_of_mass(arm) for arm in (model.start_arm, model.goal_arm)]
    offset, weight = max(float(np.linalg.norm(place)) for place in centers), model.vehicle.weight
    lift = min(lift_left(layout, weight * np.array([place[1], -place[0]])) for place in centers)
    return found(
        "centre of mass", offset <= _OFFSET,
        f"the centre of mass is up to {1e2 * offset:.1f} cm from the base link's origin; "
        f"rotors that hold it level there lift {max(lift, 0.0):.1f} N of {weight:.1f} N",
        offset, _OFFSET, "m", "use a battery that balances the arm, a lighter arm, or a posture nearer to the body",
        warning_if(lift >= weight),
    )  # fmt: skip


def weight_on_joints(model: Model, state: Array) -> Array:
    r"""Torques of the arm's own weight on its joints, :math:`m g\,J_c^T R^T e_3`."""
    up = rotation_body_to_world(state[:3])[2]
    return np.asarray(model.vehicle.weight * up @ model.vehicle.center_of_mass_jacobian(state[5:]))
