"""The simulated plant: physics, sensors and wind."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from doorman.scenario.values import Angle, DoorAngle, NonNegative, Number, Positive, Section, Switch

Elsewhere = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1, le=1)]
"""By which a door may stand elsewhere than it is believed to [m]."""
Turned = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1, le=1)]
"""By which it may be turned [rad]."""


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
    rate: Positive | None = None
    """Poses per second, each held until the next; by default one at every tick of the controller."""
    dropout_rate: NonNegative = 0.0
    """Gaps without a new pose, per second without one."""
    dropout_duration: NonNegative = 0.2
    """Longest gap [s]; gaps are evenly spread from 0 to it."""
    velocity: Literal["measured", "differenced"] = "measured"
    """Velocity with noise of its own, or the difference of the last two noisy positions."""


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
    variation: NonNegative = 0.15
    """Standard deviation of the force over its mean."""
    correlation_time: Positive = 1.0
    """Of the variation [s]."""


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
    tip_friction: NonNegative = 0.8
    """Coulomb coefficient between tip and leaf."""
    tip_stiffness: Positive = 2000.0
    """Compliance of a pushing tip [N/m]."""
    tip_damping: Positive = 60.0
    """[N s/m]."""
    grip_stiffness: Positive = 5000.0
    """Compliance of a gripping tip, in every direction [N/m]."""
    grip_damping: Positive = 100.0
    """[N s/m]."""
    gripper_closes: Switch = True
    """Whether the gripper closes when it is told to; one that does not is a tip that only pushes."""
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
    noise: NoiseSection = NoiseSection()
    sensors: SensorsSection = SensorsSection()
    gust: GustSection = GustSection()
    hand: HandSection = HandSection()
