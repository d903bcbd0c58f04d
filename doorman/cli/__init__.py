"""Command line: `doorman open`, `doorman check` and `doorman warmup`."""

from doorman.cli.app import app, main

__all__ = ["app", "main"]
