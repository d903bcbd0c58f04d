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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.pointers import call_with_two
from doorman.simulation.plant.onboard.step import (
    OnboardParameters,
    onboard_step,
    quaternion_product,
    rotate,
    rotate_back,
)

Indices = NDArray[np.int64]

STANDS = 2e-4
"""A slower hinge sticks [rad/s]."""


class Engine(NamedTuple):
    """Where MuJoCo's step and what it works on are, and views of its memory."""

    addresses: Indices  # of `mj_step`, of the MjModel and of the MjData, shape (3,)
    qpos: Array
    qvel: Array
    control: Array
    applied: Array  # forces on the joints beside the actuators', shape (nv,)
    constrained: Array  # forces of constraints on the joints, shape (nv,)
    frictions: Array  # of the joints, shape (nv,)
    contacts: Array  # numbers of all contacts and of those of tip and leaf, shape (2,)
    tied: NDArray[np.bool_]  # whether the tip is tied to the leaf, shape (1,), or nothing where it cannot be
    leaf_axes: Array  # rotation of the leaf's body, row by row, shape (9,)
    made: Array  # of the rotors: activations or controls, at least of shape (m,) [N]
    gears: Array  # of the actuators, shape (nu, 6)


class StepParameters(NamedTuple):
    """Numbers and memory of the stepping kernels."""

    engine: Engine
    onboard: OnboardParameters
    command: Array  # see `onboard_step`, shape (7 + n,)
    rotors: Array  # set points of another autopilot that flies, shape (m,) [N]; NaN where the onboard loop does
    hinge: Array  # torque on the hinge's joint, its friction, and its stiction; shape (3,), in the joint's units
    hinge_at: Indices  # the hinge in qpos and in qvel, shape (2,)
    normal_in_leaf: Array  # n_D in the leaf's body, shape (3,)
    place_in_root: Array  # of the base link in the free body, shape (3,) [m]
    arm_at: Indices  # arm joints in qpos and in qvel, shape (2, n)
    tip: Array
    """Result: force on the door, shape (3,) [N], its share along n_D, and the largest pull and push; shape (6,)."""
    hinge_before: Array  # result: value of the hinge's joint before the last step, shape (1,)
    truth: Array
    """Result: position, velocity, attitude, body rates, arm angles, arm rates and rotor thrusts, shape (12 + 2 n + m,)."""


def truth_parts(n: int, m: int) -> tuple[slice, ...]:
    """Slices of `StepParameters.truth`, in the order of its parts."""
    ends = np.cumsum([0, 3, 3, 3, 3, n, n, m]).tolist()
    return tuple(slice(begin, end) for begin, end in itertools.pairwise(ends))


@kernel
def take_steps(p: StepParameters, steps: int) -> int:
    """Advance the physics."""
    count, hinge, engine = p.rotors.shape[0], p.hinge_at[1], p.engine
    for taken in range(1, steps + 1):
        onboard_step(p.onboard, engine.qpos, engine.qvel, p.command, engine.control)
        if not np.isnan(p.rotors[0]):
            for i in range(count):
                engine.control[i] = p.rotors[i]
        engine.applied[hinge] = p.hinge[0]
        if p.hinge[2] > 0.0:
            stands = abs(engine.qvel[hinge]) < STANDS
            engine.frictions[hinge] = p.hinge[1] + (p.hinge[2] if stands else 0.0)
        p.hinge_before[0] = engine.qpos[p.hinge_at[0]]
        call_with_two(engine.addresses[0], engine.addresses[1], engine.addresses[2])
        if engine.contacts[0] > engine.contacts[1]:
            return taken
        note_tip(p)
    return steps


@kernel
def note_tip(p: StepParameters) -> None:
    """Take the tip's force of the last step, in which nothing else touched the vehicle, into `p.tip`."""
    axes, normal, force = p.engine.leaf_axes, p.normal_in_leaf, p.tip
    touches = p.engine.contacts[1] > 0.0 or (p.engine.tied.shape[0] > 0 and p.engine.tied[0])
    along = 0.0
    for i in range(3):
        force[i] = -p.engine.constrained[i] if touches else 0.0
        along += force[i] * (axes[3 * i] * normal[0] + axes[3 * i + 1] * normal[1] + axes[3 * i + 2] * normal[2])
    force[3] = along
    force[4] = max(force[4], -along)
    force[5] = max(force[5], along)


@kernel
def look(p: StepParameters) -> float:
    """Fill `p.truth` with the state now."""
    engine, truth, lever, turned = p.engine, p.truth, p.onboard.rates, p.onboard.quaternion
    root, spin = engine.qpos[3:7], engine.qvel[3:6]
    rotate(root, p.place_in_root, lever)
    for i in range(3):
        truth[i] = engine.qpos[i] + lever[i]
    a, b = spin, p.place_in_root
    truth[9], truth[10], truth[11] = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    rotate(root, truth[9:12], lever)
    for i in range(3):
        truth[3 + i] = engine.qvel[i] + lever[i]
    rotate_back(p.onboard.root_to_base, spin, truth[9:12])
    quaternion_product(root, p.onboard.root_to_base, turned)
    w, x, y, z = turned[0], turned[1], turned[2], turned[3]
    ahead, aside = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)
    truth[6] = math.atan2(2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
    truth[7] = math.asin(min(max(2.0 * (w * y - x * z), -1.0), 1.0))
    truth[8] = math.atan2(aside, ahead)
    n = p.arm_at.shape[1]
    for i in range(n):
        truth[12 + i] = engine.qpos[p.arm_at[0, i]]
        truth[12 + n + i] = engine.qvel[p.arm_at[1, i]]
    for i in range(p.rotors.shape[0]):
        truth[12 + 2 * n + i] = engine.made[i] * engine.gears[i, 2]
    return math.hypot(ahead, aside)
