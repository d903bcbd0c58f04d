"""Opening a page in the browser of whoever sits at this machine."""

from __future__ import annotations

import os
import sys
import webbrowser


def show_in_browser(address: str) -> bool:
    """Open an address in a browser window; never in a terminal, whose text would be of no use."""
    # The environment variable BROWSER names another one than the system's.
    has_windows = sys.platform in ("darwin", "win32") or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    )
    if not (has_windows or os.environ.get("BROWSER")):
        return False
    return webbrowser.open(address)
