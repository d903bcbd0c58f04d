"""Listeners of a flight: the page that shows it while it is flown, and the feed of `doorman ros2`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress

import typer

from doorman.cli.terminal.display import show_in_browser
from doorman.model import Model
from doorman.recording import Listener
from doorman.recording.files.messages import Value


@contextmanager
def live_view(model: Model, port: int | None) -> Iterator[Listener | None]:
    if port is None:
        yield None
        return
    from doorman.visualization.live import LiveView

    with LiveView(model, f"doorman: {model.scenario.name}", port) as view:
        shown = show_in_browser(view.url)
        typer.echo(f"Live view: {view.url}{'' if shown else ' (open it in a browser on this machine)'}", err=True)
        yield view.listen
        with suppress(KeyboardInterrupt):  # whoever does not want to wait gets the results now
            view.end(10.0)  # seconds for a browser that is still loading what it missed


@contextmanager
def fed(port: int | None, other: Listener | None = None) -> Iterator[Listener | None]:
    """Send what a flight records to `doorman ros2`, too."""
    if port is None:
        yield other
        return
    from doorman.ros2 import Feed

    with Feed(port) as feed:

        def listen(topic: str, time: float, fields: Mapping[str, Value]) -> None:
            if other is not None:
                other(topic, time, fields)
            feed.listen(topic, time, fields)

        yield listen
