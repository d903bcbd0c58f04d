"""The bank of a task: of a tip that presses, or is tied."""

from __future__ import annotations

import numpy as np

from doorman.estimation.filter import Filter
from doorman.estimation.leaf.hypotheses import (
    BLOWN,
    FREE,
    GRIPPED,
    HOLDING,
    PUSHING,
    RESTING,
    STANDING,
    STOPPED,
    THROWN,
    blown,
    free,
    gripped,
    holding,
    pushing,
    standing,
    stopped,
    switching,
    thrown,
)
from doorman.estimation.leaf.kernels.report import LeafState
from doorman.estimation.leaf.motion import LeafMotion
from doorman.estimation.leaf.numbers import PLACES, SIZE
from doorman.estimation.measurement import Measurement
from doorman.estimation.model import ProcessModel
from doorman.estimation.output import Output
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.model import Model

AWAY, AT_THE_FRAME, AT_THE_LEAF, CLOSING, HELD = "away", "at_the_frame", "at_the_leaf", "closing", "held"
"""Situations: nothing is near, the tip feels for the frame, it may touch the leaf, the gripper closes where it meets the leaf,
it has closed."""

LEAF = "leaf"
"""Name of the measurement of the leaf's own angle. A gap that it tells is no contact: tip and face keep their distance in one."""
WINDS, SLIPS = ("wind_x", "wind_y", "wind_z"), ("slip_along", "slip_up")
"""Outputs beside `normal_force`: the wind on the vehicle [N], and the tip's velocity on the face [m/s];"""
GAINS, BORNE = ("gains_x", "gains_y", "gains_z"), "borne"
"""the acceleration of O_B [m/s²], and what the leaf resists with now: one that rests, with all that it is pushed with [N m]."""


_banks: dict[tuple[object, ...], Filter] = {}
"""A bank of every kind of vehicle, door and contact that this process has met: to print its expressions takes half a second."""


def leaf_filter(model: Model, numbers: Numbers) -> Filter:
    """Filter of a scenario's vehicle and door; see `LeafMotion`. Readings of the tip's force are fused where they come."""
    pattern, names = ArmPattern.of(model.vehicle.arm)[0], model.vehicle.point_names
    grips = model.scenario.contact.kind == "grip"
    kind = repr(pattern), names, tuple(numbers.sizes.items()), grips  # of a pattern, 0 and 0.0 differ
    if kind not in _banks:
        _banks[kind] = _bank(LeafMotion(pattern, names, numbers), grips, numbers)
    least, most = LeafState.over(np.full(SIZE, -np.inf)), LeafState.over(np.full(SIZE, np.inf))
    inertia, play = model.door.inertia, numbers.one("start.joint")
    least.log_inertia, most.log_inertia = np.log(0.02 * inertia), np.log(20.0 * inertia)
    least.joint, most.joint = model.door.lower_limit - play, model.door.upper_limit + play
    hardest = 2.0 * model.scenario.control.max_push * model.coupling.lever_length / model.door.per_angle
    least.resistance, most.resistance = -hardest, hardest  # beyond it nothing that is pushed would move
    gate = model.scenario.estimation.gate
    return _banks[kind].with_numbers(numbers.vector, least.floats, most.floats, gate)


def _bank(motion: LeafMotion, grips: bool, numbers: Numbers) -> Filter:
    """The filter without the numbers of a scenario."""
    hypotheses = [
        each(motion)
        for each in (free, blown, stopped, pushing, standing, *((gripped, holding, thrown) if grips else ()))
    ]
    gripping = {CLOSING: [FREE, GRIPPED, HOLDING], HELD: [FREE, GRIPPED, HOLDING, THROWN]}
    names = tuple(each.name for each in hypotheses)
    resting = [name for name in RESTING if name in names]
    under = {FREE: 0.0, BLOWN: 0.0, STOPPED: 0.0, **{name: motion.force_on_standing for name in resting}}
    force = Output("normal_force", motion.force_on_moving, under=under)
    felt_under = {**under, STOPPED: motion.force_on_frame}
    felt = Measurement("tip_force", motion.force_on_moving, motion.sensor.tip_force, under=felt_under)
    winds = [Output(name, motion.wind[k]) for k, name in enumerate(WINDS)]
    slips = [Output(name, motion.slip[k]) for k, name in enumerate(SLIPS)]
    gained = {each.name: each.dynamics[PLACES["velocity"]] for each in hypotheses}
    gains = [
        Output(name, gained[PUSHING][k], under={each: gained[each][k] for each in names}) for k, name in enumerate(GAINS)
    ]  # fmt: skip
    borne = Output(BORNE, motion.resistance, under={name: motion.borne(motion.force_on_standing) for name in resting})
    return Filter(
        ProcessModel(
            motion.state, motion.inputs, motion.dynamics(0, 0, 1), hypotheses[0].noise, parameters=motion.parameters,
        ),
        measurements=[
            Measurement("pose", motion.position, motion.sensor.pose), felt,
            Measurement(LEAF, motion.door_angle, motion.sensor.leaf),
        ],
        hypotheses=hypotheses, switching=switching(motion, names), outputs=[force, *winds, *slips, *gains, borne],
        allowed={
            AWAY: [FREE, BLOWN], AT_THE_FRAME: [FREE, BLOWN, STOPPED], AT_THE_LEAF: [FREE, PUSHING, STANDING],
            **(gripping if grips else {}),
        },
        parameters=numbers.vector, ticks=24, longest_step=1.0,
    )  # fmt: skip
