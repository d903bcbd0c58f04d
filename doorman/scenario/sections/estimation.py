"""What an estimate goes by: how well door, poses and sensors are known, and the numbers of the filter at the leaf."""

from __future__ import annotations

from typing import ClassVar

from doorman.scenario.values import NonNegative, Positive, Section

USUAL_FRICTION = 0.8, 0.6
"""Mean and deviation of a room door's friction [N m]."""


class FilterNumbers(Section):
    """Numbers of the filter at the leaf: keys that differ by laboratory and vehicle, and constants of how a touch goes."""

    def numbers(self) -> dict[str, float]:
        """All of them by name; `doorman estimate` replays a flight with any other value."""
        return {name: getattr(self, name) for name in type(self).__annotations__}


class ContactNumbers(FilterNumbers):
    """What holds while the tip touches the leaf, and how nearly."""

    stiffness: Positive = 1500.0
    """Stiffness of tip and face [N/m]."""
    gap: Positive = 1e-3
    """Deviation of tip and face while they touch: their shapes and compliance [m]."""
    gap_rate: Positive = 5e-3
    """Deviation of their speeds then [m/s]."""
    slip_rate: Positive = 5e-3
    """Deviation of the tip's speed in the face where it grips [m/s]."""
    pull: Positive = 0.15
    """Pull that a tip which only pushes may seem to make, by errors of thrust [N]."""
    inside: Positive = 3e-3
    """Depth by which a free tip may seem to be in the face [m]."""
    lasts: ClassVar = 0.05
    """Time for which such an error stays: a few poses [s]."""
    friction: Positive = 0.3
    """Deviation of the tip's friction, as a share of the normal force."""
    friction_lasts: ClassVar = 5.0
    """Time after which a tip that creeps has lost the friction that it had [s]."""
    held: ClassVar = 0.1
    """Force across the face that a grip makes beside that of friction, as a share of the vehicle's weight."""
    settles: ClassVar = 0.05
    """Time in which a leaf that stops comes to stand [s]."""
    sticks: ClassVar = 0.3
    """Time after which a leaf that stands is believed to resist with more than it bears [s]."""
    more: Positive = 0.2
    """Torque by which it then resists more, on average [N m]."""
    brakes: ClassVar = 0.01
    """Time in which friction stops a free leaf at the soonest [s]."""
    creeps: ClassVar = 0.02
    """Rate below which a free leaf's friction fades [rad/s]."""
    ajar: ClassVar = 0.05
    """Opening from which on a closer may draw the leaf back; one that is closed rests at its stop [rad]."""


class SwitchNumbers(FilterNumbers):
    """How often what tip and leaf do changes."""

    near: Positive = 4e-3
    """Gap from which on a touch is near [m]."""
    make: ClassVar = 30.0
    """Touches of a near tip [1/s]."""
    far: ClassVar = 0.05
    """Touches of a tip that is away, or that feels for a frame [1/s]."""
    reach: Positive = 0.1
    """Largest gap of those: no leaf comes so far without being felt [m]."""
    lose: ClassVar = 0.1
    """Touches that end [1/s]."""
    leave: ClassVar = 10.0
    """Touches that end where the tip is to come off the leaf [1/s]."""
    follow: ClassVar = 1.0
    """Touches of a near tip then: a leaf that stays is likelier than one that follows [1/s]."""
    slip: ClassVar = 2e-3
    """Grips that end [1/s]."""
    jump: ClassVar = 1e-3
    """Winds that jump: rare, and plain when they do [1/s]."""
    calm: ClassVar = 5.0
    """Jumps that end [1/s]."""
    throw: ClassVar = 0.02
    """Gripped leaves that a hand or a gust throws or catches [1/s]."""
    stop: ClassVar = 1.0
    """Leaves that come to rest, or begin to move [1/s]."""


