"""Printing beside a flight: in order, and never in its way."""

from __future__ import annotations

import io
import threading

import pytest

from doorman.cli.terminal.background_printer import BackgroundPrinter


def test_lines_come_in_their_order_and_all_of_them():
    stream = io.StringIO()
    with BackgroundPrinter(stream) as printer:
        for k in range(100):
            (printer.print if k % 2 else printer.print_over)(f"line {k} [/dev/ttyUSB0]")
    assert stream.getvalue().split("\n") == [*(f"line {k} [/dev/ttyUSB0]" for k in range(100)), ""]


def test_a_status_line_is_written_over_on_a_terminal():
    stream = io.StringIO()
    stream.isatty = lambda: True  # type: ignore[method-assign]
    with BackgroundPrinter(stream) as printer:
        printer.print_over("3.0 s")
    assert stream.getvalue() == "3.0 s\r"


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), BrokenPipeError(), ValueError("closed")])
def test_what_a_stream_does_not_take_is_lost_and_the_next_line_is_printed(fault):
    """A full disk, or a reader that Ctrl-C has ended, too."""

    class Failing(io.StringIO):
        def write(self, text: str) -> int:
            if "lost" in text:
                raise fault
            return super().write(text)

    stream = Failing()
    with BackgroundPrinter(stream) as printer:
        for words in ("lost", "lost", "printed"):
            printer.print(words)
    assert stream.getvalue() == "printed\n"


def test_a_terminal_that_takes_nothing_holds_nobody_up():
    opened = threading.Event()

    class Stopped(io.StringIO):
        def write(self, text: str) -> int:
            opened.wait(10.0)
            return super().write(text)

    with BackgroundPrinter(stream := Stopped(), patience=0.1) as printer:
        for k in range(5000):
            printer.print(f"line {k}")
    assert stream.getvalue() == ""
    opened.set()
