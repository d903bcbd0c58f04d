"""Printing beside a flight: in order, and never in its way."""

from __future__ import annotations

import contextlib
import io
import os
import threading
import time
from typing import TextIO

from doorman.cli.terminal import background_printer
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


def hopeless(stream: TextIO) -> None:
    """Print to a stream that takes nothing, and see that the thread goes on."""
    try:
        with BackgroundPrinter(stream) as printer:
            for _ in range(3):
                printer.print("to nowhere")
            deadline = time.monotonic() + 5.0
            while not printer._lines.empty():
                assert time.monotonic() < deadline, "the thread has ended"
                time.sleep(0.01)
            assert printer._thread.is_alive()
    finally:
        with contextlib.suppress(OSError):
            stream.close()


def test_a_full_disk_stays_with_the_printer():
    hopeless(open("/dev/full", "w", buffering=1))  # noqa: SIM115  # its closing fails, too


def test_a_reader_that_is_gone_stays_with_the_printer():
    """Ctrl-C ends `tee`, too."""
    reading, writing = os.pipe()
    os.close(reading)
    hopeless(os.fdopen(writing, "w", buffering=1))


def test_a_terminal_that_takes_nothing_holds_nobody_up(monkeypatch):
    monkeypatch.setattr(background_printer, "_PATIENCE", 0.1)
    opened = threading.Event()

    class Stopped(io.StringIO):
        def write(self, text: str) -> int:
            opened.wait(10.0)
            return super().write(text)

    began = time.monotonic()
    with BackgroundPrinter(Stopped()) as printer:
        for k in range(5000):
            printer.print(f"line {k}")
    assert time.monotonic() - began < 5.0
    opened.set()
