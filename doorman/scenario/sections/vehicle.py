"""The vehicle: its URDF, its limits, its controller and its planner."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from doorman.scenario.values import Name, NonNegative, Positive, Section, Switch


class RotorsSection(Section):
    """Rotors of a vehicle whose URDF does not name them."""

    assume: Switch = False
    """Whether six upright rotors on a ring are assumed where no rotor of the URDF has a thrust; else the check refuses that."""


class VehicleSection(Section):
    """Vehicle: its URDF and the names in it."""

    urdf: Name = "hexarotor_arm"
    """Name of a shipped URDF, or a path relative to the scenario's file."""
    base_link: Name = "base_link"
    """Link whose origin is O_B."""
    tip: Name = "tip"
    """Frame that touches the leaf."""
    radius: Positive | None = None
    """R_A, radius of the disc that holds the rotors [m]. Default: from the URDF's shapes or rotors."""
    max_thrust: Positive | None = None
    """Largest thrust of all rotors together [N]. Default: from the URDF."""
    rotors: RotorsSection = RotorsSection()
    attitude_lag: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1)] = 0.16
    """Believed lag of the autopilot's attitude loop behind its setpoints of roll and pitch. Plans, look-aheads and the
    check use it; the simulated loop has `simulation.attitude_lag`: the default of a grip that starts in contact [s]."""
    attitude_dead_time: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.3)] = 0.06
    """Believed time after which such a setpoint begins to act; up to 0.3. Plans begin, and the controller corrects, where the
    commands under way take the vehicle in that time [s]."""


class LimitsSection(Section):
    """What the planner may ask of vehicle and arm; joint angles are the URDF's, the largest thrust the vehicle's."""

    enabled: Switch = True
    """Whether the limits are constraints of the plan."""
    body_rates: tuple[Positive, Positive, Positive] = (3.8, 3.8, 3.4)
    """Largest body rates about x, y and z, near a Pixhawk's defaults [rad/s]."""
    joint_rates: Positive | None = None
    """Largest rate of every joint [rad/s]. Default: the URDF's."""
    tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=math.pi / 2)] = 0.6
    """Largest angle between the body's z axis and the vertical [rad]."""


class ControlSection(Section):
    """Gains and limits of the position controller and its observers."""

    yaw_gain: ClassVar = 4.0
    """Rate of the heading by its error in the vehicle's attitude loop [1/s]."""
    position_gain: tuple[Positive, Positive, Positive] = (4.0, 4.0, 6.0)
    """k_p along x, y, z [1/s²]."""
    velocity_gain: tuple[Positive, Positive, Positive] = (3.5, 3.5, 4.5)
    """k_d along x, y, z [1/s]."""
    observer_rate: Positive = 1.0
    """Bandwidth 1/τ of the disturbance observer [rad/s]."""
    observer_damping: ClassVar = 2.0
    """a_1 of its filter; 2 is critically damped."""
    door_observer_rate: NonNegative = 2.0
    """Bandwidth of the observer of the unknown hinge torque; 0 switches it off [rad/s]."""
    max_door_disturbance: Positive = 5.0
    """Largest share of that torque in plans with a grip; `max_push` bounds a push [N m]."""
    max_tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=math.pi / 2)] = 0.25
    """Bound of the commanded tilt [rad]."""
    max_push: Positive = 12.0
    """Largest force of the rotors beyond the weight while the tip is at the leaf, whatever is estimated or planned [N]."""


class WeightsSection(Section):
    """Diagonals of the cost; by default the paper's, extended to the arm's number of joints."""

    state: tuple[NonNegative, ...] | None = None
    """Diagonal of Q and L in the order of the state: 5 + n entries, or 8 + n for `model = "lagrangian"`. Default: the
    paper's."""
    input: tuple[Positive, ...] | None = None
    """Diagonal of R, 4 + n entries in the order of the input. Default: the paper's."""


class PlannerSection(Section):
    """Receding-horizon planner."""

    model: Literal["quasi_static", "lagrangian", "whole_body"] = "whole_body"
    """`"whole_body"`; of a grip also `"quasi_static"` or `"lagrangian"` (docs/theory.md). `"quasi_static"` is the paper's
    simplified dynamics: states [Φ, α, α̇, H], inputs [f_t, Ω, Ḣ_d]. `"lagrangian"` has the full dynamics of vehicle and
    door: states [Φ, α, Φ̇, α̇, H], inputs [f_t, T, Ḣ_d]. `"whole_body"` adds the vehicle's own motion: states
    [P, Φ, V, Φ̇, α, α̇, H], inputs [f_t, φ_c, θ_c, τ_z, Ḣ_d]."""

    time_step: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=0.5)] = 0.02
    """Δt between the plan's nodes [s]."""
    horizon_steps: Annotated[int, Field(strict=True, ge=2, le=2000)] = 50
    """N, number of steps."""
    rate: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=2000)] = 100.0
    """Plans per second [1/s]."""
    iterations: ClassVar = 1
    """Iterations of a warm plan; a cold one iterates until converged."""
    margin: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.5)] = 0.03
    """Distance that plans keep: h + margin ≤ 0. Where the tip pushes, that of the rotor disc is soft (docs/push.md) [m]."""
    weights: WeightsSection = WeightsSection()
