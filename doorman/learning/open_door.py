"""Environment: a vehicle that opens a door by setpoints of thrust, attitude and joint rates, in the simulator of the flights."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import numbers
from doorman.copying import Uncopied
from doorman.exceptions import BackendError, DimensionError, DoormanError
from doorman.learning.reward import RewardWeights, Step, reward_terms
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.signals import Command, Measurement
from doorman.simulation import SimulatedBackend, Truth

THRUST_SHARE = 0.5
"""Largest difference of thrust and weight, as a share of the weight."""
TILT = 0.35
"""Largest roll, pitch and change of yaw [rad]."""
OPENED = 0.05
"""Distance from the goal at which the door counts as open [rad]."""
ROOM = 4.0
"""Distance from the contact point at which the vehicle has left the room [m]."""


class OpenDoorEnv(Uncopied, gymnasium.Env[Array, Array]):
    r"""Open the door of a scenario.

    Action, each −1 to 1, shape (4 + n,): thrust :math:`m g (1 + \tfrac12 a_0)`; roll and pitch 0.35 a₁ and 0.35 a₂; yaw 0.35 a₃
    from where it is; joint rates by the arm's limits.

    Observation, shape (14 + 2 n,). As the sensors say: position from the contact point on the leaf at the start, velocity,
    attitude, body rates, arm angles and arm rates. As they are: the door's angle from its goal, and its rate.

    The episode ends when the door is open, and as a failure by a collision, a fall, or leaving the room; it is cut off after
    `duration`. A scenario whose tip grips holds on by itself.

    Args:
        scenario: A scenario, or the name or path of one.
        overrides: Keys of the scenario by dotted name, where it is given by name; the vehicle begins at the leaf by default.
        rate: Steps a second; the controller's rate divided by a whole number [1/s].
        duration: Longest episode [s].
        weights: Of the reward.

    Raises:
        DoormanError: if the scenario cannot be used, or an option is out of range.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  # Gymnasium's own

    def __init__(
        self,
        scenario: Scenario | str = "paper",
        overrides: Mapping[str, Any] | None = None,
        rate: float = 50.0,
        duration: float = 20.0,
        weights: RewardWeights | None = None,
    ) -> None:
        if isinstance(scenario, str):
            scenario = Scenario.load(scenario, {"mission.start": "contact"} | dict(overrides or {}))
        elif overrides:
            raise DoormanError(
                "overrides cannot change a Scenario", field="overrides", given=dict(overrides), allowed="a name"
            )
        self._model = Model(scenario)
        self._ticks = _ticks(scenario.simulation.controller_rate, rate)
        if not 1.0 / rate <= duration <= 3600.0:
            raise DoormanError("out of range", field="duration", given=duration, allowed="a step to 3600 s")
        self._steps, self._duration = round(duration * rate), 1.0 / rate
        self._weights = weights or RewardWeights()
        self._goal = self._model.goal_angle
        self._contact = self._model.coupling.contact_point(self._model.start_angle)
        self._weight = self._model.vehicle.weight
        self._arm_rates = np.asarray(self._model.vehicle.rate_limits, dtype=np.float64)
        self._backend: SimulatedBackend | None = None
        self._yaw = 0.0
        self._count = 0
        self._away = self._whole = 0.0
        self._observation: Array = np.zeros(14 + 2 * self._model.n_arm)
        self._action_shape = (4 + self._model.n_arm,)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, self._action_shape, np.float64)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, self._observation.shape, np.float64)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
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
        self._count = 0
        self._away = self._whole = abs(self._backend.truth.door_angle - self._goal)
        self._observation = self._observe(measured, self._backend.truth)
        return self._observation, {"door_angle": self._backend.truth.door_angle}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold an action for a step.

        Args:
            action: See the class; what is beyond −1 to 1 is cut.

        Returns:
            Observation, reward, whether the episode has ended, whether it was cut off, and figures of the step by name.

        Raises:
            BackendError: if `reset` was not called, or the action is not finite.
            DimensionError: if the action is of another shape.
        """
        backend = self._backend
        if backend is None:
            raise BackendError("the episode has not begun", allowed="reset() before step()")
        action = np.clip(self._action(action), -1.0, 1.0)
        backend.command(self._command(action))  # refuses what is not finite
        fallen, touched = False, 0
        try:
            for _ in range(self._ticks - 1):
                backend.read()
                touched = max(touched, backend.truth.collisions)
            measured = backend.read()
            touched = max(touched, backend.truth.collisions)
            self._observation = self._observe(measured, backend.truth)
        except BackendError:  # it has turned over, or the physics cannot follow: the last observation stays
            fallen = True
        return self._judge(action, backend.truth, fallen, touched)

    def close(self) -> None:
        """Let go of the simulator."""
        if self._backend is not None:
            self._backend.stop()
            self._backend = None

    def _action(self, given: ArrayLike) -> Array:
        action, shape = numbers(given, "action"), self._action_shape
        if action.shape != shape:
            raise DimensionError("wrong shape", field="action", given=action.shape, allowed=str(shape))
        return action

    def _judge(
        self, action: Array, truth: Truth, fallen: bool, touched: int
    ) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        self._count += 1
        away = abs(truth.door_angle - self._goal)
        left = bool(np.linalg.norm(truth.position - self._contact) > ROOM)
        failed = fallen or touched > 0 or left
        opened = away < OPENED and not failed
        rates = float(truth.body_rates @ truth.body_rates)
        step = Step(self._away, away, self._whole, float(action @ action), rates, self._duration, opened, failed)
        terms = reward_terms(self._weights, step)
        self._away = away
        info = {
            "door_angle": truth.door_angle,
            "opened": opened,
            "collisions": touched,
            "fallen": fallen,
            "terms": terms,
        }
        over = opened or failed
        return self._observation, sum(terms.values()), over, not over and self._count >= self._steps, info

    def _command(self, action: Array) -> Command:
        thrust = min(self._weight * (1.0 + THRUST_SHARE * float(action[0])), self._model.vehicle.max_thrust)
        attitude = np.array([TILT * action[1], TILT * action[2], self._yaw + TILT * action[3]])
        grips = self._model.scenario.contact.kind == "grip"
        return Command(thrust, attitude, self._arm_rates * action[4:], grips)

    def _observe(self, measured: Measurement, truth: Truth) -> Array:
        self._yaw = float(measured.attitude[2])
        return np.concatenate([
            measured.position - self._contact, measured.velocity, measured.attitude, measured.body_rates,
            measured.arm_angles, measured.arm_rates, [truth.door_angle - self._goal, truth.door_rate],
        ])  # fmt: skip


def _ticks(controller_rate: float, rate: float) -> int:
    """Ticks of the controller in a step."""
    ticks = round(controller_rate / rate) if rate > 0.0 else 0
    if ticks < 1 or abs(ticks * rate - controller_rate) > 1e-6 * controller_rate:
        raise DoormanError("the controller's rate is not a multiple of it", field="rate", given=rate,
                           allowed=f"{controller_rate:g} divided by a whole number")  # fmt: skip
    return ticks
