"""Figures, replay page and live view of a flight; needs the extra `viz`.

A name brings in its module at its first use: matplotlib takes a second, and a page needs none of it.
"""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING

from doorman.exceptions import DoormanError, how_to_install
from doorman.lazy_names import lazy_names

if TYPE_CHECKING:  # the types of the names below; no layer hides an import here
    from doorman.visualization.figures.constraints import constraints_and_forces_figure
    from doorman.visualization.figures.states import paper_figure, states_figure
    from doorman.visualization.figures.swing import swing_figure
    from doorman.visualization.figures.timing import planner_time_figure
    from doorman.visualization.live import LiveView
    from doorman.visualization.pictures import PicturesMissing, write_pictures
    from doorman.visualization.replay import replay_page
    from doorman.visualization.style import save

__all__ = [
    "LiveView", "PicturesMissing", "constraints_and_forces_figure", "paper_figure", "planner_time_figure", "replay_page",
    "save", "states_figure", "swing_figure", "write_pictures",
]  # fmt: skip

_MODULES = {
    "LiveView": "live",
    "PicturesMissing": "pictures",
    "constraints_and_forces_figure": "figures.constraints",
    "paper_figure": "figures.states",
    "planner_time_figure": "figures.timing",
    "replay_page": "replay",
    "save": "style",
    "states_figure": "figures.states",
    "swing_figure": "figures.swing",
    "write_pictures": "pictures",
}

if importlib.util.find_spec("matplotlib") is None:
    raise DoormanError("figures need matplotlib", field="matplotlib", allowed=how_to_install("viz"))

if not TYPE_CHECKING:  # a type checker would take any name for granted
    __getattr__, __dir__ = lazy_names(__name__, _MODULES)
