"""Force to the side: normalised as PX4's control allocation takes it apart, and refused where an autopilot makes none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pixhawk_parts import TARGET, sample
from pixhawk_rig import WEIGHT, wait_until

from doorman.hardware.pixhawk import (
    AttitudeSetpoint,
    Outcome,
    OutcomeStatus,
    PixhawkConfig,
    PositionSetpoint,
    ThrustCurve,
)
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4
from doorman.hardware.pixhawk.events import LinkLog
from doorman.hardware.pixhawk.link.stream import SetpointStream
from doorman.hardware.pixhawk.thrust.tilted_rotors import TiltedRotors, names
from doorman.hardware.pixhawk.wire.messages import Message
from doorman.hardware.vehicle import vehicle_config
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.model import Model
from doorman.rig.emulators.autopilot.control import Task, add_rotors, side_force
from doorman.rig.emulators.autopilot.dialects import PX4_DEFAULTS, ParameterStore
from doorman.scenario import Scenario


def layout(count: int = 6, tilt: float = 20.0, seed: int = 0) -> RotorLayout:
    """Rotors on a ring, canted in turn to either side about their arms, at places that are a little off it."""
    rng = np.random.default_rng(seed)
    turn = (np.arange(count) + 0.5) * 2.0 * math.pi / count
    places = np.column_stack([0.3 * np.cos(turn), 0.3 * np.sin(turn), np.zeros(count)])
    places += rng.uniform(-0.02, 0.02, (count, 3))
    senses = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    cant = math.radians(tilt) * senses
    axes = np.column_stack([-np.sin(cant) * np.sin(turn), np.sin(cant) * np.cos(turn), np.cos(cant)])
    return RotorLayout(places, senses, np.full(count, 9.0), 0.016, axes, fully_actuated=True)


def known(rotors: RotorLayout) -> ParameterStore:
    store = ParameterStore(PX4_DEFAULTS, bytewise=True)
    add_rotors(store, rotors)
    return store


def values(store: ParameterStore) -> dict[str, float]:
    return {name: store[name] for name in ("CA_ROTOR_COUNT", *names()) if name in store}


def message(setpoint: AttitudeSetpoint, rotors: TiltedRotors | None, shape: float = 0.0) -> Message:
    curve = ThrustCurve(0.4, WEIGHT, shape)
    stream = SetpointStream(PixhawkConfig("udp:14540", thrust_curve=curve, rotors=rotors), LinkLog())
    stream.hold(PositionSetpoint(np.zeros(3), 0.0))
    assert stream.offer(setpoint, 10.0)
    sent = stream.message(10.0, sample(), TARGET)
    assert sent is not None
    return sent


@pytest.mark.parametrize(("count", "tilt", "seed"), [(6, 20.0, 0), (6, 35.0, 1), (8, 15.0, 2), (7, 25.0, 3)])
def test_what_is_sent_becomes_the_force_that_was_asked_for(count: int, tilt: float, seed: int) -> None:
    rotors = layout(count, tilt, seed)
    wanted = (2.0, -3.0)
    sent = message(AttitudeSetpoint(WEIGHT, np.zeros(3), wanted), TiltedRotors.of(rotors))
    assert sent.type_mask == 7 | 32
    x, right, down = sent.thrust_body
    assert down == pytest.approx(-0.4) and x > 0.0 and right > 0.0, "x forward, y right, z down"
    assert side_force(known(rotors), (x, -right), WEIGHT / 0.4) == pytest.approx(wanted, rel=1e-6)


def test_motors_that_the_autopilot_does_not_linearise_make_a_small_force_as_well() -> None:
    rotors, shape, small = layout(), 0.6, 0.1
    curve = ThrustCurve(0.4, WEIGHT, shape)
    sent = message(AttitudeSetpoint(WEIGHT, np.zeros(3), (small, 0.0)), TiltedRotors.of(rotors), shape)
    column = rotors.side_inverse[:, 0]
    change = column / np.abs(column[np.abs(column) > 1e-6]).mean() * sent.thrust_body[0]
    made = [curve.force(0.4 + each) / float(rotors.axes[:, 2].sum()) for each in change]  # type: ignore[index]
    assert float(np.array(made) @ rotors.axes[:, 0]) == pytest.approx(small, rel=0.02)  # type: ignore[index]


def test_upright_rotors_are_told_thrust_alone() -> None:
    sent = message(AttitudeSetpoint(WEIGHT, np.zeros(3)), None)
    assert sent.type_mask == 7 and sent.thrust == pytest.approx(0.4) and not hasattr(sent, "thrust_body")


def test_a_px4_that_knows_its_rotors_in_any_order_makes_the_force() -> None:
    rotors = layout()
    turned = np.random.default_rng(4).permutation(6)
    store = known(RotorLayout(rotors.positions[turned], rotors.directions[turned], rotors.max_thrusts, 0.016,
                              rotors.thrust_axes[turned]))  # fmt: skip
    assert TiltedRotors.of(rotors).missing(PX4, values(store)) == ""


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda given: given.clear(), "before 1.14"),
        (lambda given: given.update({"SYS_CTRL_ALLOC": 0.0}), "before 1.14"),
        (lambda given: given.update({"CA_ROTOR_COUNT": 0.0}), "no CA_ROTOR at"),
        (lambda given: given.update({f"CA_ROTOR{i}_A{x}": 0.0 for i in range(6) for x in "XY"}), "no CA_ROTOR at"),
        (lambda given: given.update({"CA_ROTOR2_AX": -given["CA_ROTOR2_AX"]}), "no CA_ROTOR at"),
        (lambda given: given.update({"CA_ROTOR4_PX": given["CA_ROTOR4_PX"] + 0.2}), "no CA_ROTOR at"),
    ],
)  # fmt: skip
def test_a_px4_that_knows_other_rotors_does_not(spoil, words) -> None:
    rotors = layout()
    given = values(known(rotors))
    spoil(given)
    assert words in TiltedRotors.of(rotors).missing(PX4, given)


def test_ardupilot_does_not() -> None:
    assert "ArduPilot" in TiltedRotors.of(layout()).missing(ARDUPILOT, {})


def test_a_vehicle_s_configuration_has_its_rotors() -> None:
    tilted, upright = (
        vehicle_config(Model(Scenario.load(name)), "udp:14540", "/dev/servos").pixhawk.rotors
        for name in ("push_tilted", "push")
    )
    assert upright is None and tilted is not None and len(tilted.axes) == 6


def test_px4_hears_the_force_over_the_line(rigs) -> None:
    rotors = layout()
    rig = rigs("px4", config={"rotors": TiltedRotors.of(rotors)})
    add_rotors(rig.emulator.parameters, rotors)
    rig.fly()
    assert rig.pilot.side_force_missing() == ""
    assert rig.pilot.setpoint(AttitudeSetpoint(WEIGHT, np.zeros(3), (1.0, 2.0)))

    def heard() -> bool:
        demand = rig.emulator.brain.demand
        if demand.task is not Task.ATTITUDE:
            return False
        made = side_force(rig.emulator.parameters, demand.side, WEIGHT / 0.4)
        return made == pytest.approx((1.0, 2.0), rel=1e-4)

    assert wait_until(heard), rig.emulator.brain.demand


def test_an_autopilot_that_makes_no_force_to_the_side_is_not_engaged(rigs, flavour) -> None:
    rig = rigs(flavour, config={"rotors": TiltedRotors.of(layout())}).open()
    outcome: Outcome = rig.pilot.engage()
    assert outcome.status is OutcomeStatus.NOT_READY and "force to the side" in outcome.message
