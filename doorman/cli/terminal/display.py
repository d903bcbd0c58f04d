"""What commands show: progress bars on stderr, results and tables on stdout, pages in the browser."""

from __future__ import annotations

import json
import math
import os
import shlex
import sys
import time
import webbrowser
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from doorman.compilation import KernelCounts, kernel_counts, known_kernels
from doorman.mission import OnProgress

COLORS = ("green", "yellow", "bold red")
"""Colors of what is good, what is worth a warning, and what is bad."""


def on_terminal(shown: bool, **options: Any) -> dict[str, Any]:
    """Options of a `Progress` on stderr that is silent where stderr is not a terminal."""
    console = Console(stderr=True, highlight=False)
    return {"console": console, "disable": not (shown and console.is_terminal), **options}


@contextmanager
def flight_progress(duration: float | None, shown: bool) -> Iterator[OnProgress]:
    """Kernels compiled before the flight, then a bar with the time left; a flight without an end of its own takes 35 s."""
    # In flight it is drawn from within the callback, never by a thread of its own that would take time away from the planner.
    preparing = Progress(TextColumn("Preparing"), _CompiledColumn(kernel_counts), TimeElapsedColumn(),
                         **on_terminal(shown, refresh_per_second=2, transient=True))  # fmt: skip
    flying = Progress(
        TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[now]}"), TimeRemainingColumn(),
        TextColumn("left"), **on_terminal(shown, auto_refresh=False),
    )  # fmt: skip
    preparing.add_task("")
    task = flying.add_task("Flying", total=duration or 35.0, now="")
    last_drawn = -math.inf

    def on_progress(now: float, door_angle: float) -> None:
        nonlocal last_drawn
        if last_drawn == -math.inf:
            preparing.stop()
            flying.start()
        if time.monotonic() - last_drawn < 0.2 and (duration is None or now < duration):
            return
        last_drawn = time.monotonic()
        position = f"{now:.1f} s, door at {math.degrees(door_angle):.0f}°"
        flying.update(task, completed=now, now=position, refresh=True)

    preparing.start()
    try:
        yield on_progress
    finally:
        preparing.stop()
        if last_drawn > -math.inf:
            flying.stop()


class _CompiledColumn(ProgressColumn):
    """Kernels compiled so far and at most, live: one of them may take a minute. Empty where the cache has them all."""

    def __init__(self, counts: Callable[[], KernelCounts]) -> None:
        super().__init__()
        self._counts, self._before = counts, counts().compiled

    def render(self, task: Task) -> Text:
        if (compiled := self._counts().compiled - self._before) == 0:
            return Text("")
        return Text(f"compiling, once: {compiled} of at most {known_kernels()} kernels")


@contextmanager
def warmup_progress(steps: int, counts: Callable[[], KernelCounts], shown: bool) -> Iterator[Callable[[str], None]]:
    """A progress bar with kernels compiled, time taken and time left."""
    with Progress(
        TextColumn("{task.description}"), BarColumn(), _CompiledColumn(counts), TimeElapsedColumn(), TimeRemainingColumn(),
        TextColumn("left"), **on_terminal(shown, refresh_per_second=4),
    ) as progress:  # fmt: skip
        task = progress.add_task("Preparing", total=steps, completed=-1)
        yield lambda name: progress.update(task, description=name, advance=1, refresh=True)
        progress.update(task, advance=1)


def print_run(as_json: bool, summary: dict[str, Any], sentence: str, folder: Path) -> None:
    """Print a run's figures, and the sentence that says what happened: as a table, or as JSON with the words on stderr."""
    if as_json:
        typer.echo(json.dumps(summary, indent=2))
        typer.echo(sentence, err=True)
        return
    table = Table(show_header=False, box=None, pad_edge=False)
    for name, value in _rows(summary):
        table.add_row(name, Text(value))
    Console(highlight=False).print(table)
    print_lines(f"\n{sentence}\nResults: {folder}\nWatch it again: doorman view {shlex.quote(str(folder))}")


def _rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    opened_at, factor, push = summary["time_to_open_s"], summary["realtime_factor"], summary["max_push_force_n"]
    planner = {name: math.nan if value is None else value for name, value in summary["planner_ms"].items()}
    what, key, form = "door's angle", "door_angle_deg", "{:.2f}°"
    if summary["unit"] == "m":
        what, key, form = "opening", "opening", "{:.3f} m"
    return [
        ("mission", summary["outcome"]),
        (f"{what} at the end", form.format(summary[f"final_{key}"])),
        ("target", form.format(summary[f"target_{key}"])),
        ("time to open, from the touch", "not opened" if opened_at is None else f"{opened_at:.2f} s"),
        ("largest constraint violation", f"{summary['max_constraint_violation_m'] * 1e3:.1f} mm"),
        ("smallest clearance", f"{summary['min_clearance_m'] * 1e3:.1f} mm"),
        ("contacts other than tip and leaf", f"{summary['collisions']}"),
        ("tip in contact", f"{summary['contact_fraction']:.1%}"),
        ("largest pull", f"{summary['max_pull_force_n']:.2f} N"),
        ("largest push", "unknown" if push is None else f"{push:.2f} N"),
        ("largest error of the estimated angle", f"{summary['door_angle_estimate_error_deg_max']:.2f}°"),
        ("planner", f"median {planner['median']:.2f}, p99 {planner['p99']:.2f}, max {planner['max']:.2f} ms"),
        ("planner, cold", f"at most {planner['cold']:.2f} ms"),
        ("plans", f"{summary['planner_rate_hz']:.0f}/s, {summary['deadline_misses']} late"),
        ("speed", "unknown" if factor is None else f"{factor:.1f} × real time"),
    ]


def print_result(as_json: bool, document: Any, lines: Iterable[str]) -> None:
    """Print a result: one JSON document for programs, lines for people."""
    for line in [json.dumps(document, indent=2)] if as_json else lines:
        typer.echo(line)


def print_lines(*lines: str) -> None:
    """Print lines that may hold anything, each of any length."""
    console = Console(highlight=False)
    for line in lines:
        console.print(Text(line), soft_wrap=True)


def print_table(heads: Iterable[str], rows: Iterable[Iterable[str | Text]], err: bool = False) -> None:
    """Print rows of plain texts; a text too long for its column goes on in the next line."""
    table = Table(*heads, box=None, pad_edge=False)
    for row in rows:
        table.add_row(*(Text(cell, overflow="fold") if isinstance(cell, str) else cell for cell in row))
    Console(stderr=err, highlight=False).print(table)


def with_advice(found: str, advice: str) -> str:
    return f"{found}\n→ {advice}" if advice else found


def show_in_browser(address: str) -> bool:
    """Open an address in a browser window; never in a terminal, whose text would be of no use."""
    # The environment variable BROWSER names another one than the system's.
    has_windows = sys.platform in ("darwin", "win32")
    if not (has_windows or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")))):
        return False
    return webbrowser.open(address)
