"""ArduPilot's JSON interface, from the other end: a socket that answers states with motor outputs, as ArduPilot does."""

from __future__ import annotations

import json
import socket
import struct
from contextlib import contextmanager

import numpy as np
import pytest

from doorman.cli.vehicles.rig_demo import free_port
from doorman.exceptions import BackendError
from doorman.gravity import GRAVITY
from doorman.kinematics.urdf.robot import frozen
from doorman.kinematics.vehicles.rotor_layout import RotorLayout, rotor_layout
from doorman.rig import Rig, RigSetup
from doorman.rig.plant import RigPlant
from doorman.rig.sitl.ardupilot import EXPO, FRAMES, FULL, ArduPilotSitl, outputs_of

MAGIC = 18458


@pytest.fixture(scope="module")
def layout(model):
    return rotor_layout(model.vehicle, model.scenario.simulation.torque_per_thrust)


class Copter:
    """The other end."""

    def __init__(self, port):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(1.0)
        self.port, self.frame = port, 0

    def send(self, pwm, count=6, magic=MAGIC):
        self.frame += 1
        outputs = [round(pwm)] * count + [1000] * (16 - count)
        self.socket.sendto(struct.pack("<HHI16H", magic, 400, self.frame, *outputs), ("127.0.0.1", self.port))

    def state(self):
        return json.loads(self.socket.recv(4096))


@contextmanager
def flown_by(model, layout, motors="linear"):
    """Plant and copter; the plant's time passes by `advance`, not by the clock."""
    sitl = ArduPilotSitl(layout, free_port(), motors)
    plant, copter = RigPlant(model, pilot=sitl), Copter(sitl._port)
    with sitl, copter.socket:
        yield plant, copter, sitl


@pytest.fixture
def flown(model, layout):
    with flown_by(model, layout) as made:
        yield made


def hover(layout, model):
    """PWM that carries the weight, by ArduPilot's curve of thrust."""
    share = model.vehicle.mass * GRAVITY / layout.max_thrusts.sum() * ((1 - EXPO) * FULL + EXPO * FULL**2)
    return 1000.0 + 1000.0 * (-(1 - EXPO) + np.sqrt((1 - EXPO) ** 2 + 4 * EXPO * share)) / (2 * EXPO)


def run(plant, copter, pwm, steps):
    states = []
    for _ in range(steps):
        copter.send(pwm)
        plant.advance()
        states.append(copter.state())
    return states


def test_sensors_of_a_vehicle_that_stands(flown, model):
    plant, copter, _ = flown
    plant.advance()
    state = run(plant, copter, 1000, 200)[-1]
    assert state["imu"]["accel_body"] == pytest.approx([0.0, 0.0, -GRAVITY], abs=0.05)
    assert state["imu"]["gyro"] == pytest.approx([0.0] * 3, abs=1e-3)
    x, y, z = plant.snapshot.truth.position
    assert state["position"] == pytest.approx([x, -y, -z], abs=1e-4)
    assert np.linalg.norm(state["quaternion"]) == pytest.approx(1.0, abs=1e-5)
    assert not plant.snapshot.motors
    assert plant.snapshot.on_ground


def test_clock_begins_when_the_autopilot_does(flown):
    plant, copter, _ = flown
    for _ in range(10):
        plant.advance()
    first = run(plant, copter, 1000, 20)
    times = [state["timestamp"] for state in first]
    assert times[0] == pytest.approx(1 / 400, abs=1e-6)
    assert np.diff(times) == pytest.approx(np.full(19, 1 / 400), abs=2e-6)
    copter.frame = 0  # it has started anew
    assert run(plant, copter, 1000, 1)[0]["timestamp"] < times[-1]


def test_thrust_lifts_the_vehicle(flown, layout, model):
    plant, copter, _ = flown
    plant.advance()
    pwm = hover(layout, model)
    run(plant, copter, pwm + 60.0, 160)
    assert plant.snapshot.truth.position[2] > plant.places.pad[2] + 0.05
    assert plant.snapshot.truth.rotor_thrusts.sum() > model.vehicle.mass * GRAVITY


