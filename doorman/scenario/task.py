"""The task: vehicle, door, contact between them, start and goal."""

from __future__ import annotations

import math
from typing import Literal

from doorman.scenario.values import Angle, DoorAngle, Name, NonNegative, Pitch, Positive, Section, Switch


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


class DoorSection(Section):
    """Door: its URDF, the names in it, and the torques in its hinge."""

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


class ContactSection(Section):
    """Where and how the tip touches the leaf."""

    distance_from_hinge: Positive = 0.70
    """D_V [m]."""
    fit_doorway: Switch = True
    """Whether a tip that pushes comes nearer to the hinge in a narrow doorway (`kinematics.coupling.distance_in_doorway`), and
    ends beside the leaf's normal there."""
    height: NonNegative = 0.80
    kind: Literal["grip", "push"] = "grip"


class StartSection(Section):
    """Where the task starts, at rest. What is not given of its posture is found (`doorman.postures`)."""

    attitude: tuple[Angle, Pitch, Angle] | None = None
    """Roll, pitch and yaw [rad]; by default level, along the leaf's normal, or beside it where that breaks a constraint."""
    door_angle: DoorAngle = math.pi / 2
    arm: tuple[Angle, ...] | None = None
    """[rad]; by default [0, 1, −0.6, −0.4] for an arm of four joints that keeps all limits with it, else what is found."""


class GoalSection(Section):
    """Where the task ends, at rest. What is not given of its posture is found (`doorman.postures`)."""

    attitude: tuple[Angle, Pitch, Angle] | None = None
    """Roll, pitch and yaw [rad]; by default level, along the leaf's normal, or beside it where that breaks a constraint."""
    door_angle: DoorAngle = math.pi / 9
    arm: tuple[Angle, ...] | None = None
    """[rad]; by default [0, π/2, −π/2, 0] for an arm of four joints that keeps all limits with it, else what is found."""
