"""The flight: controller, estimation and mission."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from doorman.scenario.values import NonNegative, Positive, Section


class ControlSection(Section):
    """Gains of the DOB position controller and of the state converter's look-ahead."""

    position_look_ahead: NonNegative = 0.04
    """The setpoints of position and velocity are the plan this long after the measured state [s]."""
    acceleration_look_ahead: NonNegative | None = None
    """Look-ahead of the acceleration fed forward [s]. Default: 1.2 times `vehicle.attitude_lag`, and
    `vehicle.attitude_dead_time`; what the hover measures takes their place."""
    attitude_look_ahead: NonNegative | None = None
    """Look-ahead of yaw and of the force fed forward, which act through the attitude loop [s]. Default: twice
    `vehicle.attitude_lag`, and `vehicle.attitude_dead_time`; likewise."""
    arm_look_ahead: Positive = 0.1
    """Joint rates are those that reach the plan's posture this long after the measured state [s]."""
    engage_pitch: Positive = 0.1
    """Largest difference of the commanded and the measured pitch at the start [rad]."""
    engage_rate: NonNegative = 0.2
    """Growth of that difference per second flown. With an arm that has mass, both are cut to what the rotors can answer
    [rad/s]."""
    yaw_gain: Positive = 4.0
    """Rate of the heading by its error in the vehicle's attitude loop [1/s]."""
    yaw_share: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1)] = 0.65
    """Share of the rotors' torque about the vertical, around half thrust, that plans of the whole body count on."""
    position_gain: tuple[Positive, Positive, Positive] = (4.0, 4.0, 6.0)
    """k_p along x, y, z [1/s²]."""
    velocity_gain: tuple[Positive, Positive, Positive] = (3.5, 3.5, 4.5)
    """k_d along x, y, z [1/s]."""
    observer_rate: Positive = 1.0
    """Bandwidth 1/τ of the disturbance observer [rad/s]."""
    observer_damping: Positive = 2.0
    """a_1 of its filter; 2 is critically damped."""
    max_disturbance: Positive = 10.0
    """Bound of the estimated disturbance on each axis [N]."""
    door_observer_rate: NonNegative = 2.0
    """Bandwidth of the observer of the unknown hinge torque; 0 switches it off [rad/s]."""
    max_door_disturbance: Positive = 5.0
    """The most of that torque that plans with a grip are told of; a push is bounded by `max_push` [N m]."""
    max_tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=math.pi / 2)] = 0.25
    """Bound of the commanded tilt [rad]."""
    max_push: Positive = 12.0
    """Largest force of the rotors beyond the weight while the tip is at the leaf, whatever is estimated or planned [N]."""


class ContactStateSection(Section):
    """When the tip counts as pressing on the leaf."""

    touched_above: Positive = 0.35
    """Estimated normal force above which the tip touches [N]."""
    touched_after: NonNegative = 0.06
    """Time above that force after which the tip touches [s]."""
    certain_above: Positive = 0.2
    """Estimated normal force above which the tip touches at once, if it also exceeds `certain_deviations` [N]."""
    certain_deviations: Positive = 5.0
    """Number of standard deviations of the same estimate in free flight."""
    arrived_within: NonNegative = 0.003
    """Distance from the leaf's believed place within which the tip has arrived [m]."""
    arrived_above: Positive = 0.12
    """Estimated normal force above which a tip that has arrived touches at once, if it also exceeds
    `arrived_deviations` [N]."""
    arrived_deviations: Positive = 1.3
    """Number of the same standard deviations."""
    lost_below: NonNegative = 0.08
    """Estimated normal force below which contact is lost [N]."""
    lost_after: NonNegative = 0.05
    """Time below that force after which contact is lost [s]."""


