"""Numbers of the filter at the leaf that are the same in every laboratory: how a touch goes.

Those that differ by laboratory and vehicle are keys of `[estimation]`. `doorman estimate` replays a flight with any other value.
"""

from __future__ import annotations

from collections.abc import Mapping

from doorman.scenario.sized_keys import FORCE, LENGTH, RATE, RESISTANCE, SPEED, STIFFNESS

FIXED = ""
"""Unit of what does not grow with the vehicle."""
CONSTANTS: Mapping[str, tuple[float, str]] = {
    # What holds while the tip touches the leaf, and how nearly.
    "contact.stiffness": (1500.0, STIFFNESS),  # stiffness of tip and face [N/m]
    "contact.gap": (1e-3, LENGTH),  # deviation of tip and face while they touch: their shapes and compliance [m]
    "contact.pull": (0.15, FORCE),  # pull that a tip which only pushes may seem to make, by errors of thrust [N]
    "contact.friction": (0.3, FIXED),  # deviation of the tip's friction, as a share of the normal force
    "contact.gap_rate": (5e-3, SPEED),  # deviation of the speeds of tip and face [m/s]
    "contact.slip_rate": (5e-3, SPEED),  # deviation of the tip's speed in the face where it grips [m/s]
    "contact.inside": (3e-3, LENGTH),  # depth by which a free tip may seem to be in the face [m]
    "contact.lasts": (0.05, FIXED),  # time for which such an error stays: a few poses [s]
    "contact.friction_lasts": (5.0, FIXED),  # time after which a tip that creeps has lost the friction that it had [s]
    "contact.held": (0.1, FIXED),  # force across the face of a grip beside friction, as a share of the vehicle's weight
    "contact.settles": (0.05, FIXED),  # time in which a leaf that stops comes to stand [s]
    "contact.sticks": (
        0.3,
        FIXED,
    ),  # time after which a leaf that stands is believed to resist with more than it bears [s]
    "contact.more": (0.2, RESISTANCE),  # torque by which it then resists more, on average [N m]
    "contact.brakes": (0.01, FIXED),  # time in which friction stops a free leaf at the soonest [s]
    "contact.creeps": (0.02, FIXED),  # rate below which a free leaf's friction fades [rad/s]
    "contact.ajar": (0.05, FIXED),  # opening from which on a closer may draw the leaf back, not held by its stop [rad]
    "contact.swings": (0.5, FORCE),  # deviation of a force sensor in the tip from the force of a stiff contact [N]
    # How often what tip and leaf do changes.
    "switch.near": (4e-3, LENGTH),  # gap from which on a touch is near [m]
    "switch.make": (30.0, FIXED),  # touches of a near tip [1/s]
    "switch.far": (0.05, FIXED),  # touches of a tip that is away, or that feels for a frame [1/s]
    "switch.reach": (0.1, LENGTH),  # largest gap of those: no leaf comes so far without being felt [m]
    "switch.lose": (0.1, FIXED),  # touches that end [1/s]
    "switch.leave": (10.0, FIXED),  # touches that end where the tip is to come off the leaf [1/s]
    "switch.follow": (
        1.0,
        FIXED,
    ),  # touches of a near tip then: a leaf that stays is likelier than one that follows [1/s]
    "switch.slip": (2e-3, FIXED),  # grips that end [1/s]
    "switch.jump": (1e-3, FIXED),  # winds that jump: rare, and plain when they do [1/s]
    "switch.calm": (5.0, FIXED),  # jumps that end [1/s]
    "switch.throw": (0.02, FIXED),  # gripped leaves that a hand or a gust throws or catches [1/s]
    "switch.stop": (1.0, FIXED),  # leaves that come to rest, or begin to move [1/s]
    # What changes slowly, or by what is not in the model: deviations after one second.
    "noise.bounce": (0.02, FIXED),  # normal force, as a share of it: the tip swings on its compliance [s^½]
    "noise.jump": (3.0, FORCE),  # wind that jumps: by about 1 N in 0.1 s [N/s^½]
    "noise.velocity": (0.025, SPEED),  # velocity of the vehicle, by rough air and errors of thrust [m/s^1.5]
    "noise.gust": (0.15, FIXED),  # strength of the wind, as a share of its mean
    "noise.lift": (0.003, FIXED),  # lift of the rotors, as a share: batteries sag [1/s^½]
    "noise.resistance": (0.35, RESISTANCE),  # wind on the leaf, and friction that differs by place [N m/s^½]
    "noise.gust_lasts": (1.0, FIXED),  # time for which a gust stays [s]
    "noise.draught": (0.05, FORCE),  # vertical wind [N/s^½]
    "noise.wind_turn": (1e-3, RATE),  # rate with which the wind turns [rad/s^1.5]
    "noise.rate": (0.05, RATE),  # rate of the leaf, by forces that are not in the model [rad/s^1.5]
    "noise.throw": (3.0, RATE),  # rate of a gripped leaf that is thrown: by 1 rad/s in 0.1 s [rad/s^1.5]
    "noise.thrown_along": (2.0, SPEED),  # velocity of the vehicle that goes along then [m/s^1.5]
    "noise.drawn": (0.3, FIXED),  # share of the resistance that draws an open leaf back, a closer [s^½]
    "noise.gives": (1.0, FIXED),  # share of what a leaf that rests bears, which may give way [1/s^½]
    "noise.inertia": (0.05, FIXED),  # logarithm of the leaf's inertia [1/s^½]
    "noise.face": (2e-5, LENGTH),  # place of the face [m/s^½]
    "noise.face_by_angle": (0.5, FIXED),  # place of a face that a sensor sees, as a share of the map's doubt [1/s^½]
    # Deviations before the first touch.
    "start.velocity": (0.05, SPEED),  # velocity of the vehicle [m/s]
    "start.wind": (0.5, FORCE),  # horizontal wind [N]
    "start.lift": (0.05, FIXED),  # lift of the rotors beyond their command, as a share of it
    "start.face": (1.5e-3, LENGTH),  # place of a face that is known: a tip is softer or harder than assumed [m]
    "start.draught": (0.2, FORCE),  # vertical wind [N]
    "start.wind_turn": (0.1, RATE),  # rate with which the wind turns [rad/s]
    "start.gust": (0.15, FIXED),  # gust, as a share of the wind
    "start.joint": (0.02, FIXED),  # place of the leaf [rad]
    "start.stop": (3e-3, FIXED),  # place of a leaf that is at its stop [rad]
    "start.astray": (0.25, FIXED),  # place of a leaf that is not where it was believed to be [rad]
    "start.joint_rate": (2e-3, RATE),  # rate of the leaf [rad/s]
    "start.astray_rate": (0.1, FIXED),  # rate of a leaf that is not where it was believed to be [rad/s]
    "start.resistance": (0.6, RESISTANCE),  # resistance of the joint [N m]
    "start.log_inertia": (0.5, FIXED),  # logarithm of the leaf's inertia
    "start.reach": (0.02, LENGTH),  # distance before the face at which a gripper closes [m]
    "start.friction": (0.1, FORCE),  # friction of the tip [N]
}
"""Value for the shipped vehicle, and the unit as which it grows with another one, by name."""
