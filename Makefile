# What a person types first. Every target that builds runs setup.sh, which changes nothing that is in place.
CARGO ?= cargo
export PATH := $(PATH):$(HOME)/.cargo/bin
SHELL := bash

.PHONY: help setup build demo check test test-deep test-farm kill-matrix kill-matrix-part bench reports fuzz scenes doc deb deny

help: ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 22

setup: ## install what the build needs (Debian 12 and 13)
	@./setup.sh

build: setup ## the optimised binary, target/release/etendue
	$(CARGO) build --release --locked

demo: build ## render scenes/cornell-box to out/cornell-box.exr and .png
	@mkdir -p out
	@$(CARGO) run --release --locked --quiet -- render scenes/cornell-box/scene.gltf --spp 256 --png --output out/cornell-box.exr

# Dependencies are compiled once for clippy and once for the tests, and only étendue itself is built again without Embree:
# --workspace everywhere, since without it the features of shared dependencies change and all of them are built anew.
# The tests without Embree run in the copy of the repository that has the mutations, all of them off (tests/kill_matrix). So little
# is built for the kill matrix alone. The target folder is the same.
TARGET := $(abspath $(or $(CARGO_TARGET_DIR),target))
# Tests of the program, of files and of sampling. Unit tests, agreement and accel ask both backends in the run with Embree, and their
# killers run in the kill matrix. architecture and kill_matrix read the sources, which the mutations have changed. `make test-deep`
# runs unit tests and accel, too.
WITHOUT_EMBREE := --no-default-features --features cli --bins --test '[!ak]*'

# What to run while working: minutes, and no test that renders for long.
check: setup ## format, lints, architecture, mutations still fit, unit tests, tests of sampling and of paths
	$(CARGO) fmt --all --check
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings
	$(CARGO) test --locked --workspace --lib --test architecture --test kill_matrix --test sampling --test path

# Crates that only the command line and the lab may bring.
COMMAND_LINE := clap|clap_complete|indicatif|tev_client|plotters|maud

test: setup ## format, lints, architecture, all tests with and without Embree, documentation
	$(CARGO) fmt --all --check
	$(CARGO) test --locked --workspace --test architecture
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings
	$(CARGO) clippy --locked --lib --no-default-features -- -D warnings
	! $(CARGO) tree --locked --edges normal --no-default-features --prefix none | grep -E '^($(COMMAND_LINE)) '
	$(CARGO) test --locked --workspace
	$(CARGO) test --locked --workspace --test kill_matrix -- --build
	cd target/kill-matrix/tree && CARGO_TARGET_DIR=$(TARGET) $(CARGO) test --locked --workspace $(WITHOUT_EMBREE)
	$(CARGO) test --locked --workspace --test kill_matrix -- --today
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --workspace --no-deps

test-deep: setup scenes ## all tests, those that render for minutes included
	ETENDUE_TEST_DEEP=1 $(CARGO) test --locked --workspace
	$(CARGO) clippy --locked --workspace --all-targets --no-default-features --features cli -- -D warnings
	$(CARGO) test --locked --workspace --no-default-features --features cli --lib --test accel

# Needs root, Debian's munge, slurmctld, slurmd and slurm-client, and PyPI for openjd-cli (farm/README.md). ETENDUE names the binary.
test-farm: ## farm/: shards killed and requeued under a real Slurm, and run by openjd-cli (see farm/README.md)
	tests/farm/opencue.sh
	tests/farm/openjd.sh
	tests/farm/slurm.sh
	tests/farm/disks.sh

kill-matrix: setup ## turn on every mutation of tests/kill_matrix and see a test fail for each
	$(CARGO) test --locked --workspace --test kill_matrix -- --all

kill-matrix-part: setup ## the 24th of it whose turn it is today (ETENDUE_KILL_PART=0 to 23 chooses)
	$(CARGO) test --locked --workspace --test kill_matrix -- --today

bench: build ## time to error against other renderers, ray rates, start-up time (see bench/versus.sh)
	bench/versus.sh

reports: build ## the example pages in docs/reports, on a quiet machine (see bench/reports.sh)
	bench/reports.sh

# Needs cargo-fuzz and a nightly toolchain; FUZZ_SECONDS for each of the six targets. New finds go to fuzz/artifacts/.
# --release leaves the checks of debug builds to fuzz/Cargo.toml, which spares exr's wrapping arithmetic.
FUZZ_SECONDS ?= 900
fuzz: setup ## fuzz the readers of glTF, film, EXR, environments, render.toml and rays, a quarter of an hour each (FUZZ_SECONDS)
	for target in gltf film exr environment config rays; do \
	  mkdir -p fuzz/work/$$target fuzz/regressions/$$target && \
	  $(CARGO) +nightly fuzz run --release --fuzz-dir fuzz $$target fuzz/work/$$target fuzz/corpus/$$target \
	    fuzz/regressions/$$target -- -dict=fuzz/gltf.dict -max_len=16384 -rss_limit_mb=2048 -malloc_limit_mb=512 -timeout=10 \
	    -max_total_time=$(FUZZ_SECONDS) || exit 1; done

scenes: ## write the files of scenes/ anew
	scenes/make.py

doc: setup ## the documentation of the code, target/doc/etendue/index.html
	$(CARGO) doc --locked --workspace --no-deps --document-private-items

deb: build ## a Debian package in target/debian (needs cargo-deb)
	@mkdir -p target/man target/completions
	target/release/etendue man target/man
	target/release/etendue completions bash > target/completions/etendue
	$(CARGO) deb --no-build

deny: ## licences, advisories and sources of the dependencies (needs cargo-deny)
	$(CARGO) deny --locked check