class NoiseNumbers(FilterNumbers):
    """What changes slowly, or by what is not in the model: deviations after one second."""

    velocity: Positive = 0.025
    """Velocity of the vehicle, by rough air and errors of thrust [m/s^1.5]."""
    bounce: ClassVar = 0.02
    """Normal force, as a share of it: the tip swings on its compliance [s^½]."""
    wind: Positive = 0.03
    """Mean wind [N/s^½]."""
    jump: Positive = 3.0
    """Wind that jumps: by about 1 N in 0.1 s [N/s^½]."""
    gust: Positive = 0.15
    """Deviation of the wind's strength, as a share of its mean."""
    gust_lasts: ClassVar = 1.0
    """Time for which a gust stays [s]."""
    draught: Positive = 0.05
    """Vertical wind [N/s^½]."""
    wind_turn: Positive = 1e-3
    """Rate with which the wind turns [rad/s^1.5]."""
    lift: Positive = 0.003
    """Lift of the rotors, as a share: batteries sag [1/s^½]."""
    rate: Positive = 0.05
    """Rate of the leaf, by forces that are not in the model [rad/s^1.5]."""
    throw: Positive = 3.0
    """Rate of a gripped leaf that is thrown: by 1 rad/s in 0.1 s [rad/s^1.5]."""
    thrown_along: Positive = 2.0
    """Velocity of the vehicle that goes along then [m/s^1.5]."""
    drawn: ClassVar = 0.3
    """Share of the resistance that draws an open leaf back, a closer [s^½]."""
    resistance: Positive = 0.35
    """Resistance: wind on the leaf, and friction that differs by place [N m/s^½]."""
    gives: ClassVar = 1.0
    """Share of what a leaf that rests bears, which may give way [1/s^½]."""
    inertia: Positive = 0.05
    """Logarithm of the leaf's inertia [1/s^½]."""
    face: Positive = 2e-5
    """Place of the face [m/s^½]."""
    face_by_angle: ClassVar = 0.5
    """Place of the face of a leaf that a sensor sees, as a share of the map's doubt: its error differs by angle [1/s^½]."""


class StartNumbers(FilterNumbers):
    """Deviations before the first touch."""

    velocity: Positive = 0.05
    """Velocity of the vehicle [m/s]."""
    wind: Positive = 0.5
    """Horizontal wind [N]."""
    draught: Positive = 0.2
    """Vertical wind [N]."""
    wind_turn: Positive = 0.1
    """Rate with which the wind turns [rad/s]."""
    gust: ClassVar = 0.15
    """Gust, as a share of the wind."""
    lift: Positive = 0.05
    """Lift of the rotors beyond their command, as a share of it."""
    joint: ClassVar = 0.02
    """Place of the leaf [rad]."""
    stop: ClassVar = 3e-3
    """Place of a leaf that is at its stop [rad]."""
    astray: ClassVar = 0.25
    """Place of a leaf that is not where it was believed to be [rad]."""
    joint_rate: Positive = 2e-3
    """Rate of the leaf [rad/s]."""
    astray_rate: ClassVar = 0.1
    """Rate of a leaf that is not where it was believed to be [rad/s]."""
    resistance: Positive = 0.6
    """Resistance of the joint [N m]."""
    log_inertia: ClassVar = 0.5
    """Logarithm of the leaf's inertia."""
    face: Positive = 1.5e-3
    """Place of a face that is known: a tip is softer or harder than assumed [m]."""
    reach: Positive = 0.02
    """Distance before the face at which a gripper closes [m]."""
    friction: Positive = 0.1
    """Friction of the tip [N]."""


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
    by_chance: Positive = 0.1
    """Deviation of what it resists with beside these, in still air [N m]."""
    in_wind: Positive = 0.3
    """Growth of that deviation with the wind on the vehicle [m]."""
    moves: Positive = 0.02
    """Rate of the leaf below which it tells nothing [rad/s]."""


class EstimationSection(Section):
    """How well door, frame of the poses and force sensor are known, and from when on the mission believes what it estimates."""

    sure: ClassVar = 0.8
    """Probability from which on the mission believes that the tip touches the leaf, or has left it."""
    loose_time: ClassVar = 0.12
    """Time for which a closed gripper must probably hold nothing, before it does not hold the leaf [s]."""
    slam_speed: ClassVar = 0.4
    """Speed with which a leaf throws a tip back that touches it, from which on it is slammed [m/s]."""
    gate: Positive = 8.0
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
    switch: SwitchNumbers = SwitchNumbers()
    noise: NoiseNumbers = NoiseNumbers()
    start: StartNumbers = StartNumbers()
    hinge: HingeNumbers = HingeNumbers()
