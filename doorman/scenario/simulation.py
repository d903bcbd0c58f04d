"""The simulated plant: physics, sensors and wind."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from doorman.scenario.values import Angle, DoorAngle, NonNegative, Number, Positive, Section, Switch

Elsewhere = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1, le=1)]
"""By which a door may stand elsewhere than it is believed to [m], or be open farther [rad]."""
Turned = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1, le=1)]
"""By which it may be turned [rad]."""
Leaning = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-0.1, le=0.1)]
"""By which a hinge may lean [rad]."""
Share = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]
Ratio = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.2, le=5)]
"""Of a true figure to the one that the planner is told."""
Catch = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=100)]
"""Torque of seal or latch [N m]: 100 N m are more than any vehicle here pushes with."""
FirstDegrees = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.002, le=0.35)]
"""Opening up to which a seal or a latch acts, 0.1 to 20 degrees [rad]."""


class NoiseSection(Section):
    """Standard deviations of the simulated sensors' white noise."""

    position: NonNegative = 0.0005
    velocity: NonNegative = 0.005
    attitude: NonNegative = 0.001
    body_rates: NonNegative = 0.01
    arm_angles: NonNegative = 0.0005
    arm_rates: NonNegative = 0.005


class SensorsSection(Section):
    """How the simulated motion capture delivers position, velocity and attitude."""

    latency: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)] = 0.0
    """Pose and arm come this long after they were true [s]; body rates do not."""
    jitter: Share = 0.0
    """By up to this much more, evenly spread, another for every pose [s]; poses never overtake each other."""
    rate: Positive | None = None
    """Poses per second, each held until the next; by default one at every tick of the controller."""
    dropout_rate: NonNegative = 0.0
    """Gaps without a new pose, per second without one."""
    dropout_duration: NonNegative = 0.2
    """Longest gap [s]; gaps are evenly spread from 0 to it."""
    velocity: Literal["measured", "differenced"] = "measured"
    """Velocity with noise of its own, or the difference of the last two noisy positions."""
    jump_rate: NonNegative = 0.0
    """Jumps of the frame in which poses are seen [1/s], at random times."""
    jump: Share = 0.0
    """Standard deviation on every axis of where the frame stands after a jump [m]."""
    drift: NonNegative = 0.0
    """Speed at which the frame slides away, in a horizontal direction drawn by chance [m/s]."""
    turn_rate: Number = 0.0
    """At which it turns about the vertical through the world's origin [rad/s]."""


class GustSection(Section):
    """Wind in the simulation: a steady horizontal force that varies by chance."""

    vehicle: NonNegative = 0.0
    """Mean force on the vehicle [N]."""
    leaf: NonNegative = 0.0
    """Mean force on the leaf at half its width [N]; its share along the leaf's normal turns the door."""
    direction: Angle = 0.0
    """Towards which the wind blows as the flight begins, from the world's x axis about z [rad]."""
    turn_rate: Number = 0.0
    """Of that direction, about z [rad/s]."""
    jump_rate: NonNegative = 0.0
    """Jumps of that direction and of the strength [1/s], at random times."""
    jump_angle: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=math.pi)] = math.pi / 2
    """By which a jump turns the direction, to either side by chance [rad]."""
    jump_strength: Share = 0.0
    """By up to which share of the mean the strength after a jump is another one, evenly spread."""
    draught_vehicle: Number = 0.0
    """Force on the vehicle through the open doorway, along the closed leaf's normal [N]; it grows as the door opens."""
    draught_leaf: Number = 0.0
    """Force on the closed leaf at half its width, along its normal, positive opens [N]; it fades as the door opens."""
    variation: NonNegative = 0.15
    """Standard deviation of the force over its mean."""
    correlation_time: Positive = 1.0
    """Of the variation [s]."""

    @property
    def draughty(self) -> bool:
        """Whether air is drawn through the doorway."""
        return self.draught_vehicle != 0.0 or self.draught_leaf != 0.0

    @property
    def blows(self) -> bool:
        """Whether there is any wind."""
        return self.vehicle > 0.0 or self.leaf > 0.0 or self.draughty


class HandSection(Section):
    """A hand on the leaf in the simulation, once a flight: it holds the leaf, or shoves it."""

    door_angle: DoorAngle | None = None
    """The hand comes where the leaf has opened this far [rad]; by default there is none."""
    duration: Positive = 3.0
    """Then it lets go [s]."""
    hold: NonNegative = 0.0
    """Largest torque with which it holds the leaf where it came [N m]."""
    shove: Number = 0.0
    """Torque with which it turns the leaf, positive for growing α, which shuts the door [N m]."""


class WashSection(Section):
    """Rotors near floor, ceiling and wall."""

    ground: Switch = False
    """Whether the floor lifts a rotor above it."""
    ceiling: Positive | None = None
    """Height of a ceiling that lifts a rotor below it [m]; by default there is none."""
    wall: NonNegative = 0.0
    """Largest force towards the wall of the door, at a rotor's blade tip that touches it [N]."""


