#!/usr/bin/env python3
"""Compares ours with PyBullet, MuJoCo, PyTorch and Stable-Baselines3 (make bench-peers).

The task, the learner's sizes and the steps an update are host/configs/paper.toml's,
of which every round trains a stated fraction, evaluation included. All kinds of work
alternate in every round; ratios are made within a round and printed with their spread.
docs/learning-reasons.md says what differs between the engines. --check measures nothing
but compares the peers' bodies and task.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
# PyBullet prints to file 1 from C, whenever its buffer likes; that file is for the result.
sys.stdout = os.fdopen(os.dup(1), "w", buffering=1)
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
REQUIREMENTS = pathlib.Path(__file__).resolve().parent / "peers/requirements.txt"
try:
    import mujoco  # noqa: F401
    import numpy as np
    import pybullet  # noqa: F401
    import stable_baselines3  # noqa: F401
    import torch
except ImportError as missing:
    sys.exit(
        f"bench-peers: {missing.name} is not installed for {sys.executable}\n"
        f"next: make bench-peers, or python3 -m pip --python {sys.executable} install -r {REQUIREMENTS}"
    )

from peers import body, check, plain_td3, report, sb3_td3
from peers.bullet_ant import BulletAnt
from peers.mujoco_ants import MujocoAnts
from peers.task import Task, Unsupported, trot

# Of a slice; about as long as ours in `host bench`.
WALKING_STEPS = {"MuJoCo": 8_000, "PyBullet": 2_400}
UPDATES = 300
# Updates of the trials that tell how a peer trains fastest.
TRIAL_UPDATES = 40


class Budget:
    """A part of the schedule that both peers can keep to: robots step together, so several updates follow."""

    def __init__(self, schedule, updates):
        self.robots = schedule["training_envs"]
        per_update = schedule["env_steps_per_update"]
        # The fewest steps of all robots together that are a whole number of updates.
        together = int(np.lcm(self.robots, per_update))
        self.gather_rounds, self.updates_after_gathering = together // self.robots, together // per_update
        if updates % self.updates_after_gathering:
            raise ValueError(
                f"--updates {updates}: {self.robots} robots that step together make"
                f" {self.updates_after_gathering} updates at a time; take a multiple of that"
            )
        self.updates, self.steps = updates, updates * per_update
        self.share = updates / (schedule["epochs"] * schedule["updates_per_epoch"])
        # As `host bench` shortens it.
        episodes = schedule["evaluation_episodes"] * updates / schedule["updates_per_epoch"]
        self.evaluation_episodes = max(1, int(episodes + 0.5))
        # Random actions, not timed; `host bench` has as many.
        self.warm_up_steps = 1_000

    def uneven(self):
        """Whether some robots would play more episodes of an evaluation than others."""
        return self.evaluation_episodes % self.robots != 0


def walk_mujoco(ants):
    robots, began = len(ants.worlds), time.perf_counter()
    for step in range(WALKING_STEPS["MuJoCo"] // robots):
        ants.step(np.broadcast_to(trot(step), (robots, 8)))
    return WALKING_STEPS["MuJoCo"] / (time.perf_counter() - began)


def walk_bullet(ant):
    ant.reset()
    began = time.perf_counter()
    for step in range(WALKING_STEPS["PyBullet"]):
        _, _, fell, cut, _ = ant.step(trot(step))
        if fell or cut:
            ant.reset()
    return WALKING_STEPS["PyBullet"] / (time.perf_counter() - began)


class Peers:
    def __init__(self, updates, folder):
        task = Task()
        self.config, self.schedule = task.config["td3"], task.config["schedule"]
        self.budget = Budget(self.schedule, updates)
        robots = self.budget.robots
        self.ants, self.judges = MujocoAnts(task, robots, 0), MujocoAnts(task, robots, 1)
        urdf = folder / "ant.urdf"
        urdf.write_text(body.urdf(task, self.ants.model))
        # Processes are forked before PyTorch has any threads.
        self.bullets = {
            processes: [sb3_td3.environments(task, urdf, robots, processes) for _ in range(2)]
            for processes in (True, False)
        }
        self.bullet = BulletAnt(task, urdf)
        torch.manual_seed(0)
        self.learners = {
            "PyTorch, plain loop": plain_td3.Learner(self.config, fused=False),
            "PyTorch, fused Adam and foreach": plain_td3.Learner(self.config, fused=True),
        }
        for learner in self.learners.values():
            learner.replay.fill_with_noise()
        self.sb3_updates = sb3_td3.Updates(self.config, self.bullets[False][0], self.budget)
        self.choose()

    def choose(self):
        """Each peer trains with what is fastest for it here: threads of PyTorch, processes of PyBullet."""
        trial, cores = Budget(self.schedule, TRIAL_UPDATES), torch.get_num_threads()
        trial.evaluation_episodes = 0
        self.trials, best = {}, {}
        for threads in sorted({1, cores}):
            torch.set_num_threads(threads)
            for processes in (None, False, True):
                if processes is None:
                    name, way = "PyTorch", plain_td3.train
                    robots = self.ants, self.judges
                else:
                    name, way = "Stable-Baselines3", sb3_td3.train
                    robots = self.bullets[processes]
                rate = trial.steps / way(self.config, *robots, trial, 0)[0]
                # The first time warms up, but does not make up for as much as that.
                if rate > best.get(name, (0.0,))[0] / 4.0:
                    rate = trial.steps / way(self.config, *robots, trial, 1)[0]
                where = "" if processes is None else ", a process a robot" if processes else ", one process"
                self.trials[f"{name}, {threads} thread{'s' * (threads > 1)}{where}"] = rate
                if rate > best.get(name, (0.0,))[0]:
                    best[name] = rate, threads, processes
        self.plain_threads = best["PyTorch"][1]
        self.sb3_threads, self.sb3_processes = best["Stable-Baselines3"][1:]

    def round(self, number):
        """Figures of every peer: what, whose, value."""
        torch.set_num_threads(1)
        yield "walking", "PyBullet", walk_bullet(self.bullet)
        yield "walking", "MuJoCo", walk_mujoco(self.ants)
        for name, learner in self.learners.items():
            yield "updates", name, plain_td3.updates_per_s(learner, UPDATES)
        yield "updates", "Stable-Baselines3", self.sb3_updates.per_s(UPDATES)
        torch.set_num_threads(self.plain_threads)
        took = plain_td3.train(self.config, self.ants, self.judges, self.budget, number)
        yield from self.trained("plain PyTorch loop with MuJoCo", *took)
        torch.set_num_threads(self.sb3_threads)
        took = sb3_td3.train(self.config, *self.bullets[self.sb3_processes], self.budget, number)
        yield from self.trained("Stable-Baselines3 with PyBullet", *took)

    def trained(self, name, learning_s, evaluation_s, episode_steps):
        yield "training", name, self.budget.steps / (learning_s + evaluation_s)
        yield "learning", name, self.budget.steps / learning_s
        yield "episode", name, episode_steps

    def close(self):
        for pair in self.bullets.values():
            for environments in pair:
                environments.close()


def ours(host, updates):
    command = [host, "bench", "--rounds", "1", "--json", "--preset", "paper", "--updates", str(updates)]
    try:
        output = subprocess.run(command, capture_output=True, check=True, text=True).stdout
    except FileNotFoundError:
        sys.exit(f"bench-peers: there is no {host}\nnext: cargo build --release -p host")
    except subprocess.CalledProcessError as error:
        sys.exit(f"bench-peers: {' '.join(command)} ended with {error.returncode}:\n{error.stderr}")
    figures = json.loads(output)
    return {
        "walking": figures["env_steps_per_s"],
        "updates": figures["updates_per_s"],
        "training": figures["train_steps_per_s"],
        "learning": figures["learn_steps_per_s"],
        "episode": figures["evaluation_episode_steps"],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("host", nargs="?", default="target/release/host", help="our command (%(default)s)")
    parser.add_argument("--rounds", type=int, default=5, help="number of rounds (%(default)s)")
    parser.add_argument("--updates", type=int, default=1200, help="updates of the training in each round (%(default)s)")
    parser.add_argument("--json", action="store_true", help="print one line of JSON on standard output")
    parser.add_argument("--check", action="store_true", help="check the peers' bodies and task, and stop")
    arguments = parser.parse_args()
    if arguments.rounds < 1 or arguments.updates < 1:
        parser.error(f"--rounds {arguments.rounds} --updates {arguments.updates}: both are 1 or more")
    if arguments.check:
        sys.exit(check.report())

    def say(line):
        print(line, file=sys.stderr, flush=True)

    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        try:
            Budget(Task().config["schedule"], arguments.updates)
            peers = Peers(arguments.updates, pathlib.Path(folder))
        except (Unsupported, ValueError) as error:
            sys.exit(f"bench-peers: {error}")
        if peers.budget.uneven():
            say(
                f"note: {peers.budget.evaluation_episodes} episodes of evaluation do not share out evenly among"
                f" {peers.budget.robots} robots; Stable-Baselines3 then simulates more than it needs"
            )
        say(f"ready after {time.perf_counter() - started:.0f} s")
        figures, ratios = {kind: {} for kind in report.KINDS}, {kind: {} for kind in report.KINDS}
        for number in range(1, arguments.rounds + 1):
            began = time.perf_counter()
            mine = ours(arguments.host, arguments.updates)
            for kind, value in mine.items():
                figures[kind].setdefault("ours", []).append(value)
            for kind, name, value in peers.round(number):
                figures[kind].setdefault(name, []).append(value)
                if kind != "episode":
                    ratios[kind].setdefault(name, []).append(mine[kind] / value)
            say(f"round {number} of {arguments.rounds}: {time.perf_counter() - began:.0f} s")
        peers.close()
        if arguments.json:
            print(json.dumps(report.as_json(peers, arguments.rounds, figures, ratios)))
        else:
            report.table(peers, arguments.rounds, figures, ratios)


if __name__ == "__main__":
    main()
