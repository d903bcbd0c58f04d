r"""Sends poses as the stream that `MocapReceiver` reads: for cameras and middleware that speak another language.

Frame numbers for cameras whose client tells none: a frame is numbered by its time, of arrival or as stamped.

.. math::
    k = \operatorname{round}\left(\frac{t - t_0}{T} - c\right)

c follows what is left, so that a true rate a little off the nominal one skips no number. A frame that comes in the period of the
one before gets no number: it waited somewhere, and its time is not known.

A stamp that does not fit the others is numbered all the same: the receiver, which knows when the frame came, judges it. A clock
that was set back alone would look like a delay to it. `BACK` frames in a row that are older than the newest therefore get numbers
far from all before: a stream that begins anew.
"""

from __future__ import annotations

import math
import secrets
import socket
import time
from collections.abc import Mapping, Sequence

from doorman.background import Closed
from doorman.exceptions import BackendError
from doorman.hardware.mocap.faults import MocapFault
from doorman.hardware.mocap.frames import MILLIMETRES, object_angles
from doorman.hardware.mocap.packets import MOST_ITEMS, NAME_SIZE, TrackedObject, pack
from doorman.kinematics.quaternions import Quaternion, Vector

BACK = 3
"""Frames in a row behind the newest that show a clock that was set back; fewer are strays."""
_FAR = 1 << 30
"""Distance of new numbers from the old ones, a quarter of all that packets can hold."""
_FOLLOWED = 0.02
"""Share of the rest by which c is corrected a frame."""


class ArrivalNumbers:
    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._start = self._correction = 0.0
        self._first = self._behind = 0
        self._newest = self._before = -math.inf
        self._last: int | None = None

    def number(self, time: float, stamped: bool = False) -> int | None:
        if self._last is None:
            self._start = time
        again = stamped and time == self._newest
        self._follow(time)
        periods = (time - self._start) * self._rate - self._correction
        number = self._first + round(periods)
        if number == self._last and not again:
            return None
        self._correction += _FOLLOWED * (periods - round(periods))
        self._last = number
        return number

    def _follow(self, time: float) -> None:
        """See whether the clock was set back; a newest time that the next one does not reach was a stray ahead."""
        if time > self._newest:
            self._before, self._newest, self._behind = self._newest, time, 0
        elif time > self._before:
            self._newest, self._behind = time, 0
        else:
            self._behind += 1
            if self._behind == BACK:
                self._start, self._first, self._correction = time, self._first + _FAR, 0.0
                self._newest, self._before, self._behind = time, -math.inf, 0


MOST = 200
"""Objects that a datagram holds."""


class PoseSender(Closed):
    """Sends frames of poses to a receiver, `udp:PORT` there.

    Its numbers begin anywhere, so that the receiver takes a sender that was started again for another stream, not for a late one.

    Args:
        target: Address and port of the receiver.
        rate: Frames per second, as set for the receiver [1/s].
    """

    def __init__(self, target: tuple[str, int], rate: float) -> None:
        self._target, self._rate = target, rate
        self._numbers, self._first = ArrivalNumbers(rate), secrets.randbits(32)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send(
        self,
        poses: Mapping[str, tuple[Vector, Quaternion]],
        taken: float | None = None,
        refused: Sequence[MocapFault] = (),
    ) -> bool:
        """Send one frame.

        Args:
            poses: Position [m] and quaternion (w, x, y, z) by name, in the cameras' axes; an object that is not seen is left
                out. Names are cut to 24 bytes.
            taken: When the frame was taken; now if the cameras do not tell [s]. A stamp that does not fit the others is sent all
                the same, and judged by the receiver.
            refused: Why frames were refused since the last one, `FOREIGN` or `CORRUPT` once for each: the receiver counts them as
                its own. As many are sent as a datagram holds.

        Returns:
            Whether it was sent: two that come within a period count as one.

        Raises:
            BackendError: if a quaternion is zero or a number not finite, or there are too many poses for a datagram.
        """
        if len(poses) > MOST:
            raise BackendError(
                "too many poses for a datagram", field="poses", given=len(poses), allowed=f"up to {MOST}"
            )
        number = self._numbers.number(time.monotonic() if taken is None else taken, taken is not None)
        if number is None:
            return False
        objects = [_tracked(name, *pose) for name, pose in poses.items()]
        reported = refused[: MOST_ITEMS - len(objects)]
        try:
            self._socket.sendto(pack(self._first + number, objects, reported), self._target)
        except ConnectionRefusedError:  # no receiver yet
            return False
        return True

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def _tracked(name: str, position: Vector, quaternion: Quaternion) -> TrackedObject:
    length = math.sqrt(sum(value * value for value in quaternion))
    if not (all(math.isfinite(value) for value in (*position, length)) and length > 0.0):
        raise BackendError("not a pose", field=f"poses.{name}", given=(position, quaternion), allowed="finite numbers")
    w, x, y, z = (value / length for value in quaternion)
    x_mm, y_mm, z_mm = (value * MILLIMETRES for value in position)
    return TrackedObject(
        name.encode()[:NAME_SIZE].decode(errors="ignore"), (x_mm, y_mm, z_mm), object_angles((w, x, y, z))
    )