class SimulationSection(Section):
    """Simulated plant."""

    physics_rate: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=500, le=20_000)] = 1000.0
    controller_rate: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=20, le=2000)] = 250.0
    planner_latency_periods: Annotated[int, Field(strict=True, ge=0, le=20)] = 1
    """A plan is used this many planner periods after the state it starts from was measured."""
    motor_time_constant: NonNegative = 0.03
    """First-order lag of a rotor's thrust [s]."""
    torque_per_thrust: Positive = 0.016
    """Ratio of a rotor's drag torque to its thrust [m]."""
    thrust_scale: Ratio = 1.0
    """True thrust of every rotor over the commanded one."""
    thrust_fall: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.1)] = 0.0
    """Share of it that a rotor loses in a second, as the battery empties [1/s]."""
    vehicle_mass: Positive | None = None
    """True mass of the vehicle with its arm [kg], all its parts and their inertia in proportion; by default the URDF's."""
    vehicle_com: tuple[Elsewhere, Elsewhere, Elsewhere] = (0.0, 0.0, 0.0)
    """By which the true centre of mass lies elsewhere than in the URDF, body frame [m]; the base link is at fault."""
    vehicle_inertia_scale: Ratio = 1.0
    """True moments of inertia of the base link over those that follow from its mass."""
    vehicle_drag: NonNegative = 0.0
    """Force of the still air in the plane of the rotors, against the velocity there [N s/m]."""
    servo_torque_scale: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.05, le=5)] = 1.0
    """True torque limit of every servo of the arm over the URDF's."""
    servo_backlash: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.2)] = 0.0
    """Play of every servo, between its stops: what it measures follows the joint no closer [rad]."""
    tip_friction: NonNegative = 0.8
    """Coulomb coefficient between tip and leaf."""
    tip_stiffness: Positive | None = None
    """Compliance of a pushing tip [N/m]; by default 2000 N/m of the shipped vehicle's, in proportion to weight and R_A."""
    tip_damping: Positive | None = None
    """Its damping [N s/m]; by default 60 N s/m in that proportion."""
    grip_stiffness: Positive | None = None
    """Compliance of a gripping tip, in every direction [N/m]; by default 5000 N/m in that proportion."""
    grip_damping: Positive | None = None
    """Its damping [N s/m]; by default 100 N s/m in that proportion."""
    gripper_closes: Switch = True
    """Whether the gripper closes when it is told to; one that does not is a tip that only pushes."""
    gripper_force: Positive | None = None
    """Largest force with which the gripper holds, pull and force along the leaf together [N]; by default any. A larger one
    tears it off the leaf, and it holds nothing until it is opened and closed again."""
    door_damping: NonNegative | None = None
    """True damping of the hinge [N m s/rad]; by default what the planner is told."""
    door_friction: NonNegative | None = None
    """True Coulomb friction of the hinge [N m]; by default what the planner is told."""
    door_stiffness: NonNegative | None = None
    """True stiffness of a spring or closer [N m/rad]; by default what the planner is told."""
    door_preload: NonNegative | None = None
    """True torque with which a closer shuts the door at any opening [N m]; by default what the planner is told."""
    door_stiction: NonNegative | None = None
    """True torque by which a standing hinge resists more than one that moves [N m]; by default what the planner is told."""
    door_rest_angle: Angle | None = None
    """Where that spring is relaxed [rad]; by default what the planner is told."""
    door_width: Positive | None = None
    """True width of leaf and doorway [m]; by default what the planner is told."""
    door_mass: Positive | None = None
    """True mass of the leaf [kg], its inertia in proportion; by default what the planner is told."""
    door_offset: tuple[Elsewhere, Elsewhere, Elsewhere] = (0.0, 0.0, 0.0)
    """By which leaf, frame and wall truly stand elsewhere than the planner is told, world frame [m]."""
    door_yaw: Turned = 0.0
    """By which they are truly turned about the vertical through the hinge [rad]."""
    door_face_offset: Elsewhere | None = None
    """By which the face of the true leaf stands before the hinge axis, towards the vehicle [m]; by default what the planner is
    told."""
    door_ajar: Elsewhere = 0.0
    """By which the door truly is farther open than the planner is told, as a flight from the hover begins [rad]."""
    door_seal: Catch = 0.0
    """Torque by which a seal resists more than the hinge over the first degrees, either way [N m]."""
    door_seal_angle: FirstDegrees = math.radians(2.0)
    """Opening up to which it does [rad]."""
    door_latch: Catch = 0.0
    """Largest torque with which a sprung catch holds the closed leaf [N m]; beyond it snaps, and catches a leaf that shuts."""
    door_latch_angle: FirstDegrees = 0.01
    """Opening at which it snaps [rad]."""
    door_lean: tuple[Leaning, Leaning] = (0.0, 0.0)
    """By which the hinge's upper end leans towards the world's x and y [rad]: the leaf's weight turns it."""
    door_backlash: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.2)] = 0.0
    """Play in the hinge: so far the leaf swings without friction after it turns back [rad]."""
    noise: NoiseSection = NoiseSection()
    sensors: SensorsSection = SensorsSection()
    gust: GustSection = GustSection()
    hand: HandSection = HandSection()
    wash: WashSection = WashSection()
