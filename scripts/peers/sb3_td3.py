"""Stable-Baselines3's TD3 training in PyBullet.

All classes are its own: networks, replay buffer, exploration noise, evaluation. Holds the
way that environments run: all in this process, or each in its own. Does not depend on
MuJoCo.
"""

import time

import numpy as np
from stable_baselines3 import TD3
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.noise import NormalActionNoise
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

from peers.bullet_ant import BulletAnt
from peers.task import ACTION


def environments(task, urdf_path, robots, processes):
    makers = [lambda seed=seed: BulletAnt(task, urdf_path, seed) for seed in range(robots)]
    # Forked: a child runs the engine and never PyTorch, which has not computed anything yet.
    return SubprocVecEnv(makers, start_method="fork") if processes else DummyVecEnv(makers)


def model(config, ants, budget, seed):
    return TD3(
        "MlpPolicy",
        ants,
        # It has one learning rate for both; paper.toml's actor has 3e-4.
        learning_rate=config["critic_learning_rate"],
        buffer_size=config["buffer_size"],
        learning_starts=budget.warm_up_steps,
        batch_size=config["batch_size"],
        tau=config["tau"],
        gamma=config["gamma"],
        train_freq=(budget.gather_rounds, "step"),
        gradient_steps=budget.updates_after_gathering,
        action_noise=NormalActionNoise(np.zeros(ACTION), np.full(ACTION, config["exploration_noise"])),
        policy_delay=config["policy_delay"],
        target_policy_noise=config["policy_noise"],
        target_noise_clip=config["policy_noise_clip"],
        policy_kwargs={"net_arch": [config["hidden_width"]] * config["hidden_layers"]},
        seed=seed,
        device="cpu",
    )


def train(config, ants, judges, budget, seed):
    """Seconds of learning and of evaluation, and evaluation's mean steps an episode; the warm-up is not timed."""
    td3 = model(config, ants, budget, seed)
    td3.learn(budget.warm_up_steps)
    before = td3._n_updates
    began = time.perf_counter()
    td3.learn(budget.steps, reset_num_timesteps=False)
    learned = time.perf_counter()
    if td3._n_updates - before != budget.updates:
        raise RuntimeError(f"Stable-Baselines3 made {td3._n_updates - before} updates, not {budget.updates}")
    if not budget.evaluation_episodes:
        return learned - began, 0.0, 0.0
    _, lengths = evaluate_policy(
        td3, judges, n_eval_episodes=budget.evaluation_episodes, return_episode_rewards=True, warn=False
    )
    return learned - began, time.perf_counter() - learned, float(np.mean(lengths))


class Updates:
    """Its update only, from a full replay buffer of noise."""

    def __init__(self, config, ants, budget):
        self.td3 = model(config, ants, budget, 0)
        # What `learn` sets up before it trains, such as loggers.
        self.td3._setup_learn(0)
        buffer, rng = self.td3.replay_buffer, np.random.default_rng(0)
        for numbers in (buffer.observations, buffer.next_observations, buffer.rewards):
            numbers[:] = rng.standard_normal(numbers.shape)
        buffer.actions[:] = rng.uniform(-1.0, 1.0, buffer.actions.shape)
        buffer.full = True
        self.batch = config["batch_size"]

    def per_s(self, updates):
        began = time.perf_counter()
        self.td3.train(updates, self.batch)
        return updates / (time.perf_counter() - began)
