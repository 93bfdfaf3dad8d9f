"""What `make bench-peers` prints: a table for people, an object for programs.

Holds the texts and the statistics of a figure. Does not depend on how it was measured.
"""

import os
import statistics
import sys

import mujoco
import pybullet
import stable_baselines3
import torch

KINDS = {
    "walking": "control steps/s walking, one thread",
    "updates": "updates/s, one thread",
    "training": "control steps/s of training, evaluation included",
    "learning": "control steps/s of training, without evaluation",
    "episode": "control steps of an episode of the evaluation",
}


def spread(values):
    return {"median": statistics.median(values), "least": min(values), "largest": max(values)}


def words(value, decimals):
    return f"{value['median']:.{decimals}f} ({value['least']:.{decimals}f} to {value['largest']:.{decimals}f})"


def table(peers, rounds, figures, ratios):
    budget = peers.budget
    print(
        f"\nMedians of {rounds} rounds (minimum to maximum); a round trains {budget.updates} updates,"
        f" {budget.share:.2%} of the paper's budget, with {budget.evaluation_episodes} episodes of evaluation."
    )
    for kind, title in KINDS.items():
        print(f"\n{title}")
        for name, values in figures[kind].items():
            ratio = ratios[kind].get(name)
            line = f"  {name:<32} {words(spread(values), 0):<28}"
            print(line + (f" ours is {words(spread(ratio), 2)} times as fast" if ratio else ""))
    print("\nWhich way of training is fastest here, control steps/s in a short trial; the best was used:")
    for name, rate in peers.trials.items():
        print(f"  {name:<52} {rate:.0f}")


def as_json(peers, rounds, figures, ratios):
    spreads = {kind: {name: spread(values) for name, values in of.items()} for kind, of in figures.items()}
    budget = peers.budget
    return {
        "rounds": rounds,
        "updates": budget.updates,
        "share_of_budget": budget.share,
        "evaluation_episodes": budget.evaluation_episodes,
        "preset": "paper",
        "cores": os.cpu_count(),
        "versions": {
            "python": sys.version.split()[0],
            "torch": torch.__version__,
            "stable_baselines3": stable_baselines3.__version__,
            "pybullet": str(pybullet.getAPIVersion()),
            "mujoco": mujoco.__version__,
        },
        "units": KINDS,
        "figures": spreads,
        "ours_over": {
            kind: {name: spread(values) for name, values in of.items()} for kind, of in ratios.items() if of
        },
        "trials_env_steps_per_s": peers.trials,
        "pytorch_threads": {"plain loop": peers.plain_threads, "Stable-Baselines3": peers.sb3_threads},
        "pybullet_process_a_robot": peers.sb3_processes,
    }
