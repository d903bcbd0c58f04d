"""The planner: its model and horizon, its weights, and what it may ask of vehicle, arm and tip."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from doorman.scenario.values import NonNegative, Positive, Section, Switch


class WeightsSection(Section):
    """Diagonals of the cost; by default the paper's, extended to the arm's number of joints."""

    state: tuple[NonNegative, ...] | None = None
    """Diagonal of Q in the order of the state: 5 + n entries, or 8 + n for `model = "lagrangian"`. Default: the
    paper's."""
    terminal: tuple[NonNegative, ...] | None = None
    """Diagonal of L, as many entries. Default: the paper's."""
    input: tuple[Positive, ...] | None = None
    """Diagonal of R, 4 + n entries in the order of the input. Default: the paper's."""


class PlannerSection(Section):
    """Receding-horizon planner."""

    model: Literal["quasi_static", "lagrangian", "whole_body"] | None = None
    """For a grip `"quasi_static"`, the default, or `"lagrangian"`; for a push `"whole_body"` (docs/theory.md).
    `"quasi_static"` is the paper's simplified dynamics: states [Φ, α, α̇, H], inputs [f_t, Ω, Ḣ_d]. `"lagrangian"` has
    the full dynamics of vehicle and door: states [Φ, α, Φ̇, α̇, H], inputs [f_t, T, Ḣ_d]. `"whole_body"` adds the
    vehicle's own motion: states [P, Φ, V, Φ̇, α, α̇, H], inputs [f_t, φ_c, θ_c, τ_z, Ḣ_d]. Default: by `contact.kind`."""

    time_step: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=0.5)] = 0.02
    """Δt between the plan's nodes [s]."""
    horizon_steps: Annotated[int, Field(strict=True, ge=2, le=2000)] = 50
    """N, number of steps."""
    rate: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=2000)] = 100.0
    """Plans per second [1/s]."""
    iterations: Annotated[int, Field(strict=True, ge=1, le=100)] = 1
    """Iterations of a warm plan; a cold one iterates until converged."""
    margin: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.5)] = 0.03
    """Distance that plans keep: h + margin ≤ 0. Where the tip pushes, that of the rotor disc is soft (docs/push.md) [m]."""
    weights: WeightsSection = WeightsSection()


class LimitsSection(Section):
    """What the planner may ask of vehicle and arm; joint angles are the URDF's, the largest thrust the vehicle's."""

    enabled: Switch = True
    """Whether the limits are constraints of the plan."""
    min_thrust: NonNegative = 0.0
    """Least thrust [N]."""
    body_rates: tuple[Positive, Positive, Positive] = (3.8, 3.8, 3.4)
    """Largest body rates about x, y and z, near a Pixhawk's defaults [rad/s]."""
    joint_rates: Positive | None = None
    """Largest rate of every joint [rad/s]. Default: the URDF's."""
    tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=math.pi / 2)] = 0.6
    """Largest angle between the body's z axis and the vertical [rad]."""


class PushSection(Section):
    """What a plan may ask of a tip that can only push (`contact.kind = "push"`)."""

    max_rate: Positive = 0.11
    """Largest rate of the door [rad/s]."""
    stopping_share: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=1)] = 0.2
    """η, share of the hinge's resistance that `doorman check` counts on to stop the door before the goal."""
    friction_coefficient: Positive = 0.6
    """μ between tip and leaf that a plan counts on."""
    hold_tolerance: Positive = 0.006
    """A gripped door that stands within this of the goal is open [rad]."""
