"""Emulated servos on a pseudo-terminal: they speak DYNAMIXEL protocol 2.0 byte for byte and move a plant."""

from __future__ import annotations

import contextlib
import heapq
import os
import termios
import tty
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from doorman.background import InThread
from doorman.clocks import REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.rig.emulators.servos.bus import QUESTIONS, BusFaults, LaggingJoints, ServoBusLogic, ServoPlant
from doorman.rig.emulators.servos.packets import InstructionStream
from doorman.rig.emulators.servos.unit import EmulatedServo, ServoSetup

IDLE = 0.002
"""Silence after which a packet that was begun is given up, and shortest time between two looks at the plant [s]."""
TICK = 5 * IDLE
"""Longest time between two looks at plant and watchdogs [s]."""
LINE_RATES = {
    code: int(name[1:]) for name, code in vars(termios).items() if name.startswith("B") and name[1:].isdigit()
}
"""Rate of a port by the code that its settings show [bit/s]; other rates, such as 4.5 Mbaud, they do not show."""


class ServoEmulator(InThread):
    def __init__(
        self,
        servos: Sequence[int] | Sequence[ServoSetup] = (1, 2, 3, 4),
        plant: ServoPlant | None = None,
        *,
        link: Path | None = None,
        baud_rate: int | None = None,
        clock: Clock = REAL_TIME,
    ) -> None:
        super().__init__("emulated servo bus", clock)
        setups = [ServoSetup(servo) if isinstance(servo, int) else servo for servo in servos]
        if len({setup.servo_id for setup in setups}) != len(setups):
            raise BackendError(
                "two servos have the same id", field="servos", given=[setup.servo_id for setup in setups]
            )
        self.plant: ServoPlant = plant or LaggingJoints(np.zeros(len(setups)))
        self.faults = BusFaults()
        self.lock = clock.lock()  # held while the servos act; take it to look at several of their rows at once
        self._servos = [EmulatedServo(setup) for setup in setups]
        self._logic = ServoBusLogic(self._servos, self.plant, self.faults, baud_rate)
        self._stream = InstructionStream()
        self._link = link
        self._master = self._slave = -1
        self._wake: tuple[int, int] | None = None
        self._awake = clock.event()
        self._replies: list[tuple[float, int, bytes]] = []
        self._sent = 0
        self._last_byte = 0.0
        self._ticked = 0.0

    @property
    def port(self) -> str:
        if self._link is not None:
            return str(self._link)
        if self._slave < 0:
            raise BackendError("the emulated port is not plugged in", allowed="open() before port")
        return os.ttyname(self._slave)

    def servo(self, servo_id: int) -> EmulatedServo:
        for servo in self._servos:
            if servo.servo_id == servo_id:
                return servo
        known = ", ".join(str(servo.servo_id) for servo in self._servos)
        raise BackendError("no such servo", field="servo_id", given=servo_id, allowed=known)

    def unplug(self) -> None:
        """Pull the serial adapter out: the port vanishes while the servos keep their power."""
        with self.lock:
            descriptors = [descriptor for descriptor in (self._master, self._slave) if descriptor >= 0]
            self._master = self._slave = -1
            self._replies.clear()
            if self._link is not None:
                self._link.unlink(missing_ok=True)
            self._awake.clear()
        self._nudge()
        if self._thread is not None:  # a descriptor lives on while somebody waits for it
            self._awake.wait(1.0)
        for descriptor in descriptors:
            os.close(descriptor)

    def plug_in(self) -> None:
        """Plug the serial adapter in: a fresh pseudo-terminal, at the same link if there is one."""
        with self.lock:
            if self._master >= 0:
                return
            self._master, self._slave = os.openpty()
            tty.setraw(self._slave)
            self._set_line_rate()
            os.set_blocking(self._master, False)
            if self._link is not None:
                self._link.unlink(missing_ok=True)
                self._link.symlink_to(os.ttyname(self._slave))
        self._nudge()

    def _set_line_rate(self) -> None:
        """Leave the port as somebody left it who spoke to the first servo: who opens it and sets no rate is heard."""
        settings = termios.tcgetattr(self._slave)
        for code, rate in LINE_RATES.items():
            if self._servos and self._servos[0].baud_rate == rate:
                settings[4] = settings[5] = code
        termios.tcsetattr(self._slave, termios.TCSANOW, settings)

    def _begin(self) -> None:
        self._wake = os.pipe()
        self.plug_in()

    def _interrupt(self) -> None:
        self._nudge()

    def _end(self) -> None:
        self.unplug()
        for descriptor in self._wake or ():
            os.close(descriptor)
        self._wake = None

    def _nudge(self) -> None:
        if self._wake is not None:
            os.write(self._wake[1], b"!")

    def _run(self) -> None:
        while not self._stopping.is_set():
            self._wait()
            now = self._clock.now()
            with self.lock:
                self._awake.set()
                if self._listen(now) or now - self._ticked > IDLE:
                    self._ticked = self._clock.now()
                    self._logic.tick(self._ticked)
                self._speak()

    def _wait(self) -> None:
        assert self._wake is not None
        due = self._replies[0][0] - self._clock.now() if self._replies else TICK
        ports = [self._wake[0]] if self._master < 0 else [self._wake[0], self._master]
        with contextlib.suppress(OSError, ValueError):  # unplugged while waiting
            ready = self._clock.readable(ports, min(max(due, 0.0), TICK))
            if self._wake[0] in ready:
                os.read(self._wake[0], 4096)

    def _listen(self, now: float) -> bool:
        """Hear what came, and act on it; returns whether that was more than a question."""
        try:
            data = os.read(self._master, 4096) if self._master >= 0 else b""
        except OSError:
            data = b""
        if not data:
            if now - self._last_byte > IDLE:
                self._stream.idle()
            return False
        self._last_byte = now
        if self.faults.strike(self.faults.deafness):
            data = self.faults.flip(data)
        if self.faults.echo:
            self._write(data)
        acts = False
        rate = LINE_RATES.get(termios.tcgetattr(self._slave)[5])
        for instruction in self._stream.feed(data):
            acts = acts or instruction.code not in QUESTIONS
            for due, packet in self._logic.respond(now, instruction, rate):
                self._sent += 1
                heapq.heappush(self._replies, (due, self._sent, packet))
        return acts

    def _speak(self) -> None:
        if self.faults.babble:
            self._write(self.faults.random_bytes(200))
        while self._replies and self._replies[0][0] <= self._clock.now():
            self._write(heapq.heappop(self._replies)[2])

    def _write(self, data: bytes) -> None:
        if self._master >= 0:
            with contextlib.suppress(OSError):  # no reader: bytes on a wire are lost too
                os.write(self._master, data)
