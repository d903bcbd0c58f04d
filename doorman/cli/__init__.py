"""Command line: `doorman open` and `doorman check`."""

from doorman.cli.app import app, main

__all__ = ["app", "main"]
