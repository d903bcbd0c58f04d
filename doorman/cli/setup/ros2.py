"""`doorman ros2`: a flight in the graph of ROS 2."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING, Annotated

import typer

from doorman.cli.command import VEHICLE, command
from doorman.cli.options import Settings, Source, Vehicle, valued

if TYPE_CHECKING:  # commands import what they run when they run it
    from doorman.ros2.bridge import FlightPublisher, PoseSubscriber


@command(VEHICLE)
def ros2(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    feed: Annotated[int, typer.Option(min=0, max=65535, help="UDP port on loopback for the flight's data.")] = 51100,
    domain: Annotated[int, typer.Option(min=0, max=232, envvar="ROS_DOMAIN_ID", help="Domain of the ROS graph.")] = 0,
    prefix: Annotated[str, valued("NAME", "Prefix of the published topics.")] = "doorman",
    poses: Annotated[
        str | None, valued("TOPIC", "PoseStamped topic of the vehicle; the node forwards its poses to --to.", "none")
    ] = None,
    to: Annotated[int, typer.Option(min=1, max=65535, help="UDP port on loopback of the flight's --mocap.")] = 51001,
    object_name: Annotated[str, valued("NAME", "Name of the vehicle in that stream.")] = "vehicle",
    rate: Annotated[float, valued("HZ", "Poses per second.", min=10.0, max=2000.0)] = 100.0,
) -> int:
    """Connect a flight with ROS 2, without a ROS installation, until Ctrl-C.

    The node publishes odometry, joint states, the tip's force, plan, mission and markers of a flight with --feed, the URDFs, the
    transforms of vehicle, arm and door on /tf and /tf_static, and /clock in simulation. It receives poses for a flight whose
    --mocap is udp:51001. It uses DDS, the default of ROS 2. The flight does not depend on the node, and never waits for it.
    """
    from doorman.cli.task import load_task
    from doorman.model import Model
    from doorman.ros2.bridge import FlightPublisher, PoseSubscriber

    model = Model(load_task(scenario, settings, vehicle))
    over = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: over.set())
    with ExitStack() as stack:
        publisher = stack.enter_context(FlightPublisher(model, feed, domain, prefix))
        parts, subscriber = [_Part(publisher.step, over)], None
        if poses is not None:
            subscriber = stack.enter_context(PoseSubscriber(poses, object_name, ("127.0.0.1", to), rate, domain))
            parts.append(_Part(subscriber.step, over))
        typer.echo(f"The bridge runs until Ctrl-C; start the flight with --feed {publisher.port}.")
        for part in parts:
            part.start()
        printed: set[str] = set()
        while not over.wait(0.2):
            _print_news(publisher, subscriber, printed)
        for part in parts:
            part.join(1.0)
        _print_news(publisher, subscriber, printed)
        taken = ""
        if subscriber is not None:
            taken = f", took {subscriber.relay.received} poses, left out {subscriber.relay.refused}"
        typer.echo(f"Published {publisher.published} messages of the flight{taken}.")
        for part in parts:
            if part.error is not None:
                raise part.error
    return 0


def _print_news(publisher: FlightPublisher, subscriber: PoseSubscriber | None, printed: set[str]) -> None:
    for reason in set(publisher.refusals) - printed:
        printed.add(reason)
        typer.echo(f"doorman: feed: left out: {reason}", err=True)
    for event in [] if subscriber is None else subscriber.relay.events():
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
