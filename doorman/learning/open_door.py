"""Environment: a vehicle that opens a door by setpoints of thrust, attitude and joint rates, in the simulator of the flights."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.arrays import Array
from doorman.checks import numbers
from doorman.copying import Uncopied
from doorman.exceptions import BackendError, DimensionError, DoormanError
from doorman.learning.reward import Place, RewardWeights, reward_terms
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.signals import Command, Measurement
from doorman.simulation import SimulatedBackend, Truth

Array32 = NDArray[np.float32]

AT_THE_LEAF: dict[str, Any] = {
    "mission.start": "contact", "mission.measures": (), "simulation.door_ajar": 0.0, "simulation.physics_rate": 500.0,
}  # fmt: skip
"""How an episode begins, of a scenario that is given by name. Half the physics steps of flights are twice as many episodes."""
ROOM = 4.0
"""Distance from the contact point at which the vehicle has left the room [m]."""


class OpenDoorEnv(Uncopied, gymnasium.Env[Array32, Array32]):
    r"""Open the door of a scenario.

    Action, each −1 to 1, shape (4 + n,), see `action_names`: thrust :math:`m g (1 + \tfrac12 a_0)`; roll and pitch 0.35 a₁ and
    0.35 a₂; yaw 0.35 a₃ from where it is; joint rates by the arm's limits.

    Observation, shape (14 + 2 n,), see `observation_names`, cut off at the bounds of `observation_space`. As the sensors say:
    position from the contact point on the leaf at the start, velocity, attitude, body rates, arm angles and arm rates. As they
    are: the door's angle from its goal, and its rate.

    The episode ends when the door is open, and as a failure by a collision, a fall, or leaving the room. `gymnasium.make` cuts it
    off after 1,000 steps, or `max_episode_steps`. A scenario whose tip grips holds on by itself.

    Example:
        >>> import gymnasium
        >>> env = gymnasium.make("doorman/OpenDoor-v0")
        >>> observation, info = env.reset(seed=3)
        >>> observation, reward, terminated, truncated, info = env.step(0.0 * env.action_space.sample())
        >>> terminated, truncated
        (False, False)
        >>> env.close()

    Args:
        scenario: A scenario, the name or path of one, or a model of it, which many environments may share.
        overrides: Keys of the scenario by dotted name, where it is given by name; the vehicle begins at the leaf by default.
        rate: Steps a second; the controller's rate divided by a whole number [1/s].
        weights: Of the reward.

    Attributes:
        observation_names: Of the entries of an observation, with units.
        action_names: Of the entries of an action.

    Raises:
        DoormanError: if the scenario cannot be used, or an option is out of range.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  # Gymnasium's own

    def __init__(
        self,
        scenario: Scenario | Model | str = "paper",
        overrides: Mapping[str, Any] | None = None,
        rate: float = 50.0,
        weights: RewardWeights | None = None,
    ) -> None:
        self._model = model_of(scenario, overrides)
        self._ticks = _ticks(self._model.scenario.simulation.controller_rate, rate)
        self._duration = 1.0 / rate
        self._weights = weights or RewardWeights()
        self._goal = self._model.goal_angle
        self._contact = self._model.coupling.contact_point(self._model.start_angle)
        self._weight = self._model.vehicle.weight
        self._arm_rates = np.asarray(self._model.vehicle.rate_limits, dtype=np.float64)
        self._backend: SimulatedBackend | None = None
        self._yaw = 0.0
        self._place = Place(1.0, 1.0, 0.0)
        joints = self._model.vehicle.joint_names
        self.observation_names = (
            "position_x [m]", "position_y [m]", "position_z [m]", "velocity_x [m/s]", "velocity_y [m/s]", "velocity_z [m/s]",
            "roll [rad]", "pitch [rad]", "yaw [rad]", "body_rate_x [rad/s]", "body_rate_y [rad/s]", "body_rate_z [rad/s]",
            *(f"{name} [rad]" for name in joints), *(f"{name}_rate [rad/s]" for name in joints),
            "door_angle_from_goal [rad]", "door_rate [rad/s]",
        )  # fmt: skip
        self.action_names = ("thrust", "roll", "pitch", "yaw", *(f"{name}_rate" for name in joints))
        self._low, self._high = _bounds(self._model)
        self._observation: Array32 = np.zeros(len(self.observation_names), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(self.action_names),), np.float32)
        self.observation_space = gymnasium.spaces.Box(self._low, self._high, dtype=np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array32, dict[str, Any]]:
        """Begin an episode at the scenario's start; its noise and gusts are drawn by the seed.

        Args:
            seed: Of this episode and, if no other comes, of those after it.
            options: None are known.

        Returns:
            Observation, see the class, and the true door angle [rad].
        """
        super().reset(seed=seed)
        self.close()
        self._backend = SimulatedBackend(self._model, int(self.np_random.integers(2**31)))
        self._backend.open()
        measured = self._backend.read()
        truth = self._backend.truth
        self._place = self._placed(truth, abs(truth.door_angle - self._goal))
        self._observation = self._observe(measured, truth)
        return self._observation, {"door_angle": truth.door_angle}

    def step(self, action: ArrayLike) -> tuple[Array32, float, bool, bool, dict[str, Any]]:
        """Hold an action for a step.

        Args:
            action: See the class; what is beyond −1 to 1 is cut.

        Returns:
            Observation, reward, whether the episode has ended, False, and figures of the step by name.

        Raises:
            BackendError: if `reset` was not called, or the action is not finite.
            DimensionError: if the action is of another shape.
        """
        backend = self._backend
        if backend is None:
            raise BackendError("the episode has not begun", allowed="reset() before step()")
        given = numbers(action, "action")
        if given.shape != self.action_space.shape:
            raise DimensionError("wrong shape", field="action", given=given.shape, allowed=str(self.action_space.shape))
        checked = np.clip(given, -1.0, 1.0)
        backend.command(self._command(checked))  # refuses what is not finite
        fallen = False
        try:
            measured = backend.read(self._ticks)
            self._observation = self._observe(measured, backend.truth)
        except BackendError:  # it has turned over, or the physics cannot follow: the last observation stays
            fallen = True
        return self._judge(checked, backend.truth, fallen)

    def close(self) -> None:
        """Let go of the simulator."""
        if self._backend is not None:
            self._backend.stop()
            self._backend = None

    def _judge(
        self, action: Array, truth: Truth, fallen: bool, tolerance: float = 0.05
    ) -> tuple[Array32, float, bool, bool, dict[str, Any]]:
        """What a step has led to; a door within the tolerance of its goal is open [rad]."""
        before, after = self._place, self._placed(truth, self._place.whole)
        failed = fallen or truth.collisions > 0 or math.dist(truth.position, self._contact) > ROOM
        opened = after.away < tolerance and not failed
        terms = reward_terms(self._weights, before, after, action, truth.body_rates, self._duration, opened, failed)
        self._place = after
        info = {"door_angle": truth.door_angle, "opened": opened, "collisions": truth.collisions, "fallen": fallen,
                "terms": terms}  # fmt: skip
        return self._observation, sum(terms.values()), opened or failed, False, info

    def _placed(self, truth: Truth, whole: float) -> Place:
        at_contact = self._model.coupling.vehicle_position(truth.attitude, truth.door_angle, truth.arm_angles)
        return Place(abs(truth.door_angle - self._goal), whole, math.dist(truth.position, at_contact))

    def _command(self, action: Array, share: float = 0.5, tilt: float = 0.35) -> Command:
        """At most that share of the weight more or less, and that roll, pitch and change of yaw [rad]."""
        thrust = min(self._weight * (1.0 + share * float(action[0])), self._model.vehicle.max_thrust)
        attitude = tilt * action[1:4] + [0.0, 0.0, self._yaw]
        grips = self._model.scenario.contact.kind == "grip"
        return Command(thrust, attitude, self._arm_rates * action[4:], grips)

    def _observe(self, measured: Measurement, truth: Truth) -> Array32:
        self._yaw = float(measured.attitude[2])
        seen = np.concatenate([
            measured.position - self._contact, measured.velocity, measured.attitude, measured.body_rates,
            measured.arm_angles, measured.arm_rates, [truth.door_angle - self._goal, truth.door_rate],
        ])  # fmt: skip
        bounded: Array32 = np.clip(seen, self._low, self._high, dtype=np.float32, casting="same_kind")
        return bounded


