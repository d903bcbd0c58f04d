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
    """The same for the acceleration fed forward [s]; by default 1.2 times `vehicle.attitude_lag`."""
    attitude_look_ahead: NonNegative | None = None
    """The same for yaw and for the force fed forward, which act through the attitude loop [s]; by default twice that lag."""
    arm_look_ahead: Positive = 0.1
    """Joint rates are those that reach the plan's posture this long after the measured state [s]."""
    engage_pitch: Positive = 0.1
    """At the start, the commanded pitch may differ from the measured one by this much [rad], and"""
    engage_rate: NonNegative = 0.2
    """by this much more for every second flown [rad/s]: with the tip tied, a jump would overload the arm's servos. With an arm
    that has mass, both are cut to what the rotors can answer."""
    yaw_gain: Positive = 4.0
    """Rate of the heading by its error in the vehicle's attitude loop [1/s]."""
    yaw_share: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1)] = 0.65
    """Share of the rotors' torque about the vertical, around half thrust, that plans of the whole body count on."""
    position_gain: tuple[Positive, Positive, Positive] = (4.0, 4.0, 6.0)
    """k_p [1/s²]."""
    velocity_gain: tuple[Positive, Positive, Positive] = (3.5, 3.5, 4.5)
    """k_d [1/s]."""
    observer_rate: Positive = 1.0
    """Bandwidth of the disturbance observer, 1/τ [rad/s]."""
    observer_damping: Positive = 2.0
    """a_1 of Q(s) = a_0/((τs)² + a_1 τs + a_0), a_0 = 1: 2 is critically damped."""
    max_disturbance: Positive = 10.0
    """Bound of the estimated disturbance, each axis [N]."""
    door_observer_rate: NonNegative = 2.0
    """Bandwidth of the observer of the unknown hinge torque [rad/s]; 0 switches it off."""
    max_door_disturbance: Positive = 5.0
    """Bound of that torque's estimate [N m]."""
    max_tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=math.pi / 2)] = 0.25
    """[rad]."""
    max_push: Positive = 12.0
    """Largest force of the rotors beyond the weight while the tip is at the leaf, whatever is estimated or planned [N]."""


class ContactStateSection(Section):
    """When the tip counts as pressing on the leaf."""

    touched_above: Positive = 0.35
    """Estimated normal force above which it touches [N],"""
    touched_after: NonNegative = 0.06
    """for so long [s],"""
    certain_above: Positive = 0.2
    """or, without delay, above this [N]"""
    certain_deviations: Positive = 5.0
    """and above so many standard deviations of the same estimate in free flight."""
    arrived_within: NonNegative = 0.003
    """Distance from where the leaf is believed to stand at which a tip that comes to touch it has arrived [m]; it touches"""
    arrived_above: Positive = 0.12
    """above this force [N]"""
    arrived_deviations: Positive = 1.3
    """and above so many of those deviations, without delay."""
    lost_below: NonNegative = 0.08
    """Estimated normal force below which contact is lost [N],"""
    lost_after: NonNegative = 0.05
    """for so long [s]."""


class EstimationSection(Section):
    """Observer of the vehicle and filter of the door; prior values are pairs of mean and standard deviation."""

    vehicle_observer_rate: Positive = 15.0
    """Bandwidth of the observer of velocity and outer force [rad/s]."""
    wind_rate: Positive = 1.0
    """Bandwidth of the wind's estimate in free flight [rad/s]; in contact it fades to the average of free flight so fast."""
    door_place_deviation: NonNegative = 0.015
    """Of the hinge from where the URDF has it, along either horizontal axis [m],"""
    door_yaw_deviation: NonNegative = 0.026
    """and of the doorway's heading [rad]. A leaf that is met up to three times as far off closed as these explain counts as
    closed: the map is off. 0 for both trusts the map."""
    angle_deviation: Positive = 0.01
    """Of the door's angle at the start [rad]."""
    angle_noise: Positive = 0.005
    """Of the angle that the tip measures [rad]."""
    push_noise: Positive = 0.5
    """Density of the push's noise in still air [N s^½],"""
    push_noise_in_wind: NonNegative = 0.2
    """and how it grows with the wind on the vehicle [s^½]."""
    torque_deviation: NonNegative = 0.05
    """Of torques in the hinge that come and go, in still air [N m],"""
    torque_deviation_in_wind: NonNegative = 0.15
    """and how it grows with the wind on the vehicle [m];"""
    torque_time: Positive = 2.0
    """their correlation time [s]."""
    leaf_wind: tuple[NonNegative, Positive] = (1.0, 0.5)
    """On the leaf, in the direction of the wind on the vehicle, where there is any [N];"""
    leaf_wind_share: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)] = 0.7
    """its mean is as much nearer to what the vehicle feels: 0 leaves it there, 1 expects the same on both."""
    leaf_wind_deviation: Positive = 0.25
    """Of the wind on the leaf in every direction [N]."""
    damping: tuple[NonNegative, Positive] = (0.7, 0.7)
    """b [N m s/rad]."""
    friction: tuple[NonNegative, Positive] = (0.8, 0.6)
    """τ_c [N m]."""
    stiffness: tuple[NonNegative, Positive] = (0.5, 0.7)
    """k, of a closer that is relaxed at the start [N m/rad]."""
    inertia_deviation: Positive = 0.5
    """Of I_D, as a share of the URDF's."""
    contact: ContactStateSection = ContactStateSection()


class MissionTimeOutsSection(Section):
    """Longest time of every phase [s]."""

    hover: Positive = 15.0
    approach: Positive = 20.0
    touch: Positive = 30.0
    open: Positive = 60.0
    hold: Positive = 60.0
    """On a vehicle, for somebody to take a door that would not stay by itself; it is left then."""
    recover: Positive = 6.0
    """Without coming nearer to the goal by a degree; three times that in all."""
    release: Positive = 8.0
    retreat: Positive = 30.0
    through: Positive = 60.0


class MissionSection(Section):
    """From hover to hover."""

    start: Literal["hover", "contact"] = "hover"
    """Where a flight begins: away from the door, or with the tip on the leaf."""
    then: Literal["return", "stay", "through"] = "return"
    """What follows where the door stands at its goal: back to a hover before it, the tip stays and holds it, or the vehicle lets
    go and flies through the doorway to a hover 1 m behind it."""
    hover_distance: Positive = 0.6
    """Between tip and leaf before the approach [m]."""
    approach_speed: Positive = 0.15
    """[m/s]."""
    touch_distance: Positive = 0.06
    """From here on the tip goes on at [m]"""
    touch_speed: Positive = 0.04
    """this speed [m/s]."""
    touch_force: Positive = 0.5
    """With which the tip presses after the touch [N]."""
    hold_time: Positive = 1.0
    """For which the door must stay at the goal before it is let go [s]."""
    hold_open: NonNegative = 3.0
    """For which a door is held whose closer would shut it on the vehicle; a simulated mission ends there [s]."""
    recoveries: Annotated[int, Field(strict=True, ge=0, le=100)] = 20
    """How often contact may be lost before an attempt is given up."""
    attempts: Annotated[int, Field(strict=True, ge=1, le=10)] = 2
    """How often the vehicle comes from the hover at most: after a failure that may not happen again it backs out first."""
    retreat_speed: Positive = 0.25
    """[m/s]."""
    time_out: MissionTimeOutsSection = MissionTimeOutsSection()
