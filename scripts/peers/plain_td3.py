"""TD3 as a plain PyTorch loop, and that loop training in MuJoCo.

Networks, batch and constants are host/configs/paper.toml's. "plain" is the update as it
is usually written; "fused" uses PyTorch's faster calls: fused Adam, both critics in one
loss, target networks updated by one foreach call.
"""

import time

import numpy as np
import torch
from torch import nn

from peers.task import ACTION, OBSERVATION


def network(config, inputs, outputs):
    layers = []
    for _ in range(config["hidden_layers"]):
        layers += [nn.Linear(inputs, config["hidden_width"]), nn.ReLU()]
        inputs = config["hidden_width"]
    return nn.Sequential(*layers, nn.Linear(inputs, outputs))


class Replay:
    """The replay buffer, a ring buffer of transitions."""

    def __init__(self, size):
        self.size, self.filled, self.next = size, 0, 0
        self.observation, self.following = torch.zeros(size, OBSERVATION), torch.zeros(size, OBSERVATION)
        self.action, self.reward = torch.zeros(size, ACTION), torch.zeros(size, 1)
        self.continuation = torch.ones(size, 1)

    def add(self, observation, action, reward, following, fell):
        rows = torch.arange(self.next, self.next + len(observation)) % self.size
        self.observation[rows] = torch.from_numpy(observation)
        self.action[rows] = torch.from_numpy(action.astype(np.float32))
        self.reward[rows, 0] = torch.from_numpy(reward.astype(np.float32))
        self.following[rows] = torch.from_numpy(following)
        # A time limit is not terminal.
        self.continuation[rows, 0] = torch.from_numpy((~fell).astype(np.float32))
        self.next = (self.next + len(observation)) % self.size
        self.filled = min(self.filled + len(observation), self.size)

    def fill_with_noise(self):
        for numbers in (self.observation, self.following, self.reward):
            numbers.normal_()
        self.action.uniform_(-1.0, 1.0)
        self.filled = self.size
        return self


class Learner:
    def __init__(self, config, fused):
        self.config, self.fused = config, fused
        self.actor = network(config, OBSERVATION, ACTION)
        self.target_actor = network(config, OBSERVATION, ACTION)
        self.critics = [network(config, OBSERVATION + ACTION, 1) for _ in range(2)]
        self.target_critics = [network(config, OBSERVATION + ACTION, 1) for _ in range(2)]
        nets = [self.actor, *self.critics]
        slow = [self.target_actor, *self.target_critics]
        for fast, target in zip(nets, slow):
            target.load_state_dict(fast.state_dict())
        actor = self.actor.parameters()
        self.actor_adam = torch.optim.Adam(actor, lr=config["actor_learning_rate"], fused=fused)
        parameters = [p for critic in self.critics for p in critic.parameters()]
        self.critics_adam = torch.optim.Adam(parameters, lr=config["critic_learning_rate"], fused=fused)
        self.fast_parameters = [p for net in nets for p in net.parameters()]
        self.slow_parameters = [p for net in slow for p in net.parameters()]
        self.replay = Replay(config["buffer_size"])
        self.updates = 0

    def act(self, observation):
        with torch.no_grad():
            return self.actor(torch.from_numpy(observation)).tanh().numpy()

    def update(self):
        self.updates += 1
        config, replay = self.config, self.replay
        rows = torch.randint(replay.filled, (config["batch_size"],))
        observation, action, following = replay.observation[rows], replay.action[rows], replay.following[rows]
        with torch.no_grad():
            clip = config["policy_noise_clip"]
            noise = (torch.randn_like(action) * config["policy_noise"]).clamp_(-clip, clip)
            judged = torch.cat([following, (self.target_actor(following).tanh() + noise).clamp_(-1, 1)], 1)
            smaller = torch.min(self.target_critics[0](judged), self.target_critics[1](judged))
            target = replay.reward[rows] + config["gamma"] * replay.continuation[rows] * smaller
        judged = torch.cat([observation, action], 1)
        loss = sum(nn.functional.mse_loss(critic(judged), target) for critic in self.critics)
        self.critics_adam.zero_grad(set_to_none=True)
        loss.backward()
        self.critics_adam.step()
        if self.updates % config["policy_delay"] == 0:
            loss = -self.critics[0](torch.cat([observation, self.actor(observation).tanh()], 1)).mean()
            self.actor_adam.zero_grad(set_to_none=True)
            loss.backward()
            self.actor_adam.step()
            tau = config["tau"]
            with torch.no_grad():
                if self.fused:
                    torch._foreach_lerp_(self.slow_parameters, self.fast_parameters, tau)
                else:
                    for slow, fast in zip(self.slow_parameters, self.fast_parameters):
                        slow.mul_(1.0 - tau).add_(fast, alpha=tau)


def updates_per_s(learner, updates):
    """Updates a second of a learner whose replay buffer is full."""
    began = time.perf_counter()
    for _ in range(updates):
        learner.update()
    return updates / (time.perf_counter() - began)


def train(config, ants, judges, budget, seed):
    """Seconds of learning and of evaluation, and evaluation's mean steps an episode; the warm-up is not timed."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    learner = Learner(config, fused=True)
    robots, noise = len(ants.worlds), config["exploration_noise"]

    def gather(action):
        observation = ants.observation
        following, reward, fell, _ = ants.step(action)
        learner.replay.add(observation, action, reward, following, fell)

    for _ in range(budget.warm_up_steps // robots):
        gather(rng.uniform(-1.0, 1.0, (robots, ACTION)))
    began = time.perf_counter()
    while learner.updates < budget.updates:
        for _ in range(budget.gather_rounds):
            disturbed = learner.act(ants.observation) + rng.normal(0.0, noise, (robots, ACTION))
            gather(np.clip(disturbed, -1.0, 1.0))
        for _ in range(budget.updates_after_gathering):
            learner.update()
    learned = time.perf_counter()
    if not budget.evaluation_episodes:
        return learned - began, 0.0, 0.0
    steps = evaluate(learner, judges, budget.evaluation_episodes)
    return learned - began, time.perf_counter() - learned, steps


def evaluate(learner, judges, episodes):
    """Plays episodes without noise, the same number with each robot; mean steps of an episode."""
    robots = len(judges.worlds)
    left = np.array([(episodes + robot) // robots for robot in range(robots)])
    for robot in range(robots):
        judges.reset(robot)
    judges.observation, steps = judges.observe(), 0
    while left.any():
        playing = np.flatnonzero(left)
        _, _, fell, cut = judges.step(learner.act(judges.observation), playing)
        steps += len(playing)
        left[playing] -= (fell | cut)[playing]
    return steps / episodes
