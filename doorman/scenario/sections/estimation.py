"""What an estimate goes by: how well door, poses and sensors are known, and numbers of the filter at the leaf."""

from __future__ import annotations

from typing import ClassVar

from doorman.scenario.values import NonNegative, Positive, Section

USUAL_FRICTION = 0.8, 0.6
"""Mean and deviation of a room door's friction [N m]."""


class ContactNumbers(Section):
    """What holds while the tip touches the leaf, and how nearly."""

    stiffness: Positive = 1500.0
    """Stiffness of tip and face [N/m]."""
    gap: Positive = 1e-3
    """Deviation of tip and face while they touch: their shapes and compliance [m]."""
    pull: Positive = 0.15
    """Pull that a tip which only pushes may seem to make, by errors of thrust [N]."""
    friction: Positive = 0.3
    """Deviation of the tip's friction, as a share of the normal force."""


class NoiseNumbers(Section):
    """What changes slowly, or by what is not in the model: deviations after one second."""

    velocity: Positive = 0.025
    """Velocity of the vehicle, by rough air and errors of thrust [m/s^1.5]."""
    wind: Positive = 0.03
    """Mean wind [N/s^½]."""
    gust: Positive = 0.15
    """Deviation of the wind's strength, as a share of its mean."""
    lift: Positive = 0.003
    """Lift of the rotors, as a share: batteries sag [1/s^½]."""
    resistance: Positive = 0.35
    """Resistance: wind on the leaf, and friction that differs by place [N m/s^½]."""


class StartNumbers(Section):
    """Deviations before the first touch."""

    wind: Positive = 0.5
    """Horizontal wind [N]."""
    lift: Positive = 0.05
    """Lift of the rotors beyond their command, as a share of it."""
    face: Positive = 1.5e-3
    """Place of a face that is known: a tip is softer or harder than assumed [m]."""


class HingeNumbers(Section):
    """What a hinge is expected to resist with, where the door's section does not say."""

    damping: Positive = 0.7
    """Damping [N m s/rad]."""
    damping_deviation: Positive = 0.7
    """Its deviation [N m s/rad]."""
    friction: Positive = USUAL_FRICTION[0]
    """Friction [N m]."""
    friction_deviation: Positive = USUAL_FRICTION[1]
    """Its deviation [N m]."""
    stiffness: Positive = 0.5
    """Stiffness of a closer [N m/rad]."""
    stiffness_deviation: Positive = 0.7
    """Its deviation [N m/rad]."""


class EstimationSection(Section):
    """How well door, frame of the poses and force sensor are known, and from when on the mission believes what it estimates."""

    sure: ClassVar = 0.8
    """Probability from which on the mission believes that the tip touches the leaf, or has left it."""
    loose_time: ClassVar = 0.12
    """Time for which a closed gripper must probably hold nothing, before it does not hold the leaf [s]."""
    slam_speed: ClassVar = 0.4
    """Speed with which a leaf throws a tip back that touches it, from which on it is slammed [m/s]."""
    gate: ClassVar = 8.0
    """Deviations beyond which a reading is refused: it is of something else, or what it reads is elsewhere."""
    elsewhere: ClassVar = 1.5
    """Deviations of the leaf's place by which a tip that touches nothing is behind it, before the leaf is elsewhere."""
    seen_time: ClassVar = 0.3
    """Time after a reading of the leaf for which it is where it was seen [s]."""
    blow_time: ClassVar = 0.1
    """Time for which poses may be refused; then the vehicle has had a blow, and the filter begins anew [s]."""
    swap_time: ClassVar = 1.0
    """Time for which cameras may take markers for others; then the frame of the poses has moved [s]."""

    door_place_deviation: NonNegative = 0.015
    """Standard deviation of the hinge's place from the URDF's, along either horizontal axis; with `door_yaw_deviation`
    0 as well, the map is trusted [m]."""
    door_yaw_deviation: NonNegative = 0.026
    """Standard deviation of the doorway's heading [rad]."""
    frame_walk: NonNegative = 0.0
    """Standard deviation by which the frame of the poses walks in a second, along either horizontal axis; it grows with
    the root of the time [m/s^½]."""
    frame_touch: ClassVar = 0.003
    """Standard deviation of a touch of the frame: poses, and how flat a wall is [m]."""
    frame_track: ClassVar = 0.002
    """Standard deviation of a gripping tip's track about the hinge, over 0.1 s [m]."""
    tip_force: Positive = 0.5
    """Standard deviation of what a force sensor in the tip reads from the force of a stiff contact: the tip swings [N]."""
    tip_force_noise: ClassVar = 0.05
    """Standard deviation of the white noise of a force sensor in the tip, where there is one [N]."""
    tip_force_offset: ClassVar = 0.2
    """Standard deviation of that sensor's offset, until the readings of free flight tell it [N]."""

    contact: ContactNumbers = ContactNumbers()
    noise: NoiseNumbers = NoiseNumbers()
    start: StartNumbers = StartNumbers()
    hinge: HingeNumbers = HingeNumbers()
