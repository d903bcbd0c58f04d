"""The emulated autopilot against a client of a few lines: it must be as strict as the documents of the real ones say."""

from __future__ import annotations

import math
import socket
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from pixhawk_rig import free_port, wait_until
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.exceptions import BackendError
from doorman.hardware.emulators import autopilot_px4 as px4
from doorman.hardware.emulators.autopilot import EmulatedAutopilot
from doorman.hardware.emulators.autopilot_ardupilot import GUIDED, LAND, ArduPilotBrain
from doorman.hardware.emulators.autopilot_brain import AttitudeTarget, Brain, PositionTarget, Surroundings
from doorman.hardware.emulators.autopilot_control import Demand, FlightController, Task, tilted
from doorman.hardware.emulators.autopilot_estimator import Estimate, Estimator
from doorman.hardware.emulators.autopilot_parameters import ARDUPILOT_DEFAULTS, PX4_DEFAULTS, ParameterStore
from doorman.hardware.emulators.autopilot_plant import PlantTruth, SimplePlant, thrust_axis, yaw_of
from doorman.hardware.emulators.autopilot_telemetry import Schedule

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
NO = np.zeros(3)
NED = mavlink.MAV_FRAME_LOCAL_NED

# ---------------------------------------------------------------- rules, with time made up


class Sandbox:
    """A brain and the world that it sees."""

    def __init__(self, brain: Brain) -> None:
        self.brain = brain
        self.now = 30.0
        self.position = np.array([0.0, 0.0, 0.0])
        self.velocity = np.zeros(3)
        self.valid = True
        self.station_age = 0.1
        self.step(0.0)

    def step(self, duration: float, stream: Callable[[], None] | None = None) -> Demand:
        """Let time pass, with setpoints at 50 Hz if a stream is given."""
        end = self.now + duration
        while True:
            if stream is not None:
                stream()
            on_ground = bool(self.position[2] <= 0.01)
            estimate = Estimate(self.position.copy(), self.velocity.copy(), LEVEL, NO, self.valid)
            demand = self.brain.update(Surroundings(self.now, estimate, on_ground, self.station_age))
            if self.now >= end - 1e-9:
                return demand
            self.now += 0.02

    def hold(self) -> None:
        self.brain.position_target(PositionTarget(2552, NED, self.position + [0, 0, 0.5], NO, NO, 0.0))

    def tilt(self, thrust: float = 0.6, quaternion: np.ndarray = LEVEL, mask: int = 7) -> None:
        self.brain.attitude_target(AttitudeTarget(mask, quaternion, thrust))


def offboard(sandbox: Sandbox) -> None:
    sandbox.step(0.6, sandbox.hold)
    assert sandbox.brain.request_mode((1.0, 6.0, 0.0)) == 0
    assert sandbox.brain.mode == px4.OFFBOARD


@pytest.fixture
def vehicle_px4() -> Sandbox:
    return Sandbox(px4.Px4Brain(ParameterStore(PX4_DEFAULTS, bytewise=True)))


@pytest.fixture
def vehicle_ardupilot() -> Sandbox:
    return Sandbox(ArduPilotBrain(ParameterStore(ARDUPILOT_DEFAULTS, bytewise=False), start_up=22.0))


def test_px4_acknowledges_offboard_without_a_stream_and_does_not_change(vehicle_px4):
    for stream in (None, vehicle_px4.hold):
        before = vehicle_px4.brain.mode
        assert vehicle_px4.brain.request_mode((1.0, 6.0, 0.0)) == 0
        assert vehicle_px4.brain.mode == before
        vehicle_px4.step(0.1, stream)
    offboard(vehicle_px4)


def test_px4_calls_less_than_two_setpoints_a_second_no_stream(vehicle_px4):
    for _ in range(6):
        vehicle_px4.hold()
        vehicle_px4.step(0.6)
    vehicle_px4.brain.request_mode((1.0, 6.0, 0.0))
    assert vehicle_px4.brain.mode != px4.OFFBOARD


def test_px4_drops_other_frames_silently(vehicle_px4):
    target = PositionTarget(2552, mavlink.MAV_FRAME_LOCAL_FRD, NO, NO, NO, 0.0)
    vehicle_px4.step(1.0, lambda: vehicle_px4.brain.position_target(target))
    vehicle_px4.brain.request_mode((1.0, 6.0, 0.0))
    assert vehicle_px4.brain.mode != px4.OFFBOARD


