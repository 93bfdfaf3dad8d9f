# Two commands do everything on a bare Debian 12 with rustup: `make demo`, `make test`.
#
#   make setup   what plain cargo needs: packages, libtorch, the AVR toolchain, ravedude
#   make demo    train, record, fit, start the virtual robot, upload, measure (SEED=1 for another gait)
#   make test    every check that a change must pass
#   make bench-peers   PyBullet, MuJoCo, PyTorch, Stable-Baselines3 against ours (6 GB in .deps)
#   make firmware / make clean

SEED ?= 0
PRESET ?= quick
AMP ?= 2.2
# Arguments of bench-peers: PEERS="--rounds 3 --updates 400 --json"
PEERS ?=

# The workspaces find each other's builds below this folder.
unexport CARGO_TARGET_DIR

.DEFAULT_GOAL := help
.PHONY: help setup deps demo test bench-peers firmware clean

help:
	@sed -n 's/^#  *\(make.*\)/  \1/p' Makefile

setup: deps
	scripts/setup-ravedude

deps:
	scripts/setup-packages
	scripts/setup-libtorch
	scripts/setup-avr

firmware: deps
	cd firmware && cargo build --release --locked
	scripts/firmware-size

demo: firmware
	cargo build --locked -p host -p sim-tests --bin host --bin virtual-robot
	target/debug/host demo --seed $(SEED) --preset $(PRESET) --amp $(AMP)

test: deps
	scripts/setup-packages --checks
	scripts/setup-checks
	scripts/check

# A folder without a pip of its own: that would need Debian's python3-venv.
bench-peers: deps
	cargo build --locked --release -p host
	test -x .deps/peers/bin/python || python3 -m venv --without-pip .deps/peers
	python3 -m pip --python .deps/peers/bin/python install --quiet -r scripts/peers/requirements.txt
	.deps/peers/bin/python scripts/bench-peers.py --check
	.deps/peers/bin/python scripts/bench-peers.py target/release/host $(PEERS)

clean:
	cargo clean
	cd firmware && cargo clean
