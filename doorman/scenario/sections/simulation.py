"""The simulated plant: physics, sensors and wind."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from doorman.scenario.sections.door_sensor import DoorSensorSection
from doorman.scenario.values import Angle, DoorAngle, NonNegative, Number, Positive, Section, Switch

Elsewhere = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1, le=1)]
"""By which a door may stand elsewhere than it is believed to [m], or be open farther [rad]."""
Turned = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1, le=1)]
"""By which it may be turned [rad]."""
Leaning = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-0.1, le=0.1)]
"""By which a hinge may lean [rad]."""
Share = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]
Ratio = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.2, le=5)]
"""Ratio of a true figure to the planner's."""
Lag = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1)]
"""Lag of an attitude loop [s]."""
DeadTime = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.3)]
"""After which a set point begins to act [s]."""
Catch = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=100)]
"""Torque of seal or latch [N m]: 100 N m are more than any vehicle here pushes with."""


class NoiseSection(Section):
    """Standard deviations of the simulated sensors' white noise."""

    position: NonNegative = 0.0005
    """Position of O_B [m]."""
    velocity: ClassVar = 0.005
    """Velocity of O_B [m/s]."""
    attitude: NonNegative = 0.001
    """Roll, pitch and yaw [rad]."""
    body_rates: ClassVar = 0.01
    """Angular velocity in the body frame [rad/s]."""
    arm_angles: ClassVar = 0.0005
    """Arm angles H [rad]."""
    arm_rates: ClassVar = 0.005
    """Arm rates Ḣ [rad/s]."""
    tip_force: ClassVar = 0.05
    """Force of the tip, where `sensors.tip_force` has a sensor of it [N]."""


class SensorsSection(Section):
    """How the simulated motion capture delivers position, velocity and attitude, and whether the tip has a force sensor."""

    latency: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)] = 0.0
    """Position, velocity, attitude and the arm's angles and rates come this long after they were true; body rates, from
    the gyroscope, do not [s]."""
    jitter: Share = 0.0
    """Largest further delay, drawn evenly for every pose; poses never overtake each other; up to 1 [s]."""
    rate: Positive | None = None
    """Poses per second, each held until the next [1/s]. Default: one at every tick."""
    dropout_rate: NonNegative = 0.0
    """Gaps without a new pose, per second without a gap; in a gap the last pose repeats [1/s]."""
    dropout_duration: ClassVar = 0.2
    """Longest gap; gaps are evenly spread from 0 to it [s]."""
    velocity: Literal["measured", "differenced"] = "measured"
    """`"measured"`: the true one with noise of its own; `"differenced"`: difference of the last two noisy positions, as
    a motion capture without velocities has it."""
    jump_rate: NonNegative = 0.0
    """Jumps of the frame in which poses are seen, at random times [1/s]."""
    jump: Share = 0.0
    """Standard deviation on every axis of where the frame stands after a jump; up to 1 [m]."""
    drift: NonNegative = 0.0
    """Speed at which the frame slides away, in a random horizontal direction [m/s]."""
    turn_rate: Number = 0.0
    """Rate at which the frame turns about the vertical through the world's origin [rad/s]."""
    swap_rate: NonNegative = 0.0
    """Times at which the cameras take markers for others, per second without a swap; poses are off meanwhile [1/s]."""
    swap_duration: ClassVar = 0.8
    """Longest swap; swaps are evenly spread from 0 to it [s]."""
    swap: ClassVar = 0.02
    """By which the position is off in a swap, in a random direction [m]."""
    swap_turn: ClassVar = 0.026
    """By which the attitude is off in a swap, about a random axis; −1 to 1 [rad]."""
    tip_force: Switch = False
    """Whether a tip that pushes has a sensor of the force with which it presses along the face's normal; it is not late."""


