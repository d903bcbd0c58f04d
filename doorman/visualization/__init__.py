"""Figures, replay page and live view of a flight; needs the extra `viz`."""

from doorman.visualization.constraint_figure import constraints_and_forces_figure
from doorman.visualization.figures import states_figure
from doorman.visualization.live import LiveView
from doorman.visualization.pictures import PicturesMissing, write_pictures
from doorman.visualization.replay import replay_page
from doorman.visualization.style import save
from doorman.visualization.swing_figure import swing_figure
from doorman.visualization.timing_figure import planner_time_figure

__all__ = [
    "LiveView",
    "PicturesMissing",
    "constraints_and_forces_figure",
    "planner_time_figure",
    "replay_page",
    "save",
    "states_figure",
    "swing_figure",
    "write_pictures",
]
