"""The Gymnasium environment: Gymnasium's own checker, seeds, rewards and ends."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from doorman.exceptions import BackendError, DimensionError, DoormanError
from doorman.learning import OpenDoorEnv, RewardWeights
from doorman.learning.reward import Step, reward_terms
from doorman.scenario import Scenario

STILL = np.zeros(8)


@pytest.fixture(scope="module")
def env():
    with_limits = OpenDoorEnv(duration=2.0)
    yield with_limits
    with_limits.close()


def pulled(env, seed, steps=12):
    """Observations and rewards of a vehicle that pulls at the door."""
    seen = [env.reset(seed=seed)[0]]
    rewards = []
    draw = np.random.default_rng(4)
    for _ in range(steps):
        observation, reward, *_ = env.step(0.2 * draw.uniform(-1.0, 1.0, 8))
        seen.append(observation)
        rewards.append(reward)
    return np.array(seen), np.array(rewards)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_gymnasiums_checker_passes(env):
    check_env(env, skip_render_check=True)


def test_it_is_registered():
    made = gymnasium.make("doorman.learning:doorman/OpenDoor-v0", duration=1.0)
    assert isinstance(made.unwrapped, OpenDoorEnv)
    observation, _ = made.reset(seed=1)
    assert observation.shape == (22,)
    made.close()


def test_one_seed_is_one_episode(env):
    first, second, other = pulled(env, 5), pulled(env, 5), pulled(env, 6)
    np.testing.assert_array_equal(first[0], second[0])
    np.testing.assert_array_equal(first[1], second[1])
    assert not np.array_equal(first[0], other[0])


def test_episodes_after_a_seed_differ(env):
    env.reset(seed=3)
    second = env.reset()[0]
    env.reset(seed=3)
    np.testing.assert_array_equal(env.reset()[0], second)
    assert not np.array_equal(env.reset()[0], second)


def test_the_observation_is_what_the_sensors_say(env):
    observation, info = env.reset(seed=0)
    model = env._model
    state = model.start_state
    place = model.coupling.vehicle_position(state[:3], state[3], state[5:])
    np.testing.assert_allclose(observation[:3], place - model.coupling.contact_point(state[3]), atol=0.02)
    np.testing.assert_allclose(observation[6:9], state[:3], atol=0.02)
    np.testing.assert_allclose(observation[12:16], state[5:], atol=0.02)
    assert observation[-2] == pytest.approx(info["door_angle"] - model.goal_angle)


def test_an_episode_is_cut_off_after_its_duration():
    env = OpenDoorEnv(duration=0.1)
    env.reset(seed=0)
    ends = [env.step(STILL)[2:4] for _ in range(5)]
    assert ends == [(False, False)] * 4 + [(False, True)]
    env.close()


def test_a_vehicle_that_is_thrown_about_fails(env):
    env.reset(seed=0)
    action = np.array([-1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0])
    for _ in range(100):
        observation, reward, terminated, truncated, info = env.step(action)
        assert np.isfinite(observation).all()
        if terminated or truncated:
            break
    assert terminated and not info["opened"]
    assert info["terms"]["failed"] == -RewardWeights().failed
    assert reward == pytest.approx(sum(info["terms"].values()))


def test_an_open_door_ends_the_episode(env):
    """A door that is opened from the start on, by its own goal."""
    made = OpenDoorEnv(Scenario.load("paper", {"mission.start": "contact"}), duration=1.0)
    made.reset(seed=0)
    made._goal = made._backend.truth.door_angle
    _, _, terminated, truncated, info = made.step(STILL)
    assert (terminated, truncated, info["opened"]) == (True, False, True)
    assert info["terms"]["opened"] == RewardWeights().opened
    made.close()


def test_the_way_of_the_leaf_adds_up_to_the_weight():
    weights, angles = RewardWeights(progress=3.0), [1.5, 1.2, 1.3, 0.4, 0.0]
    steps = [Step(a, b, 1.5, 0.0, 0.0, 0.02, False, False) for a, b in zip(angles, angles[1:], strict=False)]
    assert sum(reward_terms(weights, step)["progress"] for step in steps) == pytest.approx(3.0)
    costly = reward_terms(weights, Step(1.0, 1.0, 1.5, 4.0, 9.0, 0.5, False, True))
    assert costly == pytest.approx(
        {"progress": 0.0, "action": -0.04, "body_rates": -0.09, "opened": 0.0, "failed": -10.0}
    )


def test_environments_run_side_by_side():
    made = gymnasium.make_vec("doorman.learning:doorman/OpenDoor-v0", 2, vectorization_mode="sync", duration=1.0)
    observations, _ = made.reset(seed=[1, 2])
    assert observations.shape == (2, 22) and not np.array_equal(*observations)
    _, rewards, *_ = made.step(np.zeros((2, 8)))
    assert rewards.shape == (2,)
    made.close()


def test_what_cannot_be_used_is_refused(env):
    with pytest.raises(DoormanError, match="rate"):
        OpenDoorEnv(rate=33.0)
    with pytest.raises(DoormanError, match="duration"):
        OpenDoorEnv(duration=0.001)
    with pytest.raises(DoormanError, match="overrides"):
        OpenDoorEnv(Scenario.load("paper"), {"contact.height": 0.8})
    fresh = OpenDoorEnv()
    with pytest.raises(BackendError, match="reset"):
        fresh.step(STILL)
    fresh.reset(seed=0)
    with pytest.raises(BackendError, match="finite"):
        fresh.step(np.full(8, np.nan))
    for action in (np.zeros(2), np.zeros((1, 8)), np.zeros(9), 0.0, [], ["a"] * 8, None):
        with pytest.raises(DimensionError, match="action") as caught:
            fresh.step(action)
        assert caught.value.field == "action" and ("(8,)" in str(caught.value) or "numbers" in str(caught.value))
    fresh.close()