class EstimationSection(Section):
    """Observer of the vehicle and filter of the door; prior values are pairs of mean and standard deviation."""

    vehicle_observer_rate: Positive = 15.0
    """Bandwidth of the observer of velocity and outer force [rad/s]."""
    wind_rate: Positive = 1.0
    """Bandwidth of the wind's estimate in free flight; in contact the estimate fades to the average of free flight at
    this rate [rad/s]."""
    door_place_deviation: NonNegative = 0.015
    """Standard deviation of the hinge's place from the URDF's, along either horizontal axis; with `door_yaw_deviation`
    0 as well, the map is trusted [m]."""
    door_yaw_deviation: NonNegative = 0.026
    """Standard deviation of the doorway's heading [rad]."""
    frame_walk: NonNegative = 0.0
    """Standard deviation by which the frame of the poses walks in a second, along either horizontal axis; it grows with
    the root of the time [m/s^½]."""
    angle_deviation: Positive = 0.01
    """Standard deviation of the door's angle at the start [rad]."""
    angle_noise: Positive = 0.005
    """Standard deviation of the angle that the tip measures [rad]."""
    push_noise: Positive = 0.5
    """Density of the push's noise in still air [N s^½]."""
    push_noise_in_wind: NonNegative = 0.2
    """Growth of that density with the wind on the vehicle [s^½]."""
    torque_deviation: NonNegative = 0.05
    """Standard deviation of other torques in the hinge, which come and go, in still air [N m]."""
    torque_deviation_in_wind: NonNegative = 0.15
    """Growth of that deviation with the wind on the vehicle [m]."""
    torque_time: Positive = 2.0
    """Correlation time of these torques [s]."""
    tip_force_noise: Positive = 0.05
    """Standard deviation of the white noise of a force sensor in the tip, where there is one [N]."""
    tip_force_offset: NonNegative = 0.2
    """Standard deviation of that sensor's offset, until the readings of free flight tell it [N]."""
    leaf_wind: tuple[NonNegative, Positive] = (1.0, 0.5)
    """Wind on the leaf, in the direction of the wind on the vehicle, where there is any [N]."""
    leaf_wind_share: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)] = 0.7
    """Share by which its mean is nearer to the wind on the vehicle: 0 leaves it, 1 expects the same on both."""
    leaf_wind_deviation: Positive = 0.25
    """Standard deviation of the wind on the leaf, in every direction [N]."""
    damping: tuple[NonNegative, Positive] = (0.7, 0.7)
    """b of the hinge; the mean is what `[door]` or the URDF names, if anything [N m s/rad]."""
    friction: tuple[NonNegative, Positive] = (0.8, 0.6)
    """τ_c of the hinge; the mean is what `[door]` or the URDF names, if anything [N m]."""
    stiffness: tuple[NonNegative, Positive] = (0.5, 0.7)
    """k of a closer that is relaxed at the start; the mean is what `[door]` or the URDF names, if anything [N m/rad]."""
    inertia_deviation: Positive = 0.5
    """Standard deviation of I_D, as a share of the URDF's."""
    contact: ContactStateSection = ContactStateSection()


class MissionTimeOutsSection(Section):
    """Longest time of every phase [s]."""

    hover: Positive = 15.0
    """Until the vehicle hovers still before the door [s]."""
    touch_frame: Positive = 90.0
    """Until the frame has been touched everywhere [s]."""
    approach: Positive = 20.0
    """To `touch_distance` [s]."""
    touch: Positive = 30.0
    """Until the tip presses [s]."""
    open: Positive = 60.0
    """Until the door stands at the goal, after every touch [s]."""
    hold: Positive = 60.0
    """On a vehicle: time for a person to take a door that would not stay; then the vehicle leaves [s]."""
    recover: Positive = 6.0
    """Until contact is regained, or the tip has come nearer to the goal by 1°; three times that in all [s]."""
    take_back: Positive = 20.0
    """Until a gripped door that is given up is back where it was found [s]."""
    release: Positive = 8.0
    """Until the tip is away [s]."""
    retreat: Positive = 30.0
    """Until the vehicle hovers outside [s]."""
    through: Positive = 60.0
    """Until the vehicle hovers behind the doorway [s]."""


class MissionSection(Section):
    """From hover to hover."""

    start: Literal["hover", "contact"] = "hover"
    """`"hover"`: away from the door; `"contact"`: with the tip on the leaf."""
    then: Literal["return", "stay", "through"] = "return"
    """What follows at the goal: `"return"` to a hover before the door, `"stay"` with the tip on the leaf, which holds
    it, or `"through"` the doorway to a hover 1 m behind it. With `"stay"` a simulated mission ends there; a vehicle
    holds the door for `time_out.hold`."""
    hover_distance: Positive = 0.6
    """Distance between tip and leaf before the approach [m]."""
    touch_frame: bool = False
    """Whether the tip first touches wall and frame beside a door that it is to push, to find where that stands."""
    judge_poses: bool = True
    """Whether the hover before the door measures age and noise of the poses, and gives up where contact would not bear
    them."""
    measure_attitude: bool = True
    """Whether the hover before the door measures lag and dead time of the attitude loop, by steps of 1.7° in 4 s. Plans and
    controllers count on them, in place of `vehicle.attitude_lag`; the flight gives up where they were never tested."""
    approach_speed: Positive = 0.15
    """Speed of the approach [m/s]."""
    touch_distance: Positive = 0.06
    """Distance between tip and leaf at which the approach ends and the touch begins [m]."""
    touch_speed: Positive = 0.04
    """Speed of the touch [m/s]."""
    touch_force: Positive = 0.5
    """Force with which the tip presses after the touch [N]."""
    hold_time: Positive = 1.0
    """Time for which the door must stay at the goal before the vehicle lets it go [s]."""
    hold_open: NonNegative = 3.0
    """Time for which the vehicle holds a door whose closer would shut it on the vehicle [s]."""
    recoveries: Annotated[int, Field(strict=True, ge=0, le=100)] = 20
    """Largest number of losses of contact in an attempt."""
    attempts: Annotated[int, Field(strict=True, ge=1, le=10)] = 2
    """1 to 10: largest number of attempts from the hover; after a failure that may not happen again, the vehicle backs
    out and comes again."""
    retreat_speed: Positive = 0.25
    """Speed of the retreat [m/s]."""
    time_out: MissionTimeOutsSection = MissionTimeOutsSection()
