#!/usr/bin/env python3
"""Writes host/src/learn/td3/agent/reference.json: the results of two TD3 updates in PyTorch.

Independent of the Rust code: nn.Linear, autograd and torch.optim.Adam, in double
precision, after Fujimoto et al. (2018), algorithm 1. Update 1 moves the critics
alone, update 2 the critics, the actor and all targets. The numbers are checked
in; to make them again (any torch of the last years gives the same to 1e-9):

    pip install torch && scripts/td3-reference.py
"""

import copy
import json
import pathlib

import torch
from torch import nn

OBSERVATION, ACTION, HIDDEN, BATCH = 3, 2, [5, 4], 6
# Steps large enough that a wrong optimiser shows in five digits.
CONFIG = {
    "actor_learning_rate": 0.02,
    "critic_learning_rate": 0.05,
    "gamma": 0.99,
    "tau": 0.05,
    "policy_delay": 2,
    "policy_noise": 0.4,
    "policy_noise_clip": 0.5,
}


def network(inputs, outputs):
    layers = []
    for width in HIDDEN:
        layers += [nn.Linear(inputs, width), nn.ReLU()]
        inputs = width
    return nn.Sequential(*layers, nn.Linear(inputs, outputs)).double()


def rounded(tensor):
    """Numbers that single precision holds to its last digit in a short text."""
    return (tensor * 1024).round() / 1024


def linear_layers(net):
    return [layer for layer in net if isinstance(layer, nn.Linear)]


def numbers(net):
    """Weights as [outputs][inputs], and biases."""
    return [{"weight": l.weight.tolist(), "bias": l.bias.tolist()} for l in linear_layers(net)]


def gradients(net):
    return [{"weight": l.weight.grad.tolist(), "bias": l.bias.grad.tolist()} for l in linear_layers(net)]


def draw(net):
    with torch.no_grad():
        for parameter in net.parameters():
            parameter.copy_(rounded(torch.randn_like(parameter) * 0.7))
    return net


def main():
    torch.manual_seed(21)
    actor, target_actor = (draw(network(OBSERVATION, ACTION)) for _ in range(2))
    critics, target_critics = ([draw(network(OBSERVATION + ACTION, 1)) for _ in range(2)] for _ in range(2))
    nets = {"actor": [actor], "critics": critics, "target_actor": [target_actor], "target_critics": target_critics}
    everything = lambda: {name: [numbers(net) for net in group] for name, group in copy.deepcopy(nets).items()}
    before = everything()

    actor_adam = torch.optim.Adam(actor.parameters(), lr=CONFIG["actor_learning_rate"])
    critic_parameters = [p for critic in critics for p in critic.parameters()]
    critics_adam = torch.optim.Adam(critic_parameters, lr=CONFIG["critic_learning_rate"])

    updates = []
    for update in (1, 2):
        observation, following = (rounded(torch.randn(BATCH, OBSERVATION).double()) for _ in range(2))
        action = rounded(torch.rand(BATCH, ACTION).double() * 2 - 1)
        reward = rounded(torch.randn(BATCH, 1).double())
        # Two of the six rows end the task.
        continuation = torch.tensor([[1.0], [0.0], [1.0], [1.0], [0.0], [1.0]]).double()
        normals = rounded(torch.randn(BATCH, ACTION).double() * 1.5)

        with torch.no_grad():
            noise = (normals * CONFIG["policy_noise"]).clamp(-CONFIG["policy_noise_clip"], CONFIG["policy_noise_clip"])
            next_action = (target_actor(following).tanh() + noise).clamp(-1, 1)
            judged = torch.cat([following, next_action], 1)
            first, second = (critic(judged) for critic in target_critics)
            smaller = torch.min(first, second)
            target = reward + CONFIG["gamma"] * continuation * smaller

        values = [critic(torch.cat([observation, action], 1)) for critic in critics]
        critic_loss = sum(nn.functional.mse_loss(value, target) for value in values)
        critics_adam.zero_grad()
        critic_loss.backward()
        record = {"critic_loss": critic_loss.item(), "critic_gradients": [gradients(c) for c in critics]}
        critics_adam.step()

        if update % CONFIG["policy_delay"] == 0:
            actor_loss = -critics[0](torch.cat([observation, actor(observation).tanh()], 1)).mean()
            actor_adam.zero_grad()
            actor_loss.backward()
            record |= {"actor_loss": actor_loss.item(), "actor_gradients": [gradients(actor)]}
            actor_adam.step()
            with torch.no_grad():
                for net, slow in [(actor, target_actor), *zip(critics, target_critics)]:
                    for parameter, follower in zip(net.parameters(), slow.parameters()):
                        follower.lerp_(parameter, CONFIG["tau"])

        rows = torch.cat([observation, action, reward, continuation, following], 1)
        updates.append({
            "batch": rows.tolist(),
            "normals": normals.tolist(),
            "clipped_noise": int((normals * CONFIG["policy_noise"]).abs().gt(CONFIG["policy_noise_clip"]).sum()),
            "second_critic_smaller": int((second < first).sum()),
            "target": target.flatten().tolist(),
            "after": everything(),
            **record,
        })

    document = {
        "made_by": f"scripts/td3-reference.py, torch {torch.__version__}",
        "observation_len": OBSERVATION,
        "action_len": ACTION,
        "hidden": HIDDEN,
        "config": CONFIG,
        "before": before,
        "updates": updates,
    }
    shorten = lambda x: (
        {k: shorten(v) for k, v in x.items()} if isinstance(x, dict)
        else [shorten(v) for v in x] if isinstance(x, list)
        else float(f"{x:.10g}") if isinstance(x, float) else x
    )
    path = pathlib.Path(__file__).resolve().parent.parent / "host/src/learn/td3/agent/reference.json"
    path.write_text(json.dumps(shorten(document), separators=(",", ":")).replace('"updates"', '\n"updates"').replace(',"after"', ',\n"after"') + "\n")
    print(path)


if __name__ == "__main__":
    main()