@pytest.mark.parametrize(("action", "mode"), [(4, px4.LAND), (0, px4.RETURN), (5, px4.LOITER)])
def test_px4_without_its_stream_does_what_its_parameter_says(vehicle_px4, action, mode):
    vehicle_px4.brain.parameters["COM_OBL_RC_ACT"] = action
    offboard(vehicle_px4)
    assert vehicle_px4.brain.request_arming(True, False) == 0
    vehicle_px4.step(0.5, vehicle_px4.hold)
    vehicle_px4.position[2] = 1.0
    vehicle_px4.step(0.9)
    assert vehicle_px4.brain.mode == px4.OFFBOARD, "COM_OF_LOSS_T is one second"
    vehicle_px4.step(0.8)
    assert vehicle_px4.brain.mode == mode and vehicle_px4.brain.failsafe
    assert any("offboard" in text for _, text in vehicle_px4.brain.texts)


def test_px4_lands_from_offboard_when_its_position_is_gone(vehicle_px4):
    offboard(vehicle_px4)
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.valid = False
    vehicle_px4.step(2.0, vehicle_px4.hold)
    assert vehicle_px4.brain.mode == px4.LAND


def test_px4_flies_attitude_without_a_position(vehicle_px4):
    vehicle_px4.valid = False
    vehicle_px4.step(1.0, vehicle_px4.tilt)
    vehicle_px4.brain.request_mode((1.0, 6.0, 0.0))
    assert vehicle_px4.brain.mode == px4.OFFBOARD


def test_px4_does_not_arm_without_stream_position_or_station(vehicle_px4):
    offboard(vehicle_px4)
    vehicle_px4.step(1.5)
    assert vehicle_px4.brain.request_arming(True, False) == 1
    vehicle_px4.step(0.6, vehicle_px4.hold)
    vehicle_px4.valid = False
    vehicle_px4.step(0.1, vehicle_px4.hold)
    vehicle_px4.brain.texts.clear()
    assert vehicle_px4.brain.request_arming(True, False) == 1
    vehicle_px4.valid = True
    vehicle_px4.brain.parameters["NAV_DLL_ACT"] = 2
    vehicle_px4.station_age = math.inf
    vehicle_px4.step(0.1, vehicle_px4.hold)
    assert vehicle_px4.brain.request_arming(True, False) == 1
    assert "GCS" in vehicle_px4.brain.texts[-1][1]
    vehicle_px4.station_age = 0.5
    vehicle_px4.step(0.1, vehicle_px4.hold)
    assert vehicle_px4.brain.request_arming(True, False) == 0


@pytest.mark.parametrize(("action", "mode"), [(2, px4.RETURN), (3, px4.LAND)])
def test_px4_acts_on_the_loss_of_the_station(vehicle_px4, action, mode):
    vehicle_px4.brain.parameters["NAV_DLL_ACT"] = action
    offboard(vehicle_px4)
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.station_age = 11.0
    vehicle_px4.step(0.2, vehicle_px4.hold)
    assert vehicle_px4.brain.mode == mode


def test_px4_disarms_if_it_does_not_take_off(vehicle_px4):
    vehicle_px4.brain.request_arming(True, False)
    vehicle_px4.step(9.0)
    assert vehicle_px4.brain.armed
    vehicle_px4.step(2.0)
    assert not vehicle_px4.brain.armed


def test_the_pilot_always_wins(vehicle_px4, vehicle_ardupilot):
    offboard(vehicle_px4)
    vehicle_px4.brain.pilot_mode("position")
    vehicle_px4.step(1.0, vehicle_px4.hold)
    assert vehicle_px4.brain.mode == px4.POSITION
    vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0))
    vehicle_ardupilot.brain.pilot_mode("loiter")
    assert vehicle_ardupilot.brain.mode == 5
    for sandbox in (vehicle_px4, vehicle_ardupilot):
        with pytest.raises(ValueError, match="unknown mode"):
            sandbox.brain.pilot_mode("warp")


def guided(sandbox: Sandbox) -> None:
    assert sandbox.brain.request_mode((1.0, 4.0, 0.0)) == 0
    assert sandbox.brain.request_arming(True, False) == 0
    sandbox.step(0.1)


def test_ardupilot_waits_for_its_gyros(vehicle_ardupilot):
    vehicle_ardupilot.now = 21.0
    vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0))
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.request_arming(True, False) == 4
    assert "yros" in vehicle_ardupilot.brain.texts[-1][1]
    vehicle_ardupilot.step(1.0)
    assert vehicle_ardupilot.brain.request_arming(True, False) == 0


