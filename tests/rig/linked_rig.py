"""A rig and links to it in this process, in virtual time: flights on it need no idle machine."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

from flight_rig import free_port
from virtual_time import CLOCK

from doorman.hardware.vehicle import VehicleLinks, vehicle_config
from doorman.hardware.vehicle.waiting import apart, await_links
from doorman.model import Model
from doorman.rig import Rig, RigSetup
from doorman.rig.emulators.mocap.faults import StreamFaults
from doorman.rig.plant import Snapshot
from doorman.scenario import Scenario


def until(condition: Callable[[], object], what: str) -> None:
    deadline = CLOCK.now() + 60.0
    while not condition():
        assert CLOCK.now() < deadline, f"not in time: {what}"
        CLOCK.sleep(0.01)


class LinkedRig:
    """A rig and the links to it."""

    def __init__(self, folder: Path, **settings: Any) -> None:
        self.model = Model(Scenario.load("paper"))
        self.rig = Rig(self.model, RigSetup("px4", free_port(), free_port(), folder, heartbeat_rate=10.0), clock=CLOCK)
        assert self.rig.autopilot is not None
        self.rig.autopilot.parameters["COM_DISARM_LAND"] = 0.3
        pixhawk, servos, mocap = self.rig.arguments[1::2]
        self.links = VehicleLinks(
            vehicle_config(self.model, pixhawk, servos, mocap, on_mocap_loss="report", **settings), clock=CLOCK
        )

    def __enter__(self) -> Self:
        try:
            self.rig.open()
            self.links.open()
            await_links(self.links)
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def stop(self) -> None:
        self.links.stop()
        self.rig.stop()

    @property
    def snapshot(self) -> Snapshot:
        """The plant as it is now."""
        return self.rig.plant.snapshot

    @property
    def cameras(self) -> StreamFaults:
        """What is wrong with the cameras."""
        return self.rig.mocap.stream.faults

    def set_zero(self, servo: int, ticks: int) -> None:
        """Of a servo."""
        with self.rig.servos.lock:
            self.rig.servos.servo(servo).memory.set("homing offset", ticks)

    def heal(self) -> None:
        """Bring the vehicle back to its pad, and let a mission command it."""
        self.links.release()
        self.rig.mocap.stream.faults = StreamFaults()
        for servo in range(1, self.model.n_arm + 2):
            self.set_zero(servo, 0)
        until(lambda: not self.links.autopilot.state().armed, "disarmed")
        self.rig.plant.reset()
        CLOCK.sleep(0.5)
        until(lambda: apart(self.links) < 0.05, "cameras and autopilot agree")
        until(lambda: not self.links.servos.recover(5.0), "servos set up again")
        until(lambda: self.links.servos.read().fresh, "fresh servos")
