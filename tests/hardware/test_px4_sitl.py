"""PX4's simulator interface, from the other end: a socket that answers HIL_SENSOR with HIL_ACTUATOR_CONTROLS, as PX4 does."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import contextmanager

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from doorman.arrays import frozen
from doorman.cli.vehicles.rig_demo import free_port
from doorman.exceptions import BackendError
from doorman.gravity import GRAVITY
from doorman.hardware.pixhawk.dialect import PX4
from doorman.hardware.pixhawk.thrust.tilted_rotors import TiltedRotors
from doorman.kinematics.vehicles.rotor_layout import RotorLayout, rotor_layout
from doorman.model import Model
from doorman.rig import Rig, RigSetup
from doorman.rig.plant import RigPlant
from doorman.rig.sitl.px4 import SIMULATOR_PORT, Px4Sitl
from doorman.scenario import Scenario

ARMED = mavlink.MAV_MODE_FLAG_SAFETY_ARMED


@pytest.fixture(scope="module")
def layout(model):
    return rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)


class Px4:
    """The other end."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), 1.0)
        self.mavlink = mavlink.MAVLink(None, 1, 1)
        self.told = []

    def say(self, message):
        self.socket.sendall(message.pack(self.mavlink))

    def hear(self, patience=0.5):
        """What has come so far, at least one message unless patience ends."""
        deadline = time.monotonic() + patience
        while time.monotonic() < deadline:
            self.socket.settimeout(max(0.001, deadline - time.monotonic()))
            try:
                self.told += self.mavlink.parse_buffer(self.socket.recv(4096)) or []
                return
            except TimeoutError:
                return

    def answer(self, controls, armed=True, late=0):
        last = self.told[-1].time_usec if self.told else 0
        values = [*controls, *[0.0] * (16 - len(controls))]
        self.say(mavlink.MAVLink_hil_actuator_controls_message(last - late, values, ARMED if armed else 0, 0))


@contextmanager
def flown_by(model, layout, motors="linear", lag=0.0):
    """Plant and PX4; the plant's time passes by `advance`, not by the clock."""
    sitl = Px4Sitl(layout, free_port(), motors)
    plant = RigPlant(model, pilot=sitl, motor_lag=lag)
    with sitl:
        px4 = Px4(sitl._port)
        with px4.socket:
            yield plant, px4, sitl


@pytest.fixture
def flown(model, layout):
    with flown_by(model, layout) as made:
        yield made


def run(plant, px4, controls, steps, armed=True):
    for _ in range(steps):
        plant.advance()
        px4.hear()
        px4.answer(controls, armed)


def hover(layout, model):
    return [float(np.sqrt(model.vehicle.mass * GRAVITY / layout.max_thrusts.sum()))] * layout.count


def test_sensors_of_a_vehicle_that_stands(flown):
    plant, px4, _ = flown
    run(plant, px4, [0.0] * 6, 300, armed=False)
    told = px4.told[50:]
    means = {name: np.mean([getattr(one, name) for one in told]) for name in ("xacc", "yacc", "zacc", "xgyro", "zgyro")}
    assert means["zacc"] == pytest.approx(-GRAVITY, abs=0.05)
    assert [means["xacc"], means["yacc"]] == pytest.approx([0.0, 0.0], abs=0.05)
    assert [means["xgyro"], means["zgyro"]] == pytest.approx([0.0, 0.0], abs=1e-3)
    assert len({one.zacc for one in told}) > 0.9 * len(told), "a sensor that repeats itself counts as broken"
    slow = [one for one in told if one.fields_updated & 0b111000000]
    assert len(slow) == pytest.approx(len(told) / 5, abs=2)
    assert slow[0].zmag > 0.3, "the field points down in the north"
    assert slow[0].abs_pressure == pytest.approx(1013.2, abs=1.0)
    assert not plant.snapshot.motors
    assert plant.snapshot.on_ground


def test_its_clock_is_the_one_of_the_states(flown):
    plant, px4, _ = flown
    run(plant, px4, [0.0] * 6, 30, armed=False)
    times = [one.time_usec for one in px4.told]
    assert times[0] < 2e6 / Px4Sitl.rate + 1
    assert np.diff(times) == pytest.approx(np.full(len(times) - 1, 1e6 / Px4Sitl.rate), abs=2.0)


