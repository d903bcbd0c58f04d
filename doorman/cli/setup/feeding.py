"""`--feed`: what a flight records goes to `doorman ros2`, too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from doorman.recording import Listener
from doorman.recording.files.messages import Value
from doorman.ros2 import Feed


@contextmanager
def fed(port: int | None, other: Listener | None = None) -> Iterator[Listener | None]:
    if port is None:
        yield other
        return
    with Feed(port) as feed:

        def listen(topic: str, time: float, fields: Mapping[str, Value]) -> None:
            if other is not None:
                other(topic, time, fields)
            feed.listen(topic, time, fields)

        yield listen