def _bounds(model: Model, fastest: float = 10.0, past_limit: float = 0.5) -> tuple[Array32, Array32]:
    """Of an observation; a joint without limits is within a turn.

    A fall over the room's height stays below the fastest speed [m/s], a door below as much in rad/s, and a body below three
    turns a second. Noise, a blow, or the play of a servo take arm angles past their limits [rad].
    """
    vehicle, turn = model.vehicle, 2.0 * math.pi
    door = max(math.pi, 2.0 * abs(model.start_angle - model.goal_angle))
    lower, upper = (np.clip(limits, -turn, turn) for limits in (vehicle.lower_limits, vehicle.upper_limits))
    rates = 2.0 * np.asarray(vehicle.rate_limits)
    symmetric = np.repeat([ROOM, fastest, math.pi, 20.0], 3)
    low = np.concatenate([-symmetric, lower - past_limit, -rates, [-door, -fastest]])
    high = np.concatenate([symmetric, upper + past_limit, rates, [door, fastest]])
    return low.astype(np.float32), high.astype(np.float32)


def model_of(scenario: Scenario | Model | str, overrides: Mapping[str, Any] | None) -> Model:
    """The model of a scenario; of one that is named, the vehicle begins at the leaf."""
    if isinstance(scenario, str):
        return Model(Scenario.load(scenario, AT_THE_LEAF | dict(overrides or {})))
    if overrides:
        raise DoormanError(
            "overrides cannot change a Scenario", field="overrides", given=dict(overrides), allowed="a name"
        )
    return scenario if isinstance(scenario, Model) else Model(scenario)


def _ticks(controller_rate: float, rate: float) -> int:
    """Ticks of the controller in a step."""
    ticks = round(controller_rate / rate) if rate > 0.0 else 0
    if ticks < 1 or abs(ticks * rate - controller_rate) > 1e-6 * controller_rate:
        raise DoormanError("the controller's rate is not a multiple of it", field="rate", given=rate,
                           allowed=f"{controller_rate:g} divided by a whole number")  # fmt: skip
    return ticks
