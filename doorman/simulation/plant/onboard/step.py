"""What runs on board at the physics rate: attitude loop, mixer and servos, as one compiled step."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.records import Record
from doorman.simulation.plant.onboard.attitude_loop import AttitudeParameters, attitude_torque, integrate_rate_error
from doorman.simulation.plant.onboard.rotors import MixerParameters, add_side, mix
from doorman.simulation.plant.onboard.servos import ServoParameters, servo_references


class BodyCommand(Record):
    """What the body is to do."""

    thrust: float  # f_t [N]
    attitude: Annotated[Array, 4]  # quaternion [w, x, y, z]
    side: Annotated[Array, 2]  # force along the body's x and y [N]


class OnboardParameters(NamedTuple):
    """Numbers of the onboard step."""

    attitude: AttitudeParameters
    mixer: MixerParameters
    root_to_base: Array  # quaternion of the base link in the free body, shape (4,)
    servos: ServoParameters
    command: BodyCommand
    arm_rates: Array  # commanded, shape (n,) [rad/s]
    quaternion: Array  # scratch: attitude of the base link, shape (4,)
    rates: Array  # scratch: body rates in the base link, shape (3,)


@kernel
def quaternion_product(a: Array, b: Array, out: Array) -> None:
    """Hamilton product a b of two quaternions [w, x, y, z]."""
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]


@kernel
def rotate(q: Array, v: Array, out: Array) -> None:
    """Vector rotated by a unit quaternion."""
    _rotate_by(q[0], q[1], q[2], q[3], v, out)


@kernel
def rotate_back(q: Array, v: Array, out: Array) -> None:
    """Vector rotated by the inverse of a unit quaternion."""
    _rotate_by(q[0], -q[1], -q[2], -q[3], v, out)


@kernel
def _rotate_by(w: float, x: float, y: float, z: float, v: Array, out: Array) -> None:
    a = 2.0 * (y * v[2] - z * v[1])
    b = 2.0 * (z * v[0] - x * v[2])
    c = 2.0 * (x * v[1] - y * v[0])
    out[0] = v[0] + w * a + y * c - z * b
    out[1] = v[1] + w * b + z * a - x * c
    out[2] = v[2] + w * c + x * b - y * a


@kernel
def onboard_step(p: OnboardParameters, turned: Array, spin: Array, qpos: Array, qvel: Array, control: Array) -> None:
    """Fill `control` = [rotor thrusts (m), servo references (n)] from MuJoCo's state: of it, quaternion and rates of the body."""
    quaternion_product(turned, p.root_to_base, p.quaternion)
    rotate_back(p.root_to_base, spin, p.rates)
    attitude_torque(p.attitude, p.quaternion, p.rates, p.command.attitude)
    mix(p.mixer, p.command.thrust, p.attitude.torque)
    integrate_rate_error(p.attitude, p.mixer.achieved[1:])
    add_side(p.mixer, p.command.side[0], p.command.side[1])
    count = p.mixer.thrusts.shape[0]
    for i in range(count):
        control[i] = p.mixer.thrusts[i]
    servo_references(p.servos, qpos, qvel, p.arm_rates, control[count:])
