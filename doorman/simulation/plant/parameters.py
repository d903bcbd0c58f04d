"""Numbers and memory of the stepping kernels, for one plant."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.model import Model
from doorman.simulation.plant.engine import addresses
from doorman.simulation.plant.onboard.attitude_loop import AttitudeGains, AttitudeParameters
from doorman.simulation.plant.onboard.rotors import MixerParameters
from doorman.simulation.plant.onboard.servos import ServoParameters
from doorman.simulation.plant.onboard.step import BodyCommand, OnboardParameters
from doorman.simulation.plant.plant import Plant, hover_wrench
from doorman.simulation.plant.stepping import Contacts, Engine, HingeNumbers, Noted, State, StepParameters


def step_parameters(
    mujoco: Any, model: Model, plant: Plant, layout: RotorLayout, time_step: float, gains: AttitudeGains,
    hinge: HingeNumbers, state: Array,
) -> StepParameters:  # fmt: skip
    """Parameters with cleared results; `hinge` and `state` stay shared with their owner."""
    return StepParameters(
        engine=_engine_memory(mujoco, plant),
        onboard=_onboard_parameters(model, plant, layout, time_step, gains),
        rotors=np.full(layout.count, np.nan),
        hinge=hinge,
        hinge_position=plant.hinge_position,
        hinge_velocity=plant.hinge_velocity,
        normal_in_leaf=plant.normal_in_leaf,
        place_in_root=plant.root_to_base[:3, 3].copy(),
        noted=Noted(),
        state=State.of(state, model.n_arm),
    )


def _engine_memory(mujoco: Any, plant: Plant) -> Engine:
    engine_model, data = plant.engine_model, plant.data
    step, model_at, data_at = addresses(mujoco, engine_model, data)
    return Engine(
        step=step,
        model=model_at,
        data=data_at,
        qpos=data.qpos,
        qvel=data.qvel,
        turned=data.qpos[3:7],
        spin=data.qvel[3:6],
        control=data.ctrl,
        applied=data.qfrc_applied,
        constrained=data.qfrc_constraint,
        frictions=engine_model.dof_frictionloss,
        contacts=Contacts.over(data.sensordata),
        tied=data.eq_active,
        leaf_axes=data.xmat[plant.leaf_body],
        made=data.act if engine_model.na else data.ctrl,
        gears=engine_model.actuator_gear,
    )


def _onboard_parameters(
    model: Model, plant: Plant, layout: RotorLayout, time_step: float, gains: AttitudeGains
) -> OnboardParameters:
    attitude = AttitudeParameters.of(model.vehicle_inertia, layout.torque_authority, time_step, gains)
    attitude.memory.integral[:] = np.linalg.solve(
        attitude.inertia, hover_wrench(model)[1:]
    )  # trimmed: a hover is at rest
    servos = ServoParameters.of(model.vehicle, plant.arm_positions, plant.arm_velocities, time_step)
    servos.largest_torque[:] *= model.scenario.simulation.servo_torque_scale
    return OnboardParameters(
        attitude=attitude,
        mixer=MixerParameters.of(layout),
        root_to_base=plant.root_to_base_quaternion,
        servos=servos,
        command=BodyCommand(),
        arm_rates=np.zeros(model.n_arm),
        quaternion=np.zeros(4),
        rates=np.zeros(3),
    )
