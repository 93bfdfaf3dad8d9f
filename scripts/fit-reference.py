#!/usr/bin/env python3
"""Checks `host fit --seam free` against scikit-learn: PolynomialFeatures(10) + LinearRegression.

Check the fit of a trajectory, in units of action; here the authors' loop:

    scripts/fit-reference.py --host target/debug/host ant-trajectory.csv \
        --rows 973..1000 --map host/configs/authors-map.toml

Without a trajectory, writes host/src/gait/fit/reference.json: a synthetic one, and
scikit-learn's curve through it, which a test compares the fit with, without Python.

Needs `pip install scikit-learn numpy`, Python 3.11. Time runs from 0 at the
first row to 1 at the last, as phase does with a free seam.

Since 1.7 scikit-learn leaves out singular values below `tol` = 1e-6 of the
largest; the powers of time reach down to 1e-7, so its default now drops a
direction of the ten (the authors' loop: R2 of hip 4 falls from 0.931 to 0.913,
the curve moves by up to 0.07). Least squares proper, as every release did when
the paper was written, is `tol` at rounding: that is what is compared with.
"""

import argparse
import csv
import inspect
import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from sklearn.linear_model import LinearRegression
from sklearn.preprocessing import PolynomialFeatures

DEGREE = 10
JOINTS = [f"hip{leg}" for leg in range(1, 5)] + [f"knee{leg}" for leg in range(1, 5)]
REFERENCE = pathlib.Path(__file__).parent.parent / "host/src/gait/fit/reference.json"
TOLERANCE = 1e-6
HAS_TOL = "tol" in inspect.signature(LinearRegression).parameters
LEAST_SQUARES = {"tol": 1e-14} if HAS_TOL else {}


def sklearn_curve(actions, phases):
    """The curve through equally spaced actions, at phases, and its mean over the stride."""
    time = np.linspace(0, 1, len(actions)).reshape(-1, 1)
    features = PolynomialFeatures(DEGREE, include_bias=False)
    model = LinearRegression(**LEAST_SQUARES).fit(features.fit_transform(time), actions)
    values = model.predict(features.transform(np.reshape(phases, (-1, 1))))
    integral = polynomial.polyint(np.concatenate([[model.intercept_], model.coef_]))
    return values, polynomial.polyval(1.0, integral)


def r2(actions):
    fitted, _ = sklearn_curve(actions, np.linspace(0, 1, len(actions)))
    return 1 - np.sum((actions - fitted) ** 2) / np.sum((actions - np.mean(actions)) ** 2)


def canonical(name):
    return name.strip().lower().replace("ank", "knee")


def check(arguments):
    first, end = map(int, arguments.rows.split(".."))
    with open(arguments.trajectory, newline="") as file:
        rows = list(csv.DictReader(file))[first:end]
    columns = {canonical(name): np.array([float(row[name]) for row in rows]) for name in rows[0]}
    scales = {"negate": [], "unit_deg": 24.0, "centre_unit_deg": 45.0, "centre_offset_deg": 0.0}
    if arguments.map:
        scales |= tomllib.loads(pathlib.Path(arguments.map).read_text())
    negated = {canonical(name) for name in scales["negate"]}

    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "gait.toml"
        command = [arguments.host, "fit", arguments.trajectory, "--rows", arguments.rows, "--period", "4"]
        command += ["--seam", "free", "--lag", "--out", str(out), "--json"]
        command += ["--map", arguments.map] if arguments.map else []
        report = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
        gait = tomllib.loads(out.read_text())

    phases = np.linspace(0, 1, 1001)
    worst = worst_r2 = 0.0
    for joint, reported in zip(gait["joint"], report["joints"]):
        actions = columns[joint["name"]] * (-1 if joint["name"] in negated else 1)
        curve, mean = sklearn_curve(actions, phases)
        deviation = chebyshev.chebval(2 * phases - 1, joint["coefficients_deg"]) / scales["unit_deg"]
        centre = (joint["centre_deg"] - scales["centre_offset_deg"]) / scales["centre_unit_deg"]
        difference = np.max(np.abs(deviation + centre - curve))
        worst = max(worst, difference)
        worst_r2 = max(worst_r2, abs(reported["r2"] - r2(actions)))
        print(f"{joint['name']:6} differs by at most {difference:.2e} action, R2 {reported['r2']:.4f}")
    print(f"worst of all joints: {worst:.2e} action, or {worst * scales['unit_deg']:.2e} degrees at amplitude 1.0;")
    print(f"R2 by {worst_r2:.2e}; allowed {TOLERANCE:.0e} action")
    return worst <= TOLERANCE and worst_r2 <= TOLERANCE


def write_reference():
    random = np.random.default_rng(21)
    time = np.arange(27) / 27
    joints = []
    for joint in range(len(JOINTS)):
        phase, size = random.uniform(0, 2 * np.pi), random.uniform(0.1, 0.6)
        clean = size * np.sin(2 * np.pi * 2 * time + phase) + 0.2 * size * np.sin(2 * np.pi * 5 * time)
        noisy = clean + random.uniform(-0.4, 0.4) + random.normal(0, 0.02, len(time))
        # Short numbers that mean the same to everybody.
        joints.append(np.round(noisy * 4096) / 4096)
    phases = np.linspace(0, 1, 105)
    curves = [sklearn_curve(actions, phases) for actions in joints]
    reference = {
        "made_by": "scripts/fit-reference.py",
        "rows": np.transpose(joints).tolist(),
        "phases": phases.tolist(),
        "curves": [values.tolist() for values, _ in curves],
        "means": [mean for _, mean in curves],
        "r2": [r2(actions) for actions in joints],
    }
    lines = (f'  "{key}": {json.dumps(value)}' for key, value in reference.items())
    REFERENCE.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    print(f"wrote {REFERENCE}")
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trajectory", nargs="?")
    parser.add_argument("--rows", default="0..27")
    parser.add_argument("--map")
    parser.add_argument("--host", default="target/debug/host")
    arguments = parser.parse_args()
    sys.exit(not (check(arguments) if arguments.trajectory else write_reference()))


if __name__ == "__main__":
    main()
