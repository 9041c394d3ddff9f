# Everything a person or CI runs by name. `make` alone lists it.

.PHONY: help build run test bench chart growth families peers peers-install check cluster-test

help:
	@sed -n 's/^## //p' Makefile

## build   the program for this machine's CPU: target/release/sfera; its manual page and completions beside it
# Linked with its libraries it starts in two thirds of the time; where the C library has no static form, without.
build:
	cargo rustc --release --bin sfera -- -C target-feature=+crt-static || cargo build --release
	target/release/sfera --generate man > target/release/sfera.1
	target/release/sfera --generate bash > target/release/sfera.bash
	target/release/sfera --generate zsh > target/release/_sfera
	target/release/sfera --generate fish > target/release/sfera.fish

## run     the example, at 1920 x 1080, to example.ppm
run: build
	target/release/sfera scenes/example.txt example.ppm 1920 1080

## test    every test twice, built for this CPU and for any of its kind; their pictures compared
HASHES := tmp/image-hashes.txt
test:
	rm -f target/$(HASHES) target/baseline/$(HASHES)
	cargo test --target-dir target
	RUSTFLAGS="-C target-cpu=generic" cargo test --target-dir target/baseline
	cmp target/$(HASHES) target/baseline/$(HASHES)

## bench   criterion benches; every one checks its answers first
bench:
	cargo bench --bench methods --bench engine

## chart   the charts of the README, measured again; of your own: make chart SCENES="my.txt"
chart:
	cargo bench --bench chart -- $(SCENES)

## growth  the chart of growth alone; Embree's figures in it are those of the last `make peers`
growth:
	cargo bench --bench chart -- growth

## families   every family of hard scenes as files, to target/families
families:
	cargo bench --bench families

## peers   sfera and what people would use instead, on the same scenes; table to benches/peers/results.md
peers:
	python3 benches/peers/run.py $(PEERS)

## peers-install   the peers of `make peers`, from Debian's packages
peers-install:
	apt-get install -y gcc g++ libembree-dev libtbb-dev tachyon povray

## cluster-test   the recipes of tests/cluster on a Slurm of two nodes on this machine, for root on Debian; three minutes
cluster-test: build
	SFERA=target/release/sfera tests/cluster/run.sh

## check   format, lints, docs
check:
	cargo fmt --check
	cargo clippy --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps
