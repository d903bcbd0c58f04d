"""The Gymnasium environment: Gymnasium's own checker, seeds, rewards and ends."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from doorman.exceptions import BackendError, DimensionError, DoormanError
from doorman.learning import OpenDoorEnv, OpenDoorVectorEnv, RewardWeights
from doorman.learning.reward import Place, reward_terms
from doorman.resources import scenario_directory, shipped
from doorman.scenario import Scenario

STILL = np.zeros(8)
TASKS = sorted(shipped(scenario_directory(), ".toml"))


@pytest.fixture(scope="module")
def env():
    with_limits = OpenDoorEnv()
    yield with_limits
    with_limits.close()


def returns(env, policy, seed=0, longest=1000):
    """Return of an episode, and the figures of its last step."""
    observation, _ = env.reset(seed=seed)
    total = 0.0
    for _ in range(longest):
        observation, reward, terminated, _, info = env.step(policy(observation))
        total += reward
        if terminated:
            break
    return total, info


def test_gymnasiums_checker_has_no_complaint():
    """Warnings are errors here; it also checks that one seed is one episode."""
    made = gymnasium.make("doorman/OpenDoor-v0")
    check_env(made.unwrapped)
    made.close()


def quick(name):
    return name if name in ("drawer_close", "hatch", "push") else pytest.param(name, marks=pytest.mark.slow)


@pytest.mark.parametrize("name", [quick(name) for name in TASKS])
def test_every_shipped_scenario_is_a_task(name):
    made = gymnasium.make(f"doorman/{name}-v0", max_episode_steps=20)
    env = made.unwrapped
    assert env._model.scenario.name == name
    (observation, _), total = made.reset(seed=1), 0.0
    assert len(env.observation_names) == len(observation) and len(env.action_names) == env.action_space.shape[0]
    for _ in range(20):
        assert observation in env.observation_space and observation.dtype == np.float32
        observation, reward, terminated, truncated, _ = made.step(np.zeros(env.action_space.shape, np.float32))
        total += reward
    assert (terminated, truncated) == (False, True) and -1.0 < total < 1.0
    made.close()


def test_trying_beats_hovering_and_hovering_beats_falling(env):
    """Half a door is worth more than none, even if the vehicle falls then; thrown about, it scores least."""
    draw = np.random.default_rng(0)
    hovering, _ = returns(env, lambda _: STILL)
    falling = [returns(env, lambda _: draw.uniform(-1.0, 1.0, 8), seed)[0] for seed in range(3)]
    trying, half = returns(env, lambda _: np.array([0.02, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0]))
    opening, whole = returns(env, lambda _: np.array([0.02, 0.0, 0.5, 0.2, 0.0, 0.0, 0.0, 0.0]))
    assert not half["opened"] and half["collisions"] and whole["opened"]
    assert max(falling) < hovering < trying < opening


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
    np.testing.assert_allclose(observation[6:9], state[:3], atol=0.02)  # rounded to 32 bits
    named = dict(zip(env.observation_names, observation, strict=True))
    np.testing.assert_allclose([named[f"eta_{k} [rad]"] for k in (1, 2, 3, 4)], state[5:], atol=0.02)
    assert named["door_angle_from_goal [rad]"] == pytest.approx(info["door_angle"] - model.goal_angle)
    space = env.observation_space
    assert np.isfinite(space.low).all() and np.isfinite(space.high).all() and space.dtype == np.float32


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
    made = OpenDoorEnv(Scenario.load("paper", {"mission.start": "contact"}))
    made.reset(seed=0)
    made._goal = made._backend.truth.door_angle
    _, _, terminated, truncated, info = made.step(STILL)
    assert (terminated, truncated, info["opened"]) == (True, False, True)
    assert info["terms"]["opened"] == RewardWeights().opened
    made.close()


def test_the_way_of_the_leaf_adds_up_to_the_weight():
    weights = RewardWeights(progress=3.0, contact=2.0)
    way = [Place(a, 1.5, gap) for a, gap in ((1.5, 0.0), (1.2, 0.1), (1.3, 2.0), (0.4, 3.0), (0.0, 0.25))]
    terms = [reward_terms(weights, a, b, np.zeros(8), np.zeros(3), 0.02) for a, b in zip(way, way[1:], strict=False)]
    assert sum(one["progress"] for one in terms) == pytest.approx(3.0)
    assert sum(one["contact"] for one in terms) == pytest.approx(-1.0)
    costly = reward_terms(RewardWeights(), way[0], way[0], np.ones(4), np.array([0.0, 3.0, 0.0]), 0.5, failed=True)
    costs = {"time": -0.05, "action": -0.02, "body_rates": -0.045, "failed": -2.5}
    assert costly == pytest.approx({"progress": 0.0, "contact": 0.0, "opened": 0.0, **costs})


def test_a_failure_costs_more_than_to_hover_to_the_end():
    weights, longest = RewardWeights(), gymnasium.spec("doorman/OpenDoor-v0").max_episode_steps / 50.0
    assert weights.time * longest < weights.failed < weights.progress / 4.0 + 1e-9


def stepped(made, steps=6):
    """Observations, rewards and figures of some environments that get the same actions."""
    observations, infos = made.reset(seed=7)
    seen, figures = [observations.copy()], [infos]
    draw, rewards, ends = np.random.default_rng(1), [], []
    for _ in range(steps):
        observations, reward, *ended, infos = made.step(0.3 * draw.uniform(-1.0, 1.0, (3, 8)))
        seen.append(observations.copy())
        rewards.append(reward)
        ends.append(ended)
        figures.append(infos)
    made.close()
    return np.array(seen), np.array(rewards), np.array(ends), figures


def test_environments_run_side_by_side_as_they_run_alone():
    """Spread over processes, they are to the bit what Gymnasium's own loop over environments is; cut off, they begin again."""
    task = {"id": "doorman.learning:doorman/OpenDoor-v0", "num_envs": 3, "max_episode_steps": 4}
    plain = stepped(gymnasium.make_vec(**task, vectorization_mode="sync"))
    made = gymnasium.make_vec(**task, processes=2)
    assert isinstance(made, OpenDoorVectorEnv) and len(made.observation_names) == made.observation_space.shape[1]
    spread = stepped(made)
    for ours, theirs in zip(spread[:3], plain[:3], strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert spread[0].shape == (7, 3, 22)
    for ours, theirs in zip(spread[3:], plain[3:], strict=True):
        np.testing.assert_equal(ours, theirs)


def test_environments_side_by_side_refuse_as_one_does():
    with pytest.raises(DoormanError, match="rate"):
        OpenDoorVectorEnv(2, rate=33.0)
    made = OpenDoorVectorEnv(2, processes=2)
    made.reset(seed=[1, 2])
    with pytest.raises(DimensionError, match="actions"):
        made.step(np.zeros((3, 8)))
    with pytest.raises(BackendError, match="finite"):
        made.step(np.array([np.zeros(8), np.full(8, np.nan)]))
    assert made.step(np.zeros((2, 8)))[1].shape == (2,)
    made.close()
    made.close()
    with pytest.raises(BackendError, match="close"):
        made.step(np.zeros((2, 8)))


def test_what_cannot_be_used_is_refused(env):
    with pytest.raises(DoormanError, match="rate"):
        OpenDoorEnv(rate=33.0)
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
