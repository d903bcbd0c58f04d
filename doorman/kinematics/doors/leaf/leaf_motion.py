r"""How a leaf moves with its door's angle α: a hinge and a slide are one motion with other numbers.

In the doorway, with the unit vectors i (through the closed leaf), a (along it) and u (up along the hinge), the turn t and the
slide s, 1 and 0 of a hinge, 0 and r of a slide:

.. math::
    \alpha' = \tfrac\pi2 + t\,(\alpha - \tfrac\pi2),\quad
    c = \cos\alpha'\,i + \sin\alpha'\,a,\quad n = \sin\alpha'\,i - \cos\alpha'\,a,\quad w = s\,(\alpha - \tfrac\pi2)

    p = P_h + D_V\,c - (o + w)\,n + D_H\,u,\quad J = -(t\,D_V + s)\,n - t\,o\,c,\quad G = w_c\,c_z - w_n\,n_z

c is the leaf's direction, n its normal, w its way towards the vehicle, p the contact point, J its lever, and G the torque of the
leaf's weight in the sense of damping. α of a slide is its way over a radius r, as of a wheel that rolls along it: a radian is the
way of a tip at a handle, so that whatever is said of swings in radians holds for slides.

This is plain arithmetic: the same lines serve numbers, symbols (`leaf_symbols`) and compiled kernels (`leaf_kernels`). Vectors
are components or whole ones.
"""

from __future__ import annotations

import math
from typing import Any

SLIDE_RADIUS = 0.4
"""r: the lever of a small door's handle. 1.5° of α are 1 cm [m]."""
CLOSED = 0.5 * math.pi
"""α of the closed door [rad]."""


def turned(turn: Any, door_angle: Any) -> Any:
    """α', by which the leaf has turned [rad]."""
    return turn * door_angle + (1.0 - turn) * CLOSED


def leaf_in_doorway(cosine: Any, sine: Any) -> tuple[Any, Any]:
    """Parts of c along i and a, given cos α' and sin α'."""
    return cosine, sine


def normal_in_doorway(cosine: Any, sine: Any) -> tuple[Any, Any]:
    """Parts of n along i and a."""
    return sine, -cosine


def way(slide: Any, door_angle: Any) -> Any:
    """Way w of the leaf against n, from closed [m]."""
    return slide * (door_angle - CLOSED)


def contact_from_hinge(distance: Any, before: Any, height: Any, leaf: Any, normal: Any, up: Any) -> Any:
    """A place of the leaf from P_h: D_V along it, o + w before the hinge's axis, D_H above its lower edge [m]."""
    return distance * leaf - before * normal + height * up


def lever_length(turn: Any, slide: Any, distance: Any) -> Any:
    """Speed of the contact point against the normal for a unit rate of α, −nᵀJ [m]."""
    return turn * distance + slide


def lever(turn: Any, slide: Any, distance: Any, offset: Any, leaf: Any, normal: Any) -> Any:
    """J, how α moves the contact point [m]."""
    return -(turn * distance + slide) * normal - turn * offset * leaf


def weight_torque(of_normal: Any, of_leaf: Any, leaf_up: Any, normal_up: Any) -> Any:
    """G, given `Door.weight` and the upward parts of c and n [N m]."""
    return of_leaf * leaf_up - of_normal * normal_up


def angle_of_face(turn: float, slide: float, before: float, distance: float) -> float:
    """By how much α of a point is less if the face stands before its place [rad]."""
    return math.asin(before / distance) if turn != 0.0 else before / slide


def angle_of(turn: float, slide: float, into: float, along: float, offset: float, middle: float) -> float:
    r"""α at which a point is on the face, given its parts from P_h; of a hinge within half a turn of the middle [rad].

    .. math:: \mathrm{atan2}(a^T r,\ i^T r) - \arcsin(o/|r|)\quad\text{or}\quad\tfrac\pi2 - (i^T r + o)/s
    """
    if turn == 0.0:
        return CLOSED - (into + offset) / slide
    away = math.hypot(along, into)
    before = math.asin(min(max(offset / away, -1.0), 1.0)) if away > 0.0 else 0.0
    beside = math.atan2(along, into) - before - middle
    return middle + beside - 2.0 * math.pi * round(beside / (2.0 * math.pi))