def test_ardupilot_needs_a_position_for_guided(vehicle_ardupilot):
    vehicle_ardupilot.valid = False
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0)) == 4
    assert vehicle_ardupilot.brain.mode == 0


def test_ardupilot_takes_off_by_command_only(vehicle_ardupilot):
    brain = vehicle_ardupilot.brain
    vehicle_ardupilot.hold()
    assert brain.request_take_off(1.0) == 4, "disarmed"
    guided(vehicle_ardupilot)
    assert vehicle_ardupilot.step(0.5, vehicle_ardupilot.hold).task is Task.IDLE, "a setpoint lifts nothing"
    assert brain.request_take_off(0.0) == 4
    assert brain.request_take_off(1.0) == 0
    demand = vehicle_ardupilot.step(0.1)
    assert demand.task is Task.POSITION and demand.position[2] == 1.0
    vehicle_ardupilot.position[2] = 0.3
    vehicle_ardupilot.step(0.1)
    assert brain.request_take_off(1.0) == 4, "it flies already"
    vehicle_ardupilot.hold()
    assert vehicle_ardupilot.step(0.0).position[2] == pytest.approx(0.8), "a setpoint ends the take-off"


def airborne(sandbox: Sandbox) -> None:
    guided(sandbox)
    sandbox.brain.request_take_off(1.0)
    sandbox.step(0.1)
    sandbox.position[2] = 1.0
    sandbox.step(0.1)


def test_ardupilot_ignores_setpoints_while_disarmed(vehicle_ardupilot):
    vehicle_ardupilot.brain.request_mode((1.0, 4.0, 0.0))
    vehicle_ardupilot.hold()
    airborne(vehicle_ardupilot)
    assert vehicle_ardupilot.step(0.1).position[2] == 1.0


def test_ardupilot_takes_thrust_for_a_climb_rate_unless_told_otherwise(vehicle_ardupilot):
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.tilt(0.5)
    demand = vehicle_ardupilot.step(0.0)
    assert demand.task is Task.CLIMB_RATE and demand.climb_rate == 0.0
    vehicle_ardupilot.tilt(0.75)
    assert vehicle_ardupilot.step(0.0).climb_rate > 1.0
    vehicle_ardupilot.brain.parameters["GUID_OPTIONS"] = 8
    vehicle_ardupilot.tilt(0.6)
    demand = vehicle_ardupilot.step(0.0)
    assert demand.task is Task.ATTITUDE and demand.thrust == pytest.approx(0.6)


def test_ardupilot_divides_thrust_by_the_tilt(vehicle_ardupilot):
    vehicle_ardupilot.brain.parameters["GUID_OPTIONS"] = 8
    airborne(vehicle_ardupilot)
    tilted_by = np.array([math.cos(0.2), math.sin(0.2), 0.0, 0.0])
    vehicle_ardupilot.tilt(0.4, tilted_by)
    assert vehicle_ardupilot.step(0.0).thrust == pytest.approx(0.4 / math.cos(0.4))
    vehicle_ardupilot.brain.parameters["ATC_ANGLE_BOOST"] = 0
    vehicle_ardupilot.tilt(0.4, tilted_by)
    assert vehicle_ardupilot.step(0.0).thrust == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("quaternion", "mask"), [(1.01 * LEVEL, 7), (LEVEL, 0), (LEVEL, 7 | 64), (math.nan * LEVEL, 7)]
)
def test_ardupilot_stops_at_a_target_that_is_ill_defined(vehicle_ardupilot, quaternion, mask):
    vehicle_ardupilot.brain.parameters["GUID_OPTIONS"] = 8
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.tilt(0.6, quaternion, mask)
    assert vehicle_ardupilot.step(0.0).task is Task.VELOCITY


def test_ardupilot_forgets_attitude_and_velocity_but_never_a_position(vehicle_ardupilot):
    brain = vehicle_ardupilot.brain
    brain.parameters["GUID_OPTIONS"] = 8
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.tilt(0.6, np.array([math.cos(0.2), math.sin(0.2), 0.0, 0.0]))
    assert vehicle_ardupilot.step(2.9).task is Task.ATTITUDE, "GUID_TIMEOUT is three seconds"
    demand = vehicle_ardupilot.step(0.3)
    assert demand.task is Task.CLIMB_RATE and np.allclose(demand.quaternion, LEVEL)
    brain.position_target(PositionTarget(2503, NED, NO, np.array([0.5, 0.0, 0.0]), NO, 0.0))
    assert vehicle_ardupilot.step(0.1).velocity[0] == 0.5
    assert vehicle_ardupilot.step(3.2).velocity[0] == 0.0
    vehicle_ardupilot.hold()
    assert vehicle_ardupilot.step(60.0).task is Task.POSITION


