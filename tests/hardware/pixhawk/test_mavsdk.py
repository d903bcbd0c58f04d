"""MAVSDK, which is nobody of ours, starts with the emulated PX4 as its examples do with the real one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import mavsdk
import numpy as np
import pytest
from mavsdk.plugins.action import Action
from mavsdk.plugins.offboard import Offboard, PositionNedYaw
from mavsdk.plugins.telemetry import Telemetry
from pixhawk_rig import free_port, wait_until

from doorman.rig.emulators.autopilot import EmulatedAutopilot


@pytest.fixture
def ground_station() -> Iterator[mavsdk.Mavsdk]:
    station = mavsdk.Mavsdk(mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION))
    yield station
    station.destroy()


@pytest.mark.parametrize("vision", [False, True])
def test_health_offboard_after_the_first_setpoint_attitude_and_imu(ground_station, vision):
    port = free_port()
    emulator = EmulatedAutopilot("px4", remote=("127.0.0.1", port), heartbeat_rate=10.0, vision=vision)
    seen: dict[str, Any] = {}
    with emulator:
        assert ground_station.add_any_connection(f"udpin://127.0.0.1:{port}") == mavsdk.ConnectionResult.SUCCESS
        system = ground_station.first_autopilot(5.0)
        assert system is not None
        telemetry, offboard, action = Telemetry(system), Offboard(system), Action(system)
        telemetry.subscribe_health(lambda health, *_: seen.update(health=health))
        telemetry.subscribe_health_all_ok(lambda fine, *_: seen.update(fine=fine))
        telemetry.subscribe_attitude_euler(lambda angles, *_: seen.update(attitude=angles))
        telemetry.subscribe_imu(lambda imu, *_: seen.update(imu=imu))
        assert wait_until(lambda: {"health", "attitude", "imu", "fine"} <= set(seen))
        telemetry.set_rate_imu(50.0)
        telemetry.set_rate_attitude_euler(50.0)
        if vision:  # without poses it has no position, and says so
            assert wait_until(lambda: seen["health"].is_gyrometer_calibration_ok)
            assert not seen["health"].is_global_position_ok and not seen["fine"]
            return
        assert wait_until(lambda: seen["fine"]), seen["health"]
        assert seen["imu"].acceleration_frd.down_m_s2 == pytest.approx(-9.81, abs=0.01), "at rest"
        offboard.set_position_ned(PositionNedYaw(0.0, 0.0, 0.0, 0.0))
        offboard.start()
        assert wait_until(lambda: emulator.brain.mode >> 16 == 6), "offboard"
        action.arm()
        offboard.set_position_ned(PositionNedYaw(0.3, 0.0, -0.6, 0.0))
        assert wait_until(lambda: np.allclose(emulator.truth.position, (0.3, 0.0, 0.6), atol=0.05))
        assert abs(seen["attitude"].pitch_deg) < 25.0 and math.isfinite(seen["imu"].angular_velocity_frd.forward_rad_s)