class GustSection(Section):
    """Wind in the simulation: a steady horizontal force that varies by chance, and a vertical one about zero."""

    vehicle: NonNegative = 0.0
    """F on the vehicle [N]."""
    leaf: NonNegative = 0.0
    """F on the leaf at half its width w; the torque in the hinge is F w/2 sin(d + ω t − α) [N]."""
    direction: Angle = 0.0
    """d, direction towards which the wind blows as the flight begins, from the world's x axis about z [rad]."""
    turn_rate: Number = 0.0
    """ω, rate at which that direction turns about z [rad/s]."""
    jump_rate: NonNegative = 0.0
    """Jumps of direction and strength, at random times [1/s]."""
    jump_angle: ClassVar = math.radians(45.0)
    """Angle by which a jump turns the direction, to a random side [rad]."""
    jump_strength: ClassVar = 0.3
    """The strength after a jump lies within this share of the mean, evenly spread."""
    draught: Number = 0.0
    """Force of a draught, positive away from the vehicle: on the closed leaf at half its width, where it fades as the door
    opens, and on the vehicle through the open doorway, where it grows [N]."""
    vertical: NonNegative = 0.0
    """Deviation of a vertical force on the vehicle, whose mean is 0 [N]."""
    variation: NonNegative = 0.15
    """v, deviation of the strength as a share of its mean."""
    correlation_time: ClassVar = 1.0
    """Correlation time of ξ, and of the vertical force [s]."""

    @property
    def draughty(self) -> bool:
        """Whether air is drawn through the doorway."""
        return self.draught != 0.0

    @property
    def blows(self) -> bool:
        """Whether there is any wind."""
        return self.vehicle > 0.0 or self.leaf > 0.0 or self.vertical > 0.0 or self.draughty


class HandSection(Section):
    """A hand on the leaf in the simulation, once a flight: it holds the leaf, or shoves it."""

    door_angle: DoorAngle | None = None
    """The leaf's angle at which the hand comes [rad]. Default: no hand."""
    duration: Positive = 3.0
    """Time after which the hand lets go [s]."""
    hold: NonNegative = 0.0
    """Largest torque with which it holds the leaf where it came; it gives way by 0.005 rad until then [N m]."""
    shove: Number = 0.0
    """Torque with which it turns the leaf: positive shuts the door, negative opens it [N m]."""


class WashSection(Section):
    """Rotors near floor, ceiling and wall."""

    ground: Switch = False
    """Whether the floor, at height 0, lifts a rotor above it."""
    ceiling: Positive | None = None
    """Height of a ceiling that lifts a rotor below it [m]. Default: none."""
    wall: NonNegative = 0.0
    """Force that draws a rotor to the leaf, where its blade tip touches the leaf's plane [N]."""


