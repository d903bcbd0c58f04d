"""`doorman ros2`: a flight in the graph of ROS 2."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import NamedTuple

import typer

from doorman.cli.task import load_task
from doorman.model import Model
from doorman.ros2.bridge import FlightPublisher, PoseSubscriber

_TELLS_EVERY = 0.2
"""Time between two looks for what was left out [s]."""


class PoseLink(NamedTuple):
    """Poses that are taken from ROS 2."""

    topic: str
    object_name: str  # in the stream of cameras
    port: int  # of the receiver, on loopback
    rate: float  # [1/s]


def run_bridge(
    source: str,
    settings: Sequence[str],
    feed: int,
    domain: int,
    prefix: str,
    poses: PoseLink | None,
    vehicle: str | None = None,
) -> int:
    """Publish and take poses until Ctrl-C."""
    model = Model(load_task(source, settings, vehicle))
    over = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: over.set())
    with ExitStack() as stack:
        publisher = stack.enter_context(FlightPublisher(model, feed, domain, prefix))
        parts = [_Part(publisher.step, over)]
        subscriber = None
        if poses is not None:
            target = ("127.0.0.1", poses.port)
            subscriber = PoseSubscriber(poses.topic, poses.object_name, target, poses.rate, domain)
            parts.append(_Part(stack.enter_context(subscriber).step, over))
        typer.echo(f"The bridge runs until Ctrl-C; start the flight with --feed {publisher.port}.")
        for part in parts:
            part.start()
        printed: set[str] = set()
        while not over.wait(_TELLS_EVERY):
            _print_news(publisher, subscriber, printed)
        for part in parts:
            part.join(1.0)
        _print_news(publisher, subscriber, printed)
        taken = "" if subscriber is None else f", took {subscriber.received} poses, left out {subscriber.refused}"
        typer.echo(f"Published {publisher.published} messages of the flight{taken}.")
        for part in parts:
            if part.error is not None:
                raise part.error
    return 0


def _print_news(publisher: FlightPublisher, subscriber: PoseSubscriber | None, printed: set[str]) -> None:
    for reason in set(publisher.refusals) - printed:
        printed.add(reason)
        typer.echo(f"doorman: feed: left out: {reason}", err=True)
    for event in [] if subscriber is None else subscriber.events():
        typer.echo(f"doorman: poses: {event.text}", err=True)


class _Part(threading.Thread):
    def __init__(self, step: Callable[[], None], over: threading.Event) -> None:
        super().__init__(daemon=True)
        self._step, self._over = step, over
        self.error: BaseException | None = None

    def run(self) -> None:
        try:
            while not self._over.is_set():
                self._step()
        except BaseException as error:
            self.error = error
        finally:
            self._over.set()
