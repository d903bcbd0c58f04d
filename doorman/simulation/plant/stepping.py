r"""Physics steps in one compiled call: onboard loop, hinge and MuJoCo's own step, and what they did to tip and leaf.

The rows of a free body's translation add up all constraint forces on it. So the force of the tip on the leaf is

.. math::
    F = -(J^T f)_{1..3},

for a tie and for contacts alike, as long as nothing else touches the vehicle. Where something does, stepping stops, and contacts
are read one by one.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.pointers import call_with_two
from doorman.numba_types.records import Record, Vector3
from doorman.simulation.plant.onboard.step import (
    OnboardParameters,
    onboard_step,
    quaternion_product,
    rotate,
    rotate_back,
)

STANDS = 2e-4
"""A slower hinge sticks [rad/s]."""


class Contacts(Record):
    """Numbers of contacts, as MuJoCo's sensors count them."""

    total: float
    of_tip: float  # those of tip and leaf


class Engine(NamedTuple):
    """Where MuJoCo's step and what it works on are, and views of its memory."""

    step: int  # addresses of `mj_step`,
    model: int  # of the MjModel
    data: int  # and of the MjData
    qpos: Array
    qvel: Array
    turned: Array  # quaternion of the free body, in qpos, shape (4,)
    spin: Array  # its body rates, in qvel, shape (3,)
    control: Array
    applied: Array  # forces on the joints beside the actuators', shape (nv,)
    constrained: Array  # forces of constraints on the joints, shape (nv,)
    frictions: Array  # of the joints, shape (nv,)
    contacts: Contacts
    tied: NDArray[np.bool_]  # whether the tip is tied to the leaf, shape (1,), or nothing where it cannot be
    leaf_axes: Array  # rotation of the leaf's body, row by row, shape (9,)
    made: Array  # of the rotors: activations or controls, at least of shape (m,) [N]
    gears: Array  # of the actuators, shape (nu, 6)


class HingeNumbers(Record):
    """What acts in the hinge's joint, in its units."""

    torque: float
    friction: float
    stiction: float


class Noted(Record):
    """What the steps of an interval did to tip and leaf."""

    force: Vector3  # of the tip on the door in the last step [N]
    along: float  # its share along n_D [N]
    max_pull: float  # [N]
    max_push: float  # [N]
    hinge_before: float  # value of the hinge's joint before the last step


class State(NamedTuple):
    """Parts of the state, as `look` sees it."""

    position: Array
    velocity: Array
    attitude: Array
    body_rates: Array
    arm_angles: Array
    arm_rates: Array
    thrusts: Array

    @classmethod
    def of(cls, numbers: Array, n: int) -> Self:
        """Views of all numbers together, shape (12 + 2 n + m,)."""
        ends = (*range(0, 13, 3), 12 + n, 12 + 2 * n, numbers.size)
        return cls(*(numbers[begin:end] for begin, end in itertools.pairwise(ends)))


class StepParameters(NamedTuple):
    """Numbers and memory of the stepping kernels."""

    engine: Engine
    onboard: OnboardParameters
    rotors: Array  # set points of another autopilot that flies, shape (m,) [N]; NaN where the onboard loop does
    hinge: HingeNumbers
    hinge_position: int  # the hinge in qpos
    hinge_velocity: int  # and in qvel
    normal_in_leaf: Array  # n_D in the leaf's body, shape (3,)
    place_in_root: Array  # of the base link in the free body, shape (3,) [m]
    noted: Noted  # result
    state: State  # result


@kernel
def take_steps(p: StepParameters, steps: int) -> tuple[int, bool]:
    """Advance the physics: by how many steps, and whether something else than the tip touched in the last one."""
    count, hinge, engine = p.rotors.shape[0], p.hinge_velocity, p.engine
    for taken in range(1, steps + 1):
        onboard_step(p.onboard, engine.turned, engine.spin, engine.qpos, engine.qvel, engine.control)
        if not np.isnan(p.rotors[0]):
            for i in range(count):
                engine.control[i] = p.rotors[i]
        engine.applied[hinge] = p.hinge.torque
        if p.hinge.stiction > 0.0:
            stands = abs(engine.qvel[hinge]) < STANDS
            engine.frictions[hinge] = p.hinge.friction + (p.hinge.stiction if stands else 0.0)
        p.noted.hinge_before = engine.qpos[p.hinge_position]
        call_with_two(engine.step, engine.model, engine.data)
        if engine.contacts.total > engine.contacts.of_tip:
            return taken, True
        note_tip(p)
    return steps, False


@kernel
def note_tip(p: StepParameters) -> None:
    """Take the tip's force of the last step, in which nothing else touched the vehicle, into `p.noted`."""
    axes, normal, noted = p.engine.leaf_axes, p.normal_in_leaf, p.noted
    touches = p.engine.contacts.of_tip > 0.0 or (p.engine.tied.shape[0] > 0 and p.engine.tied[0])
    along, force = 0.0, noted.force
    for i in range(3):
        force[i] = -p.engine.constrained[i] if touches else 0.0
        along += force[i] * (axes[3 * i] * normal[0] + axes[3 * i + 1] * normal[1] + axes[3 * i + 2] * normal[2])
    noted.along = along
    noted.max_pull = max(noted.max_pull, -along)
    noted.max_push = max(noted.max_push, along)


@kernel
def look(p: StepParameters) -> float:
    """Fill `p.state` with the state now."""
    engine, state, servos, lever, turned = p.engine, p.state, p.onboard.servos, p.onboard.rates, p.onboard.quaternion
    root, a, b, turning = engine.turned, engine.spin, p.place_in_root, state.body_rates
    rotate(root, b, lever)
    for i in range(3):
        state.position[i] = engine.qpos[i] + lever[i]
    turning[0], turning[1], turning[2] = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    rotate(root, turning, lever)
    for i in range(3):
        state.velocity[i] = engine.qvel[i] + lever[i]
    rotate_back(p.onboard.root_to_base, a, state.body_rates)
    quaternion_product(root, p.onboard.root_to_base, turned)
    w, x, y, z = turned[0], turned[1], turned[2], turned[3]
    ahead, aside = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)
    state.attitude[0] = math.atan2(2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
    state.attitude[1] = math.asin(min(max(2.0 * (w * y - x * z), -1.0), 1.0))
    state.attitude[2] = math.atan2(aside, ahead)
    for i in range(servos.positions.shape[0]):
        state.arm_angles[i] = engine.qpos[servos.positions[i]]
        state.arm_rates[i] = engine.qvel[servos.velocities[i]]
    for i in range(p.rotors.shape[0]):
        state.thrusts[i] = engine.made[i] * engine.gears[i, 2]
    return math.hypot(ahead, aside)