class SimulationSection(Section):
    """Simulated plant."""

    physics_rate: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=500, le=20_000)] = 1000.0
    """Steps of the physics per second [1/s]."""
    controller_rate: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=20, le=2000)] = 250.0
    """Measurements and commands per second [1/s]."""
    planner_latency_periods: ClassVar = 1
    """A plan is used this many planner periods after its state was measured."""
    motor_time_constant: NonNegative = 0.03
    """First-order lag of a rotor's thrust [s]."""
    attitude_lag: Lag = 0.1
    """True lag of the attitude loop behind set points of roll and pitch, whatever `vehicle.attitude_lag` believes; up to 1.
    PX4 1.17 has 0.16 to 0.18 s, ArduPilot 4.6 0.02 to 0.07 s; motors of 0.03 s let it be no quicker than 0.1 s here [s]."""
    attitude_dead_time: DeadTime = 0.0
    """True time after which a set point of the attitude begins to act; up to 0.3. Both autopilots have 0.05 to 0.08 s [s]."""
    attitude_overshoot: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.6)] = 0.01
    """By which a step of the attitude overshoots, as a share of it, before the motors add to it; up to 0.6."""
    command_rate: Positive | None = None
    """Commands that the autopilot takes per second [1/s]. Default: every one."""
    command_jitter: Share = 0.0
    """Largest delay of a command, drawn evenly for each; commands never overtake each other; up to 1 [s]."""
    torque_per_thrust: Positive = 0.016
    """A rotor's drag torque over its thrust [m]."""
    thrust_scale: Ratio = 1.0
    """True thrust of every rotor over the commanded one; 0.2 to 5."""
    thrust_fall: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.1)] = 0.0
    """Share of its thrust that a rotor loses per second, as the battery empties; up to 0.1 [1/s]."""
    vehicle_mass: Positive | None = None
    """True mass of the vehicle with its arm, all parts and their inertia in proportion [kg]. Default: the URDF's."""
    vehicle_com: tuple[Elsewhere, Elsewhere, Elsewhere] = (0.0, 0.0, 0.0)
    """True centre of mass less the URDF's, body frame; −1 to 1. Only the base link's mass moves [m]."""
    vehicle_inertia_scale: Ratio = 1.0
    """True moments of inertia of the base link over those that follow from its mass; 0.2 to 5."""
    vehicle_drag: NonNegative = 0.0
    """Force of the still air against the velocity in the plane of the rotors [N s/m]."""
    servo_torque_scale: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.05, le=5)] = 1.0
    """True torque limit of every servo of the arm over the URDF's; 0.05 to 5."""
    servo_backlash: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.2)] = 0.0
    """Play of every servo; up to 0.2 [rad]."""
    tip_friction: NonNegative = 0.8
    """Friction coefficient between tip and leaf."""
    gripper_force: NonNegative | None = None
    """Largest force with which the gripper holds, pull and force along the leaf together. A larger force tears it off,
    until the gripper is opened and closed again; one of 0 never closes, so that its tip only pushes [N]. Default: any."""
    door_damping: NonNegative | None = None
    """True damping of the hinge, if it differs from what the planner reads [N m s/rad]. Default: as `door.damping`."""
    door_friction: NonNegative | None = None
    """True friction of the hinge, if it differs from what the planner reads; where no file names it, that of a usual
    hinge (docs/check.md) [N m]. Default: as `door.friction`."""
    door_stiffness: NonNegative | None = None
    """True stiffness of a spring or closer, if it differs from what the planner reads [N m/rad]. Default: as
    `door.stiffness`."""
    door_preload: NonNegative | None = None
    """True preload of the closer, if it differs from what the planner reads; a door with one stops where it is closed
    [N m]. Default: as `door.preload`."""
    door_stiction: NonNegative | None = None
    """True stiction of the hinge, if it differs from what the planner reads [N m]. Default: as `door.stiction`."""
    door_rest_angle: Angle | None = None
    """True angle at which the spring is relaxed [rad]. Default: as `door.rest_angle`."""
    door_width: Positive | None = None
    """True width of leaf and doorway, if it differs from what the planner reads [m]. Default: the door's."""
    door_mass: Positive | None = None
    """True mass of the leaf, its inertia in proportion, if it differs from what the planner reads [kg]. Default: the
    door's."""
    door_offset: tuple[Elsewhere, Elsewhere, Elsewhere] = (0.0, 0.0, 0.0)
    """True place of leaf, frame and wall less the one that the planner reads, world frame; −1 to 1 [m]."""
    door_yaw: Turned = 0.0
    """Angle by which leaf, frame and wall are truly turned about the vertical through the hinge; −1 to 1 [rad]."""
    door_face_offset: Elsewhere | None = None
    """Distance by which the true leaf's face stands before the hinge axis, towards the vehicle; −1 to 1 [m]. Default:
    the door's."""
    door_ajar: Elsewhere = 0.0
    """Angle by which the true door is farther open than the planner reads, as a flight from the hover begins; −1 to 1
    [rad]."""
    door_seal: Catch = 0.0
    """Torque of a seal, which resists more than the hinge over the first degrees; up to 100 [N m]."""
    door_seal_angle: ClassVar = math.radians(2.0)
    """Opening up to which the seal resists; 0.002 to 0.35 [rad]."""
    door_latch: Catch = 0.0
    """Largest torque of a sprung catch on the closed leaf, beyond which the catch snaps; it catches a leaf that shuts;
    up to 100 [N m]."""
    door_latch_angle: ClassVar = 0.01
    """Opening at which the catch snaps; 0.002 to 0.35 [rad]."""
    door_lean: tuple[Leaning, Leaning] = (0.0, 0.0)
    """Angles by which the hinge's upper end leans towards the world's x and y; −0.1 to 0.1 [rad]."""
    door_backlash: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.2)] = 0.0
    """Play in the hinge, within which the leaf swings without friction; up to 0.2 [rad]."""
    noise: NoiseSection = NoiseSection()
    sensors: SensorsSection = SensorsSection()
    gust: GustSection = GustSection()
    hand: HandSection = HandSection()
    wash: WashSection = WashSection()
    door_sensor: DoorSensorSection = DoorSensorSection()