def test_every_output_drives_its_own_rotor(flown, layout):
    plant, copter, sitl = flown
    plant.advance()
    for output, (angle, sense) in enumerate(FRAMES[6]):
        outputs = [1000] * 16
        outputs[output] = 1950
        copter.frame += 1
        copter.socket.sendto(struct.pack("<HHI16H", MAGIC, 400, copter.frame, *outputs), ("127.0.0.1", copter.port))
        thrusts = sitl.thrusts(0.0)
        rotor = int(np.argmax(thrusts))
        assert thrusts[rotor] == pytest.approx(layout.max_thrusts[rotor])
        assert np.count_nonzero(thrusts) == 1
        x, y, _ = layout.positions[rotor]
        assert np.degrees(np.arctan2(-y, x)) == pytest.approx(angle, abs=1.0) or abs(angle) == 180.0
        assert sitl.directions[rotor] == sense


def test_quadratic_motors_make_the_square_of_their_signal(model, layout):
    with flown_by(model, layout, "quadratic") as (plant, copter, sitl):
        plant.advance()
        for pwm in (1200, 1500, 1950):
            copter.send(pwm)
            assert sitl.thrusts(0.0) == pytest.approx(((pwm - 1000) / 950) ** 2 * layout.max_thrusts)


def test_yaw_torque_is_that_of_the_autopilots_frame(flown):
    """Outputs that turn clockwise push the body counter-clockwise, seen from above: yaw grows."""
    plant, copter, _ = flown
    gears = plant._simulator.plant.engine_model.actuator_gear[:6, 5]
    assert (np.sign(gears) == -plant._pilot.directions).all()


def test_motors_stop_when_the_autopilot_is_gone(flown, layout, model):
    plant, copter, sitl = flown
    plant.advance()
    run(plant, copter, hover(layout, model), 10)
    assert plant.snapshot.motors
    plant.advance()  # nothing was sent: it waits in vain
    assert not plant.snapshot.motors
    assert not sitl.connected
    run(plant, copter, hover(layout, model), 2)
    assert plant.snapshot.motors, "and go on when it is back"


@pytest.mark.parametrize("packet", [b"", b"\x00", b"x" * 40, struct.pack("<HHI", MAGIC, 400, 1), bytes(256)])
def test_what_is_no_answer_is_not_taken(flown, packet):
    plant, copter, sitl = flown
    copter.socket.sendto(packet, ("127.0.0.1", copter.port))
    plant.advance()
    assert not sitl.connected
    assert not plant.snapshot.motors


def test_packets_for_32_servos(flown, layout):
    _, copter, sitl = flown
    copter.socket.sendto(struct.pack("<HHI32H", 29569, 400, 1, *([1950] * 32)), ("127.0.0.1", copter.port))
    assert sitl.thrusts(0.0) == pytest.approx(layout.max_thrusts)


def test_rotors_that_are_no_frame_of_the_autopilot(layout):
    turned = np.array([[np.cos(a), np.sin(a), 0.0] for a in np.arange(6) * np.pi / 3])
    with pytest.raises(BackendError, match="X frame"):
        outputs_of(RotorLayout(frozen(turned), layout.directions, layout.max_thrusts, 0.016))
    with pytest.raises(BackendError, match="4, 6, 8"):
        outputs_of(RotorLayout(frozen(np.zeros((5, 3))), frozen(np.ones(5)), frozen(np.ones(5)), 0.016))


def test_port_that_is_taken(layout):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        with pytest.raises(BackendError, match="sitl port"):
            ArduPilotSitl(layout, other.getsockname()[1]).open()


def test_rig_tells_how_to_start_it(model, tmp_path):
    rig = Rig(model, RigSetup("ardupilot-sitl", free_port(), free_port(), tmp_path, sitl_port=free_port()))
    words = rig.autopilot_command
    assert "JSON:127.0.0.1" in words and f"udpclient:127.0.0.1:{rig.setup.pixhawk_port}" in words
    assert "FRAME_CLASS 2" in (tmp_path / "ardupilot.parm").read_text()
    assert rig.autopilot is None
    with rig:
        assert rig.plant.failure is None
    assert Rig(model, RigSetup(folder=tmp_path)).autopilot_command is None