def test_thrust_lifts_the_vehicle(flown, layout, model):
    plant, px4, _ = flown
    run(plant, px4, [1.15 * one for one in hover(layout, model)], 120)
    assert plant.snapshot.truth.position[2] > plant.places.pad[2] + 0.05
    assert plant.snapshot.truth.rotor_thrusts.sum() > model.vehicle.mass * GRAVITY


def test_every_output_drives_its_own_rotor(flown, layout):
    plant, px4, sitl = flown
    run(plant, px4, [0.0] * 6, 2)
    for output in range(layout.count):
        controls = [0.0] * layout.count
        controls[output] = 0.5
        run(plant, px4, controls, 1)
        thrusts = sitl.thrusts(0.0)
        assert thrusts[output] == pytest.approx(0.25 * layout.max_thrusts[output])
        assert np.count_nonzero(thrusts) == 1


def test_quadratic_motors_make_the_square_of_their_signal(model, layout):
    with flown_by(model, layout, "quadratic", 0.04) as (plant, px4, sitl):
        run(plant, px4, [0.0] * 6, 2)
        for signal in (0.2, 0.5, 1.0):
            run(plant, px4, [signal] * layout.count, 1)
            assert sitl.thrusts(0.0) == pytest.approx(signal**2 * layout.max_thrusts)
        run(plant, px4, [1.0] * layout.count, round(0.04 * Px4Sitl.rate))
        risen = plant.snapshot.truth.rotor_thrusts / layout.max_thrusts
        assert risen == pytest.approx(1.0 - np.exp(-1.0), abs=0.12), "after one time constant"


def test_motors_stand_still_while_it_is_disarmed(flown, layout, model):
    plant, px4, _ = flown
    run(plant, px4, hover(layout, model), 5, armed=False)
    assert not plant.snapshot.motors
    run(plant, px4, hover(layout, model), 5)
    assert plant.snapshot.motors


def test_an_answer_to_an_older_state_is_not_the_answer(flown, layout, model):
    plant, px4, sitl = flown
    run(plant, px4, hover(layout, model), 5)
    assert sitl.thrusts(0.0) is not None
    plant.advance()
    px4.hear()
    px4.answer(hover(layout, model), late=4000)
    assert sitl.thrusts(0.0) is None


def test_motors_stop_when_it_is_silent_and_go_on_when_it_is_back(flown, layout, model):
    plant, px4, sitl = flown
    run(plant, px4, hover(layout, model), 10)
    assert plant.snapshot.motors
    plant.advance()
    plant.advance()  # the last state was not answered: it waits in vain
    assert not plant.snapshot.motors
    assert sitl.connected
    began = time.monotonic()
    for _ in range(20):
        plant.advance()
    assert time.monotonic() - began < 0.5, "and waits no more, but goes on telling"
    px4.hear()
    run(plant, px4, hover(layout, model), 5)
    assert plant.snapshot.motors


def test_a_new_one_begins_anew(flown, layout, model):
    plant, px4, sitl = flown
    run(plant, px4, hover(layout, model), 10)
    px4.socket.close()
    for _ in range(5):
        plant.advance()
    assert not sitl.connected
    assert not plant.snapshot.motors
    again = Px4(sitl._port)
    run(plant, again, hover(layout, model), 5)
    assert again.told[0].time_usec < 2e6 / Px4Sitl.rate + 1
    assert plant.snapshot.motors
    again.socket.close()


@pytest.mark.parametrize("rubbish", [b"\x00" * 100, b"\xfd\xff\xff\xff" * 40, bytes(range(256)) * 8])
def test_rubbish_is_passed_over(flown, layout, model, rubbish):
    plant, px4, _ = flown
    run(plant, px4, hover(layout, model), 3)
    px4.socket.sendall(rubbish)
    run(plant, px4, hover(layout, model), 60)
    assert plant.snapshot.motors


def test_vehicle_with_more_rotors_than_it_knows():
    many = np.ones(14)
    with pytest.raises(BackendError, match="up to 12"):
        Px4Sitl(RotorLayout(frozen(np.zeros((14, 3))), frozen(many), frozen(many), 0.016))


