r"""What is known of a leaf in the gripper, as a whole-body plan begins with it.

A held tip moves with the leaf, so the vehicle's velocity v follows from the leaf's, from the body rates and from the arm's. The
tip's force is what is left of the rotors' force u, the weight and the wind w,

.. math:: F = u - m g e_3 + w - m \dot v_c ,

both behind one low-pass. An observer that knows of no tie finds it 0.2 s later. Along the normal the force follows from the push
:math:`F_n` at the tip and from the torque τ of the hinge, in the sense of damping, as leaf and vehicle move as one:

.. math:: \lambda = \frac{I_D F_n - m_A D_V\,\tau}{I_D + m_A D_V^2} .
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.control.center_of_mass import center_of_mass
from doorman.control.estimation.estimator import Estimate
from doorman.control.estimation.leaf_estimator import LeafEstimate
from doorman.control.state_converter import StateConverter
from doorman.kinematics.rotations import euler_rates
from doorman.model import Model
from doorman.signals import Measurement

Array = NDArray[np.float64]

_SMOOTHED = 0.05
"""Low-pass of the tip's force [s]: the noise of body rates, as an acceleration, makes 0.3 N of it."""


class HeldLeaf:
    """Estimate of a leaf in the gripper, beside that of vehicle and hinge.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
    """

    def __init__(self, model: Model, converter: StateConverter) -> None:
        self._model, self._converter = model, converter
        self._weight = np.array([0.0, 0.0, model.vehicle.weight])
        self._low: tuple[Array, Array] | None = None

    def let_go(self) -> None:
        """The tip holds nothing."""
        self._low = None

    def update(self, estimate: Estimate, measurement: Measurement, rotors: Array, time_step: float) -> LeafEstimate:
        """The estimate as that of a leaf which the tip holds, once per tick."""
        model, door, lever, mass = (
            self._model,
            self._model.door,
            self._model.coupling.lever_length,
            self._model.vehicle.mass,
        )
        angle, rate = estimate.door_angle, estimate.door_rate
        torque = estimate.door_disturbance + door.damping * rate + door.stiffness * (angle - door.rest_angle)
        whole, inertia = torque + door.weight_torque(angle), estimate.hinge.inertia
        along, up = door.face(angle)
        tip_force = self._tip_force(estimate, measurement, rotors, time_step)
        force = (inertia * estimate.push - mass * lever * whole) / (inertia + mass * lever**2)
        return LeafEstimate(
            position=estimate.position, velocity=estimate.velocity, attitude=estimate.attitude,
            attitude_rates=np.array(euler_rates(estimate.attitude, measurement.body_rates)),
            arm_angles=estimate.arm_angles, door_angle=angle, door_rate=rate, touching=True, normal_force=force,
            friction_force=np.array([along @ tip_force, up @ tip_force]), wind=estimate.wind,
            resistance=model.travel.ahead(torque), friction_share=0.0, inertia=inertia, face_offset=0.0, lever=lever,
            normal_pull=force, hinge=estimate.hinge,
        )  # fmt: skip

    def _tip_force(self, estimate: Estimate, measurement: Measurement, rotors: Array, time_step: float) -> Array:
        """F, shape (3,), world frame [N]."""
        moves = self._converter.on_leaf(estimate.state, measurement.body_rates, measurement.arm_rates).velocity
        moves = moves + center_of_mass(self._model.vehicle, measurement)[1]
        presses = rotors - self._weight + estimate.wind
        if self._low is None or time_step <= 0.0:
            self._low = moves, presses
            return np.asarray(presses)
        share = 1.0 - math.exp(-time_step / _SMOOTHED)
        slow, low = self._low[0] + share * (moves - self._low[0]), self._low[1] + share * (presses - self._low[1])
        self._low = slow, low
        return np.asarray(low - self._model.vehicle.mass * (moves - slow) / _SMOOTHED)
