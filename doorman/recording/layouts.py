"""Layouts of programs that show MCAP recordings: one table of panels, written as Foxglove and as PlotJuggler read it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree as xml

STATE = "mission.state"
"""Path of the mission's state, a text."""
_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")


class Panel(NamedTuple):
    """Curves that share an axis."""

    title: str
    """With the unit."""
    paths: tuple[str, ...]
    """`topic.field` or `topic.field[index]`."""


def _triple(path: str) -> tuple[str, ...]:
    return tuple(f"{path}[{index}]" for index in range(3))


PANELS = (
    Panel(
        "door angle: estimate, truth, measured [rad]",
        ("estimate.state[3]", "truth.door_angle", "door_sensor.door_angle"),
    ),
    Panel("tip force: estimate, along the normal [N]", ("estimate.normal_force", "truth.tip_normal_force")),
    Panel("position: measured, setpoint [m]", (*_triple("measurement.position"), *_triple("setpoint.position"))),
    Panel("attitude: measured, command [rad]", (*_triple("measurement.attitude"), *_triple("command.attitude"))),
    Panel("thrust [N]", ("command.thrust",)),
    Panel("disturbance estimate [N]", _triple("controller.disturbance")),
    Panel("planner's time [s]", ("plan.solve_time",)),
    Panel("plan's cost", ("plan.cost",)),
)
"""What simulated and real runs show; a run without a topic leaves its curve out."""


def foxglove() -> str:
    """Layout for Foxglove, as JSON: the mission's state above two columns of plots."""
    configs: dict[str, Any] = {
        "StateTransitions!mission": {
            "paths": [{"value": STATE, "timestampMethod": "receiveTime", "label": "mission"}],
            "isSynced": True,
        }
    }
    names = []
    for number, panel in enumerate(PANELS):
        names.append(f"Plot!panel{number}")
        configs[names[-1]] = _foxglove_plot(panel)
    half = (len(names) + 1) // 2
    plots = _split(_stacked(names[:half]), _stacked(names[half:]), "row", 50.0)
    layout = {
        "configById": configs,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split("StateTransitions!mission", plots, "column", 12.0),
    }
    return json.dumps(layout, indent=2) + "\n"


def _foxglove_plot(panel: Panel) -> dict[str, Any]:
    paths = [
        {"value": path, "enabled": True, "timestampMethod": "receiveTime", "label": path, "color": color}
        for path, color in zip(panel.paths, _COLORS, strict=False)
    ]
    return {
        "foxglovePanelTitle": panel.title, "paths": paths, "isSynced": True, "xAxisVal": "timestamp",
        "showXAxisLabels": True, "showYAxisLabels": True, "showLegend": True, "legendDisplay": "floating",
        "showPlotValuesInLegend": False, "sidebarDimension": 240,
    }  # fmt: skip


def _stacked(names: Sequence[str]) -> Any:
    """Panels below each other, each of the same height."""
    if len(names) == 1:
        return names[0]
    return _split(names[0], _stacked(names[1:]), "column", 100.0 / len(names))


def _split(first: Any, second: Any, direction: str, share: float) -> dict[str, Any]:
    return {"first": first, "second": second, "direction": direction, "splitPercentage": share}


def plotjuggler() -> str:
    """Layout for PlotJuggler, as XML: one tab with two columns of plots."""
    root = xml.Element("root")
    tabs = xml.SubElement(root, "tabbed_widget", {"parent": "main_window", "name": "Main Window"})
    container = xml.SubElement(xml.SubElement(tabs, "Tab", tab_name="doorman", containers="1"), "Container")
    columns = _splitter(container, "|", 2)
    half = (len(PANELS) + 1) // 2
    for panels in (PANELS[:half], PANELS[half:]):
        column = _splitter(columns, "-", len(panels))
        for panel in panels:
            _plotjuggler_plot(column, panel)
    xml.SubElement(tabs, "currentTabIndex", index="0")
    xml.SubElement(root, "use_relative_time_offset", enabled="1")
    xml.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + xml.tostring(root, encoding="unicode") + "\n"


def _splitter(parent: xml.Element, orientation: str, count: int) -> xml.Element:
    sizes = ";".join([f"{1.0 / count:.6f}"] * count)
    return xml.SubElement(parent, "DockSplitter", orientation=orientation, sizes=sizes, count=str(count))


def _plotjuggler_plot(parent: xml.Element, panel: Panel) -> None:
    area = xml.SubElement(parent, "DockArea", name=panel.title)
    plot = xml.SubElement(area, "plot", style="Lines", mode="TimeSeries", flip_x="false", flip_y="false")
    xml.SubElement(plot, "limitY")
    for path, color in zip(panel.paths, _COLORS, strict=False):
        xml.SubElement(plot, "curve", name=path.replace(".", "/", 1), color=color)
