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


class PoseLink(NamedTuple):
    """Poses that are taken from ROS 2."""

    topic: str
    object_name: str
    """In the stream of cameras."""
    port: int
    """Of the receiver, on loopback."""
    rate: float
    """[1/s]."""


def run_bridge(
    source: str,
    settings: Sequence[str],
    feed: int,
    domain: int,
    prefix: str,
    poses: PoseLink | None,
    vehicle: str | None = None,
) -> int:
    """Publish and take poses until Ctrl-C.

    Args:
        source: Name or path of the scenario.
        settings: Overrides, `key=value`.
        feed: UDP port on loopback that the flight sends to.
        domain: ROS_DOMAIN_ID.
        prefix: Of the published topics.
        poses: What to take, if anything.
        vehicle: Name or path of a vehicle file, if any.

    Returns:
        Exit status: 0.

    Raises:
        DoormanError: if the input cannot be used or the port is taken.
    """
    model = Model(load_task(source, settings, vehicle))
    over = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: over.set())
    with ExitStack() as stack:
        publisher = stack.enter_context(FlightPublisher(model, feed, domain, prefix))
        steps: list[Callable[[], None]] = [publisher.step]
        subscriber = None
        if poses is not None:
            target = ("127.0.0.1", poses.port)
            subscriber = PoseSubscriber(poses.topic, poses.object_name, target, poses.rate, domain)
            steps.append(stack.enter_context(subscriber).step)
        typer.echo(f"The bridge runs until Ctrl-C; start the flight with --feed {publisher.port}.")
        threads = [threading.Thread(target=_repeat, args=(step, over), daemon=True) for step in steps]
        for thread in threads:
            thread.start()
        while not over.wait(0.2) and all(thread.is_alive() for thread in threads):
            pass
        over.set()
        for thread in threads:
            thread.join(1.0)
        taken = "" if subscriber is None else f", took {subscriber.received} poses"
        typer.echo(f"Published {publisher.published} messages of the flight{taken}.")
    return 0


def _repeat(step: Callable[[], None], over: threading.Event) -> None:
    while not over.is_set():
        step()
