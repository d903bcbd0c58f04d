"""Slow, careful talk with one servo while it is set up: every instruction is repeated if need be, every failure is an error."""

from __future__ import annotations

from collections.abc import Callable

from doorman.exceptions import BackendError
from doorman.hardware.dynamixel.config import ServoConfig
from doorman.hardware.dynamixel.wire import registers as reg
from doorman.hardware.dynamixel.wire.link import Link, Outcome, Reply

ATTEMPTS = 8
"""How often an instruction is sent before the servo is given up."""
REFUSALS = {
    1: "it failed to carry it out",
    2: "it does not know the instruction",
    3: "the instruction arrived damaged",
    4: "the value is out of range, or its bus watchdog has fired",
    5: "the value has the wrong length",
    6: "the value is beyond a limit of the servo",
    7: "the register cannot be accessed, or is locked while torque is on",
}
_DAMAGED_ON_THE_WAY = 3


class Servo:
    def __init__(
        self, link: Link, config: ServoConfig, index: int, deadline: float, between: Callable[[], None] = lambda: None
    ) -> None:
        self.id, self.config, self.index, self.deadline = config.ids[index], config, index, deadline
        self.model = self.firmware = 0
        self.goal = reg.GOAL_VELOCITY if index < config.n_joints else reg.GOAL_CURRENT
        self._link, self._between = link, between

    def identify(self, models: tuple[int, ...] = ()) -> None:
        """Ask who answers, one of some models; by default of those that are configured."""
        data, models = self._insist("ping", lambda: self._link.ping(self.id)).data, models or self.config.models
        self.model, self.firmware = int.from_bytes(data[:2], "little"), data[2]
        if self.model not in models:
            names = ", ".join(f"{number} {reg.MODELS.get(number, '')}".strip() for number in models)
            raise BackendError("wrong model", field=f"servo {self.id}", given=self.model, allowed=names)
        if self.firmware < reg.OLDEST_FIRMWARE:
            raise BackendError("the firmware is too old for the bus watchdog", field=f"servo {self.id}", given=self.firmware,
                               allowed=f">= {reg.OLDEST_FIRMWARE}; DYNAMIXEL Wizard updates it")  # fmt: skip

    def make_answer(self) -> None:
        """Identify the servo and let it answer everything, in RAM: below that level, reads stay unanswered."""
        self.identify()
        register = reg.STATUS_RETURN_LEVEL
        self._link.write(self.id, register.address, register.encode(reg.ANSWER_ALL))

    def now(self) -> float:
        return self._link.now()

    def read(self, register: reg.Register) -> int:
        return register.decode(self.read_bytes(register.address, register.size, register.name))

    def read_bytes(self, address: int, length: int, name: str) -> bytes:
        return self._insist(f"read {name}", lambda: self._link.read(self.id, address, length)).data

    def write(self, register: reg.Register, value: int) -> None:
        self.write_bytes(register.address, register.encode(value), register.name)

    def write_bytes(self, address: int, data: bytes, name: str) -> None:
        self._insist(f"write {name}", lambda: self._link.write(self.id, address, data))

    def ensure(self, register: reg.Register, value: int) -> None:
        if self.read(register) != value:
            self.write(register, value)

    def clear_watchdog(self) -> None:
        """Clear the bus watchdog and zero the goal in one go: before, the servo refuses it; after, it may pursue the old one."""
        self._between()
        self._link.clear_watchdog(self.id, self.goal)
        self.write(reg.BUS_WATCHDOG, reg.WATCHDOG_OFF)

    def reboot(self) -> None:
        """Restart a servo that has shut down, and wait until it answers again."""
        # It may go on answering for a while before it restarts: it has done so once it was silent, or shows no error any more.
        heard, silent, patience = self._link.reboot(self.id).ok, False, self.config.boot_timeout
        end = min(self._link.now() + patience, self.deadline)
        while True:
            self._between()
            answer = self._link.ping(self.id)
            if answer.ok and (silent or not answer.alert):
                return
            silent = silent or answer.outcome is Outcome.TIMEOUT
            if answer.ok and not heard:
                heard = self._link.reboot(self.id).ok
            if self._link.now() > end:
                raise BackendError("the servo did not come back after a reboot", field=f"servo {self.id}",
                                   given=f"{patience:g} s", allowed="an answer to ping")  # fmt: skip

    def _insist(self, what: str, attempt: Callable[[], Reply]) -> Reply:
        tries = 0
        while True:
            self._between()
            reply, tries = attempt(), tries + 1
            refused = reply.outcome is Outcome.REFUSED and reply.error_number != _DAMAGED_ON_THE_WAY
            if reply.ok or refused or tries == ATTEMPTS or self._link.now() > self.deadline:
                break
        if reply.ok:
            return reply
        if reply.outcome is Outcome.REFUSED:
            why = REFUSALS.get(reply.error_number, f"error {reply.error_number}")
            raise BackendError(f"the servo refuses to {what}: {why}", field=f"servo {self.id}")
        raise BackendError(f"{reply.outcome.value} to {what}", field=f"servo {self.id}",
                           allowed="a servo of this id, powered, at this baud rate, with sound cables")  # fmt: skip
