"""The task: vehicle, door, contact between them, start and goal."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from doorman.scenario.values import Angle, DoorAngle, Name, NonNegative, Number, Pitch, Positive, Section, Switch


class VehicleSection(Section):
    """Vehicle: its URDF and the names in it."""

    urdf: Name = "hexarotor_arm"
    base_link: Name = "base_link"
    tip: Name = "tip"
    servos: tuple[Name, ...] | None = None
    """Frames of joints 3 … n; by default `servo_3` … `servo_n`, or the joint's own where there is none."""
    radius: Positive | None = None
    """R_A [m]; by default the disc that holds the collision shapes of the base link, or the propellers (`kinematics.disc`)."""
    max_thrust: Positive | None = None
    """[N]; by default the sum over the URDF's rotors, or twice the weight where it names none."""
    attitude_lag: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1)] = 0.1
    """Of the autopilot's attitude loop behind its setpoints of roll and pitch [s]: plans, look-aheads, the simulated loop and the
    check use it (`dynamics.attitude_loop`), and the flight's own estimate starts from it."""


_NAMES = {"joint": "hinge", "link": "leaf"}
"""Other names of keys of `[door]`."""


class DoorSection(Section):
    """Door: its URDF, the names in it, and the torques in its hinge. `link` and `joint` are other names of `leaf` and `hinge`."""

    urdf: Name = "hinged_door"
    leaf: Name = "leaf"
    hinge: Name = "hinge"
    closed: Angle | None = None
    """Value of the hinge's joint where the door is closed [rad]; by default where the leaf's free edge meets a jamb."""
    width: Positive | None = None
    """D_w [m]; leaf and frame are stretched to it. By default the URDF's."""
    mass: Positive | None = None
    """Of the leaf [kg], its inertia in proportion; by default the URDF's."""
    damping: NonNegative | None = None
    """b [N m s/rad]; by default the URDF's `<dynamics damping>`."""
    friction: NonNegative | None = None
    """τ_c [N m]; by default the URDF's `<dynamics friction>`."""
    friction_rate: Positive = 0.02
    """ε in τ_c tanh(α̇/ε) [rad/s]."""
    stiffness: NonNegative = 0.0
    """k of a spring or closer [N m/rad]."""
    rest_angle: Angle = math.pi / 2
    """α_0, where the spring is relaxed [rad]."""
    preload: NonNegative = 0.0
    """τ_p of a closer, with which it shuts the door at any opening [N m]."""
    stiction: NonNegative = 0.0
    """τ_s, by which a standing hinge resists more than one that moves [N m]."""
    latched: Switch = False
    """Whether a latch or a lock holds the door closed: nothing opens it then."""

    @model_validator(mode="before")
    @classmethod
    def _other_names(cls, values: Any) -> Any:
        """`joint` and `link`, in place of `hinge` and `leaf`."""
        if not isinstance(values, dict):
            return values
        return {_NAMES.get(key, key): value for key, value in values.items() if key not in _NAMES} | {
            _NAMES[key]: value for key, value in values.items() if key in _NAMES
        }


class ContactSection(Section):
    """Where and how the tip touches the leaf."""

    distance_from_hinge: Positive = 0.70
    """D_V [m]."""
    fit_doorway: Switch = True
    """Whether a tip that pushes comes nearer to the hinge in a narrow doorway (`kinematics.coupling.distance_in_doorway`), and
    ends beside the leaf's normal there."""
    height: NonNegative = 0.80
    kind: Literal["grip", "push"] = "grip"
    frame: Name | None = None
    """Frame of the door's URDF, on the leaf, where the tip touches, with its x axis away from the leaf: it takes the place of
    `distance_from_hinge`, `height` and `side`."""
    side: Literal["push", "pull"] | None = None
    """Side of the leaf that the vehicle is on: where the door is pushed open, or pulled; by default that of `frame`, or of a
    start or goal whose `door_angle` is beyond the closed door's."""


class StartSection(Section):
    """Where the task starts, at rest. What is not given of its posture is found (`doorman.postures`)."""

    attitude: tuple[Angle, Pitch, Angle] | None = None
    """Roll, pitch and yaw [rad]; by default level, along the leaf's normal, or beside it where that breaks a constraint."""
    door_angle: DoorAngle | None = None
    """α [rad]; by default the closed door's, π/2."""
    opening: NonNegative | None = None
    """From the closed door, in place of `door_angle` [rad, or m]."""
    joint_value: Number | None = None
    """Of the URDF's joint, in place of either [rad, or m]."""
    arm: tuple[Angle, ...] | None = None
    """[rad]; by default [0, 1, −0.6, −0.4] for an arm of four joints that keeps all limits with it, else what is found."""


class GoalSection(Section):
    """Where the task ends, at rest. What is not given of its posture is found (`doorman.postures`)."""

    attitude: tuple[Angle, Pitch, Angle] | None = None
    """Roll, pitch and yaw [rad]; by default level, along the leaf's normal, or beside it where that breaks a constraint."""
    door_angle: DoorAngle | None = None
    """α [rad]; by default that of an opening of 70°, or of what the hinge's limits leave of it."""
    opening: NonNegative | None = None
    """From the closed door, in place of `door_angle` [rad, or m]."""
    joint_value: Number | None = None
    """Of the URDF's joint, in place of either [rad, or m]."""
    arm: tuple[Angle, ...] | None = None
    """[rad]; by default [0, π/2, −π/2, 0] for an arm of four joints that keeps all limits with it, else what is found."""