def test_ardupilot_lands_without_station_or_estimate(vehicle_ardupilot):
    airborne(vehicle_ardupilot)
    vehicle_ardupilot.station_age = 6.0
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.mode == GUIDED, "FS_GCS_ENABLE is 0 by default"
    vehicle_ardupilot.brain.parameters["FS_GCS_ENABLE"] = 5
    vehicle_ardupilot.step(0.1)
    assert vehicle_ardupilot.brain.mode == LAND and vehicle_ardupilot.brain.failsafe


@pytest.mark.parametrize("fixture", ["vehicle_px4", "vehicle_ardupilot"])
def test_a_landing_ends_disarmed_on_the_ground(request, fixture):
    sandbox = request.getfixturevalue(fixture)
    sandbox.brain.request_arming(True, False)
    sandbox.brain.landed = False
    sandbox.position[2], sandbox.velocity[2] = 1.0, -0.6
    sandbox.brain.request_land()
    assert sandbox.step(5.0).task is Task.LAND and sandbox.brain.armed
    assert sandbox.brain.request_arming(False, False) == sandbox.brain.refused_result, "not in the air"
    sandbox.position[2], sandbox.velocity[2] = 0.0, 0.0
    sandbox.step(3.0)
    assert not sandbox.brain.armed


@pytest.mark.parametrize("fixture", ["vehicle_px4", "vehicle_ardupilot"])
def test_a_landing_that_something_stops_is_over(request, fixture):
    sandbox = request.getfixturevalue(fixture)
    sandbox.brain.request_arming(True, False)
    sandbox.brain.landed = False
    sandbox.position[2], sandbox.velocity[2] = 1.0, 0.0
    sandbox.brain.request_land()
    sandbox.step(0.8)
    assert sandbox.brain.armed and not sandbox.brain.landed, "it has not begun to sink"
    sandbox.velocity[2] = -0.6
    sandbox.step(3.0)
    assert sandbox.brain.armed and not sandbox.brain.landed
    sandbox.velocity[2] = -0.02
    sandbox.step(4.0)
    assert not sandbox.brain.armed


# ---------------------------------------------------------------- plant, controller, estimator


def test_the_simple_plant_hovers_at_its_weight_and_falls_without():
    plant = SimplePlant(mass=2.0, ground=-100.0)
    plant._position[2] = 0.0
    plant._force = plant.weight
    plant.command(plant.weight, LEVEL)
    plant.advance(1.0)
    assert np.linalg.norm(plant.truth().velocity) < 1e-9
    plant.stop_motors()
    plant.advance(1.0)
    assert plant.truth().velocity[2] < -7.0


def test_the_simple_plant_stands_on_its_ground():
    plant = SimplePlant(ground=0.3)
    plant.advance(1.0)
    assert plant.truth().on_ground and plant.truth().position[2] == 0.3


@pytest.mark.parametrize("yaw", [-2.0, 0.0, 1.0])
def test_the_simple_plant_follows_attitudes(yaw):
    plant = SimplePlant()
    plant._position[2] = 10.0
    wanted = tilted((0.2, -0.1, math.sqrt(0.95)), yaw)
    plant.command(plant.weight, wanted)
    plant.advance(2.0)
    assert abs(np.dot(plant.truth().quaternion, wanted)) == pytest.approx(1.0, abs=1e-4)


def test_tilted_attitudes_point_where_they_should():
    axis = np.array([0.3, -0.2, math.sqrt(1.0 - 0.13)])
    assert np.allclose(thrust_axis(tilted(tuple(axis), 0.7)), axis)
    assert yaw_of(tilted((0.0, 0.0, 1.0), 0.7)) == pytest.approx(0.7)


def test_the_controller_reaches_a_place_on_the_simple_plant():
    plant = SimplePlant()
    plant._position[2] = 1.0
    controller = FlightController(plant.weight, 9.81)
    demand = Demand(Task.POSITION, position=np.array([1.0, -1.0, 2.0]), yaw=0.5)
    for _ in range(1500):
        truth = plant.truth()
        estimate = Estimate(truth.position, truth.velocity, truth.quaternion, truth.body_rates, True)
        plant.command(*controller.actuate(demand, estimate, 100.0))
        plant.advance(0.004)
    assert np.allclose(plant.truth().position, [1.0, -1.0, 2.0], atol=0.02)
    assert yaw_of(plant.truth().quaternion) == pytest.approx(0.5, abs=0.01)


