"""Tables: a topic as columns, one for every entry of an array, with the names of axes where a field has axes."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from doorman.exceptions import DoormanError, how_to_install

_AXES = ("x", "y", "z")
_ANGLES = ("roll", "pitch", "yaw")
_ENTRIES = {
    **dict.fromkeys(
        ("position", "velocity", "acceleration", "force", "side_force", "tip_force", "body_rates", "wind", "disturbance"),
        _AXES,
    ),
    "attitude": _ANGLES,
    "door_place": ("x", "y", "yaw"),
    "door_place_deviation": ("x", "y", "yaw"),
}  # fmt: skip
"""Names of the entries of fields that are vectors in space; the entries of all others are numbered from 0."""


def columns(fields: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Columns of shape (m,) by name: `position_x`, `attitude_roll`, `arm_angles_0`, `states_50_8`."""
    named: dict[str, NDArray[Any]] = {}
    for field, values in fields.items():
        flat = values.reshape(len(values), -1).T
        names = _entry_names(field, values.shape[1:])
        if not named.keys().isdisjoint(names) or any(name in fields for name in names if name != field):
            names = [f"{field}[{name[len(field) + 1 :]}]" for name in names]  # another field has such a name
        named.update(zip(names, flat, strict=True))
    return named


def _entry_names(field: str, shape: tuple[int, ...]) -> list[str]:
    if not shape:
        return [field]
    axes = _ENTRIES.get(field, ())
    if len(shape) == 1 and shape[0] <= len(axes):
        return [f"{field}_{axis}" for axis in axes[: shape[0]]]
    return [f"{field}_{'_'.join(map(str, entry))}" for entry in itertools.product(*map(range, shape))]


def data_frame(time: NDArray[Any], fields: Mapping[str, NDArray[Any]]) -> Any:
    """A `pandas.DataFrame` with the time as index."""
    try:
        import pandas
    except ModuleNotFoundError as error:
        raise DoormanError(
            f"a data frame needs pandas, which is not installed; {how_to_install('pandas')}",
            allowed="the arrays without it",
        ) from error
    return pandas.DataFrame(columns(fields), index=pandas.Index(time, name="time"))
