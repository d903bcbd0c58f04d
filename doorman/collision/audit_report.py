"""What an audit of the constraints found: collisions, and how conservative each row is."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from doorman.one_line import OneLine


@dataclass(frozen=True)
class Offender:
    """A configuration that the constraints allow although shapes overlap."""

    state: tuple[float, ...]
    """x = [Φ, α, 0, H] [rad]."""
    first: str
    second: str
    depth: float
    """[m]."""


@dataclass(frozen=True)
class RowConservatism:
    """What one row of the constraints forbids in vain."""

    name: str
    forbidden_share: float
    """Share of the collision-free configurations that this row forbids."""
    forbidden_alone_share: float
    """Share of the collision-free configurations that only this row forbids."""
    boundary_samples: int
    """How many samples were taken where this row is the active one."""
    boundary_clearance: float | None
    """Median of the exact clearance there, without the link that carries the tip against the leaf [m]."""


@dataclass(frozen=True, repr=False)
class AuditReport(OneLine):
    """Result of an audit."""

    sampled: int
    """Configurations drawn."""
    allowed: int
    """Configurations that the constraints allow and that went through FCL."""
    colliding: int
    """How many of them overlap by more than the tolerance."""
    worst: Offender | None
    """The deepest of them."""
    forbidden_free_share: float
    """Share of the drawn collision-free configurations that the constraints forbid."""
    rows: tuple[RowConservatism, ...]
    max_tilt: float
    """Tilt range that was sampled [rad]."""
    tolerance: float
    """[m]."""
    enough: int
    """Allowed configurations that an audit needs to say anything."""

    @property
    def ok(self) -> bool:
        """Whether there were enough allowed configurations and none of them collides."""
        return self.allowed >= self.enough and self.colliding == 0

    @property
    def reason(self) -> str:
        """The verdict in one sentence."""
        if self.allowed < self.enough:
            few = f"only {self.allowed}" if self.allowed else "none"
            return (
                f"{few} of {self.sampled} sampled configurations are allowed by the constraints, "
                f"{self.enough} are needed: the constraints contradict each other or leave no room"
            )
        if self.worst is not None:
            return (
                f"{self.colliding} of {self.allowed} allowed configurations collide, "
                f"the worst by {1e3 * self.worst.depth:.1f} mm: {self.worst.first} in {self.worst.second}"
            )
        return (
            f"none of {self.allowed} allowed configurations collides up to a tilt of {np.degrees(self.max_tilt):.0f}°"
        )

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain types, with `ok` and `reason`."""
        return {"ok": self.ok, "reason": self.reason, **asdict(self)}