def standing(time: float) -> PlantTruth:
    return PlantTruth(np.array([0.1 * time, 0.0, 1.0]), np.array([0.1, 0.0, 0.0]), LEVEL, NO, False)


def test_an_estimate_by_poses_is_valid_after_some_and_drifts_away_without():
    estimator = Estimator(vision=True, timeout=5.0)
    now, estimate = 0.0, None
    for k in range(1000):
        now = 0.01 * k
        estimate = estimator.update(now, standing(now), 0.01)
        if k % 2 == 0 and now < 4.0:
            assert estimate.position_valid == (estimator.accepted_poses >= 10)
            estimator.pose(now, now - 0.03, standing(now - 0.03).position)
        if now == 3.9:
            assert np.linalg.norm(estimate.position - standing(now).position) < 1e-3
    assert not estimate.position_valid, "5 s after the last pose"
    drift = float(np.linalg.norm(estimate.position - standing(now).position))
    assert 0.2 < drift < 2.0


def test_poses_with_wrong_stamps_or_places_do_not_count_at_once():
    estimator = Estimator(vision=True, timeout=5.0)
    for k in range(100):
        now = 0.01 * k
        estimator.update(now, standing(now), 0.01)
        estimator.pose(now, now, standing(now).position)
    accepted = estimator.accepted_poses
    estimator.pose(now, now - 50.0, standing(now).position)
    estimator.pose(now, now + 5.0, standing(now).position)
    estimator.pose(now, now, standing(now).position + 3.0)
    assert estimator.accepted_poses == accepted and estimator.rejected_poses == 3


# ---------------------------------------------------------------- on the wire


class Client:
    """A ground station of a few lines, written with pymavlink alone."""

    def __init__(self, emulator: EmulatedAutopilot, port: int) -> None:
        self.mav = mavlink.MAVLink(None, 255, 190)
        self.mav.robust_parsing = True
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.emulator = emulator
        self.seen: list[Any] = []

    def send(self, message: Any) -> None:
        self.socket.sendto(message.pack(self.mav), self.emulator.address)

    def command(self, number: int, *values: float) -> int:
        padded = [*values, *[0.0] * (7 - len(values))]
        self.seen.clear()
        self.send(mavlink.MAVLink_command_long_message(1, 1, number, 0, *padded))
        return int(self.get("COMMAND_ACK", lambda message: message.command == number).result)

    def get(self, kind: str, accept: Callable[[Any], bool] = lambda message: True) -> Any:
        found: list[Any] = []

        def look() -> bool:
            try:
                while True:
                    self.seen += self.mav.parse_buffer(self.socket.recv(65536)) or []
            except BlockingIOError:
                pass
            found.extend(message for message in self.seen if message.get_type() == kind and accept(message))
            return bool(found)

        assert wait_until(look), f"no {kind}"
        return found[-1]


@pytest.fixture
def clients() -> Iterator[Callable[..., Client]]:
    made: list[Client] = []

    def make(flavour: str, **settings: Any) -> Client:
        port = free_port()
        emulator = EmulatedAutopilot(flavour, remote=("127.0.0.1", port), heartbeat_rate=10.0, **settings)  # type: ignore[arg-type]
        emulator.start()
        made.append(Client(emulator, port))
        return made[-1]

    yield make
    for client in made:
        client.emulator.stop()
        client.emulator.stop()
        client.socket.close()


def test_px4_speaks_first_and_ardupilot_says_nothing_but_its_heartbeat(clients):
    client = clients("px4")
    for kind in ("HEARTBEAT", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "ODOMETRY", "TIMESYNC", "SYS_STATUS"):
        client.get(kind)
    heartbeat = client.get("HEARTBEAT")
    assert (heartbeat.autopilot, heartbeat.type, heartbeat.custom_mode) == (12, 13, px4.LOITER)
    client = clients("ardupilot")
    for _ in range(3):
        client.get("HEARTBEAT")
        client.seen.clear()
    assert {message.get_type() for message in client.seen} <= {"HEARTBEAT", "TIMESYNC"}
    assert client.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 32.0, 10_000.0) == 0
    client.get("LOCAL_POSITION_NED")
    assert client.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 230.0, 10_000.0) == 2
    assert client.command(31000) == 3


