"""Figure of the swing from above: leaf, rotor disc and arm at intervals, in the doorway."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.exceptions import RecordingError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.figures.phases import TIED
from doorman.visualization.scene.moments import Moment, recorded_moments
from doorman.visualization.style import BLACK, RED, Axes, Circle, Figure, colormaps, flight_name


def swing_figure(recording: Recording, model: Model) -> Figure:
    """The swing from above, or a hatch's from the side, from the touch until the tip lets go.

    Leaf, rotor disc, arm and the middle of the vehicle are drawn wherever the door has moved on by 14°, from dark to bright;
    the paths of vehicle and tip are lines. The doorway is at x = 0, the wall grey.

    Args:
        recording: With topic `truth`, or with `measurement` and `estimate`.
        model: Model of the scenario that was flown.

    Returns:
        The figure; `save` writes it.

    Raises:
        RecordingError: if the recording holds no motion.
    """
    moments = recorded_moments(recording)
    swing = [moment for moment in moments if moment.phase in TIED] or moments
    if not swing:
        raise RecordingError("no motion to draw", field="recording")
    figure = Figure(figsize=(8.6, 6.4), layout="constrained")
    axes = figure.subplots()
    _draw_doorway(axes, model)
    vehicle = np.array([_points(moment, model)[0] for moment in swing])
    tips = np.array([_points(moment, model)[-1] for moment in swing])
    (x, y), (tip_x, tip_y) = vehicle.T[:2], tips.T[:2]
    axes.plot(x, y, color=BLACK, linestyle="--", linewidth=1.2, label="vehicle's path", zorder=4)
    axes.plot(tip_x, tip_y, color=RED, linewidth=1.4, label="tip's path", zorder=4)
    chosen = _at_intervals(swing)
    colors = colormaps["cividis"](np.linspace(0.0, 0.9, max(len(chosen), 2)))
    for moment, color in zip(chosen, colors, strict=False):
        _draw_moment(axes, moment, model, tuple(float(value) for value in color))
    axes.set_aspect("equal")
    room = model.vehicle.radius + 0.1  # the usual ends, unless the disc reaches farther
    axes.set_xlim(min(-1.1, x.min() - room), max(1.35, x.max() + room))
    axes.set_xlabel("from the hinge through the doorway [m]")
    lies = model.true_door.lies
    axes.set_ylabel("above the hinge [m]" if lies else "from the hinge along the wall, to the left [m]")
    axes.grid(alpha=0.25)
    sizes = f"disc of {model.vehicle.radius:.2f} m,\nleaf of {model.true_door.width:.2f} m"
    figure.legend(fontsize=8, loc="outside right upper", title=sizes, title_fontsize=8)
    figure.suptitle(f"Swing from {'the side' if lies else 'above'}: {flight_name(recording)}", fontsize=11)
    return figure


def _at_intervals(swing: list[Moment], step: float = 14.0) -> list[Moment]:
    """The first, the last, and those at which the door has moved on by another step [deg]."""
    chosen = [swing[0]]
    for moment in swing[1:]:
        if abs(np.degrees(moment.door_angle - chosen[-1].door_angle)) >= step:
            chosen.append(moment)
    if abs(np.degrees(swing[-1].door_angle - chosen[-1].door_angle)) > 0.4 * step:
        chosen.append(swing[-1])
    return chosen


def _points(moment: Moment, model: Model) -> Array:
    """O_B, the constrained points of the arm and the tip, from the hinge, as in the picture."""
    rotation = rotation_body_to_world(moment.attitude)
    in_body = np.vstack([np.zeros(3), model.vehicle.point_positions(moment.arm_angles)])
    offset: Array = moment.position - model.true_door.hinge_position
    return _from_above(model.true_door, in_body @ rotation.T + offset)


def _from_above(door: Door, vectors: Array) -> Array:
    """Vectors with the way through the doorway to the right of the picture, (m, 3)."""
    return door.in_doorway(vectors) * [1.0, _upwards(door), 1.0]


def _upwards(door: Door) -> float:
    """1 where the way along the closed leaf points up in the picture, else −1."""
    return float(np.sign(door.along[2])) if door.lies else door.hand


def _draw_moment(axes: Axes, moment: Moment, model: Model, color: tuple[float, ...]) -> None:
    door = model.true_door
    ends = [door.contact_point(moment.door_angle, at, 0.0) - door.hinge_position for at in (0.0, door.width)]
    leaf = _from_above(door, np.array(ends))
    label = f"{door.in_words(moment.door_angle, 0)} at {moment.time:.1f} s"
    axes.plot(leaf[:, 0], leaf[:, 1], color=color, linewidth=3.0, solid_capstyle="butt", label=label, zorder=3)
    points = _points(moment, model)
    _draw_disc(axes, moment, model, points[0], color)
    axes.plot(points[:, 0], points[:, 1], color=color, linewidth=1.2, marker="o", markersize=2.5, zorder=3)


def _draw_disc(axes: Axes, moment: Moment, model: Model, center: Array, color: tuple[float, ...]) -> None:
    """The rotor disc from above; from the side, its rim."""
    radius = model.vehicle.radius
    if model.true_door.lies:
        turns = np.linspace(0.0, 2.0 * np.pi, 61)
        rim = radius * np.column_stack([np.cos(turns), np.sin(turns), 0.0 * turns])
        seen = center + _from_above(model.true_door, rim @ rotation_body_to_world(moment.attitude).T)
        axes.plot(seen[:, 0], seen[:, 1], color=color, linewidth=1.3, zorder=3)
        return
    axes.add_patch(Circle((center[0], center[1]), radius, facecolor=color, alpha=0.13, zorder=2))
    axes.add_patch(Circle((center[0], center[1]), radius, fill=False, edgecolor=color, linewidth=1.3, zorder=3))


def _draw_doorway(axes: Axes, model: Model, depth: float = 0.06) -> None:
    width = _upwards(model.true_door) * model.true_door.width
    for low, high in ((-np.copysign(0.35, width), 0.0), (width, width + np.copysign(0.35, width))):
        axes.fill_between([-depth, 0.0], low, high, color="0.55", linewidth=0, zorder=1)
    for jamb in (0.0, width):
        axes.axhline(jamb, color="0.55", linewidth=0.8, linestyle=":", zorder=1)