def test_port_that_is_taken(layout):
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as other:
        other.bind(("127.0.0.1", 0))
        other.listen(1)
        with pytest.raises(BackendError, match="sitl port"):
            Px4Sitl(layout, other.getsockname()[1]).open()


def test_rig_tells_how_to_start_it(model, layout, tmp_path):
    rig = Rig(model, RigSetup("px4-sitl", 14543, free_port(), tmp_path))
    assert rig.autopilot is None
    assert rig.autopilot_command == f"env $(cat {tmp_path / 'px4.env'}) px4 -d -i 3"
    given = dict(line.split("=") for line in (tmp_path / "px4.env").read_text().splitlines())
    assert given["PX4_PARAM_CA_ROTOR_COUNT"] == "6"
    assert given["PX4_PARAM_EKF2_EV_CTRL"] == "11"
    assert given["PX4_PARAM_THR_MDL_FAC"] == "1", "the plant's motors make the square of their signal"
    for index, (position, direction) in enumerate(zip(layout.positions, layout.directions, strict=True)):
        assert float(given[f"PX4_PARAM_CA_ROTOR{index}_PX"]) == pytest.approx(position[0], abs=1e-4)
        assert float(given[f"PX4_PARAM_CA_ROTOR{index}_PY"]) == pytest.approx(-position[1], abs=1e-4)
        assert np.sign(float(given[f"PX4_PARAM_CA_ROTOR{index}_KM"])) == direction


def test_a_plant_that_is_late_gets_back_in_step(flown, layout, model):
    plant, px4, sitl = flown
    run(plant, px4, hover(layout, model), 10)
    plant.advance()
    plant.advance()  # out of step
    px4.hear()
    stop, flew = threading.Event(), []

    def answers():
        while not stop.is_set():
            px4.hear(0.05)
            px4.answer(hover(layout, model))

    thread = threading.Thread(target=answers)
    thread.start()
    for _ in range(100):
        plant.advance()  # without a pause
        flew.append(plant.snapshot.motors)
    stop.set()
    thread.join()
    assert sum(flew[50:]) > 45, "as soon as one answer is there"


def test_one_that_hangs_is_not_flooded(flown, layout, model):
    plant, px4, sitl = flown
    run(plant, px4, hover(layout, model), 10)
    px4.told.clear()
    for _ in range(400):
        plant.advance()
    for _ in range(100):
        px4.hear(0.01)
    assert len(px4.told) <= 255
    run(plant, px4, hover(layout, model), 5)
    assert plant.snapshot.motors, "and goes on when it is back"


def test_no_cameras_no_flight():
    for kind in ("px4-sitl", "ardupilot-sitl"):
        with pytest.raises(BackendError, match="mocap_port"):
            RigSetup(kind, 14540, 0)
    with pytest.raises(BackendError, match="sitl_port"):
        RigSetup("px4-sitl", sitl_port=0)


def test_ports_that_no_instance_of_it_has(model, tmp_path):
    with pytest.raises(BackendError, match="pixhawk_port"):
        Rig(model, RigSetup("px4-sitl", 14530, free_port(), tmp_path))
    rig = Rig(model, RigSetup("px4-sitl", 14541, free_port(), tmp_path, sitl_port=SIMULATOR_PORT))
    with pytest.raises(BackendError, match="sitl_port"):
        _ = rig.autopilot_command


def test_it_is_told_how_rotors_are_tilted_and_whose_curve_it_has(tmp_path):
    tilted = Model(Scenario.load("push_tilted"))
    rig = Rig(tilted, RigSetup("px4-sitl", 14544, free_port(), tmp_path, motors="quadratic"))
    assert rig.autopilot_command
    given = dict(line.split("=") for line in (tmp_path / "px4.env").read_text().splitlines())
    values = {name.removeprefix("PX4_PARAM_"): float(value) for name, value in given.items()}
    rotors = TiltedRotors.of(rotor_layout(tilted.vehicle, tilted.scenario.simulation.torque_per_thrust))
    assert not rotors.missing(PX4, values), "what the checklist asks for"
    assert values["THR_MDL_FAC"] == 0.0, "the factory's"