def test_it_answers_for_the_clock(clients):
    client = clients("px4")
    client.send(mavlink.MAVLink_timesync_message(0, 123456789))
    answer = client.get("TIMESYNC", lambda message: message.ts1 == 123456789)
    assert answer.tc1 * 1e-9 <= client.emulator.clock


@pytest.mark.parametrize(("flavour", "name"), [("px4", "COM_OBL_RC_ACT"), ("ardupilot", "FS_GCS_ENABLE")])
def test_integer_parameters_travel_as_each_of_them_does_it(clients, flavour, name):
    client = clients(flavour)
    client.emulator.parameters[name] = 5
    client.send(mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), -1))
    value = client.get("PARAM_VALUE")
    assert (value.param_value == 5.0) == (flavour == "ardupilot")
    client.send(mavlink.MAVLink_param_set_message(1, 1, name.encode(), value.param_value, value.param_type))
    assert wait_until(lambda: client.emulator.parameters.writes == 1)
    assert client.emulator.parameters[name] == 5.0
    client.send(mavlink.MAVLink_param_request_list_message(1, 1))
    wanted = client.emulator.parameters.names
    assert wait_until(
        lambda: (
            client.get("PARAM_VALUE")
            and len({m.param_id for m in client.seen if hasattr(m, "param_id")}) == len(wanted)
        )
    )


def test_messages_to_other_systems_are_not_for_it(clients):
    client = clients("px4")
    client.send(mavlink.MAVLink_param_set_message(9, 1, b"COM_DL_LOSS_T", 0.0, 6))
    client.send(mavlink.MAVLink_command_long_message(9, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    client.send(mavlink.MAVLink_timesync_message(0, 77))
    client.get("TIMESYNC", lambda message: message.ts1 == 77)
    assert client.emulator.parameters.writes == 0 and not client.emulator.brain.armed
    assert client.emulator.protocol.received["COMMAND_LONG"] == 0


def test_noise_does_not_stop_it(clients):
    client = clients("ardupilot")
    for size in (1, 3, 50, 300):
        client.socket.sendto(bytes(range(256))[:size] * 2, client.emulator.address)
    client.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    for stamp in range(5):
        client.send(mavlink.MAVLink_timesync_message(0, 5 + stamp))
    client.get("TIMESYNC", lambda message: 5 <= message.ts1 < 10)


def test_it_binds_nothing_but_loopback():
    for settings in ({"local": ("0.0.0.0", 0)}, {"remote": ("192.168.1.1", 14550)}):
        with pytest.raises(BackendError, match="loopback"):
            EmulatedAutopilot("px4", **settings).start()  # type: ignore[arg-type]
    with pytest.raises(BackendError, match="px4 or ardupilot"):
        EmulatedAutopilot("betaflight")  # type: ignore[arg-type]


def test_it_runs_once_at_a_time_and_says_when_its_port_is_taken():
    with EmulatedAutopilot("px4") as emulator:
        with pytest.raises(BackendError, match="runs already"):
            emulator.start()
        with pytest.raises(BackendError, match="cannot be bound"):
            EmulatedAutopilot("px4", local=emulator.address).start()
    with pytest.raises(BackendError, match="does not run"):
        _ = emulator.address


def test_a_schedule_keeps_its_rates():
    schedule = Schedule({0: 1.0, 30: 0.5})
    due = [identifier for k in range(1000) for identifier in schedule.due(5.0 + 0.01 * k)]
    assert (due.count(0), due.count(30)) == (10, 5)
    schedule.set_interval(32, 20_000.0)
    assert sum(32 in schedule.due(20.0 + 0.005 * k) for k in range(200)) == pytest.approx(50, abs=1)
    schedule.set_interval(32, -1.0)
    assert 32 not in schedule.due(30.0)


def test_a_reboot_starts_everything_anew(clients):
    client = clients("ardupilot")
    client.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 32.0, 10_000.0)
    client.get("LOCAL_POSITION_NED")
    client.emulator.brain.armed = True
    client.get("HEARTBEAT", lambda message: message.base_mode & 128)
    client.emulator.jump_clock(100.0)
    client.emulator.reboot(silence=0.1)
    client.get("HEARTBEAT", lambda message: not message.base_mode & 128)
    assert client.emulator.clock < 100.0
    client.seen.clear()
    client.get("HEARTBEAT")
    assert not [message for message in client.seen if message.get_type() == "LOCAL_POSITION_NED"]
