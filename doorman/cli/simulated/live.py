"""`doorman open --view`: the page that shows a flight while it is flown."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress

import typer

from doorman.cli.terminal.browser import show_in_browser
from doorman.model import Model
from doorman.recording import Listener

_PATIENCE = 10.0
"""After the flight, for a browser that is still loading what it missed [s]."""


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
            view.end(_PATIENCE)
