"""What a plan takes the door's hinge for."""

from __future__ import annotations

from typing import NamedTuple


class Hinge(NamedTuple):
    """What is known of a hinge and is not the same in every plan, SI units."""

    friction: float
    """τ_c [N m]."""
    disturbance: float
    """τ_d of α̈ = … − τ_d/I_D, in the sense of damping: negative where it resists opening [N m]."""
    inertia: float
    """I_D of the leaf about the hinge [kg m²]."""
