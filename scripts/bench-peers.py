#!/usr/bin/env python3
"""PyTorch's TD3 update against ours, in turns on the same machine (make bench-peers).

Networks, batch and constants are Table 1's; batches are drawn from a buffer as
long. "plain" is the loop as most write it; "fused" saves what PyTorch lets one
save: fused Adam, both critics in one loss, targets moved by one foreach call.
One thread each. Prints ratios within a round, and their spread.
"""

import json
import statistics
import subprocess
import sys
import time

import torch
from torch import nn

OBSERVATION, ACTION, WIDTH, BATCH, BUFFER = 27, 8, 128, 128, 20_000
ROUNDS, UPDATES = 7, 300


def network(inputs, outputs):
    layers = []
    for _ in range(3):
        layers += [nn.Linear(inputs, WIDTH), nn.ReLU()]
        inputs = WIDTH
    return nn.Sequential(*layers, nn.Linear(WIDTH, outputs))


class Learner:
    def __init__(self, fused):
        self.actor, self.target_actor = network(OBSERVATION, ACTION), network(OBSERVATION, ACTION)
        self.critics = [network(OBSERVATION + ACTION, 1) for _ in range(2)]
        self.target_critics = [network(OBSERVATION + ACTION, 1) for _ in range(2)]
        nets = [self.actor, *self.critics]
        slow = [self.target_actor, *self.target_critics]
        for fast, target in zip(nets, slow):
            target.load_state_dict(fast.state_dict())
        self.fused = fused
        self.actor_adam = torch.optim.Adam(self.actor.parameters(), lr=3e-4, fused=fused)
        parameters = [p for critic in self.critics for p in critic.parameters()]
        self.critics_adam = torch.optim.Adam(parameters, lr=1e-3, fused=fused)
        self.fast_parameters = [p for net in nets for p in net.parameters()]
        self.slow_parameters = [p for net in slow for p in net.parameters()]
        self.observation, self.following = torch.randn(BUFFER, OBSERVATION), torch.randn(BUFFER, OBSERVATION)
        self.action = torch.rand(BUFFER, ACTION) * 2 - 1
        self.reward, self.continuation = torch.randn(BUFFER, 1), torch.ones(BUFFER, 1)
        self.updates = 0

    def update(self):
        self.updates += 1
        rows = torch.randint(BUFFER, (BATCH,))
        observation, action, following = self.observation[rows], self.action[rows], self.following[rows]
        with torch.no_grad():
            noise = (torch.randn_like(action) * 0.2).clamp_(-0.5, 0.5)
            judged = torch.cat([following, (self.target_actor(following).tanh() + noise).clamp_(-1, 1)], 1)
            smaller = torch.min(self.target_critics[0](judged), self.target_critics[1](judged))
            target = self.reward[rows] + 0.99 * self.continuation[rows] * smaller
        judged = torch.cat([observation, action], 1)
        loss = sum(nn.functional.mse_loss(critic(judged), target) for critic in self.critics)
        self.critics_adam.zero_grad(set_to_none=True)
        loss.backward()
        self.critics_adam.step()
        if self.updates % 2 == 0:
            loss = -self.critics[0](torch.cat([observation, self.actor(observation).tanh()], 1)).mean()
            self.actor_adam.zero_grad(set_to_none=True)
            loss.backward()
            self.actor_adam.step()
            with torch.no_grad():
                if self.fused:
                    torch._foreach_lerp_(self.slow_parameters, self.fast_parameters, 0.005)
                else:
                    for slow, fast in zip(self.slow_parameters, self.fast_parameters):
                        slow.mul_(0.995).add_(fast, alpha=0.005)


def rate(learner):
    began = time.perf_counter()
    for _ in range(UPDATES):
        learner.update()
    return UPDATES / (time.perf_counter() - began)


def main():
    host = sys.argv[1] if len(sys.argv) > 1 else "target/release/host"
    torch.set_num_threads(1)
    learners = {"PyTorch plain": Learner(False), "PyTorch fused": Learner(True)}
    for learner in learners.values():
        rate(learner)
    ratios = {name: [] for name in learners}
    for number in range(1, ROUNDS + 1):
        theirs = {name: rate(learner) for name, learner in learners.items()}
        output = subprocess.run([host, "bench", "--rounds", "1", "--json"], capture_output=True, check=True).stdout
        ours = json.loads(output)["updates_per_s"]
        for name, value in theirs.items():
            ratios[name].append(ours / value)
        row = ", ".join(f"{name} {value:.0f}" for name, value in theirs.items())
        print(f"round {number}: updates/s: ours {ours:.0f}, {row}", flush=True)
    for name, values in ratios.items():
        print(f"ours / {name}: {statistics.median(values):.2f} ({min(values):.2f} to {max(values):.2f})")


if __name__ == "__main__":
    main()
