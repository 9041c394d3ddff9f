# Everything a person or CI runs by name. `make` alone lists it.

.PHONY: help build run test checked fuzz mutants sanitize sanitize-threads proof deny bench chart growth families peers peers-install splat api check cluster-test everywhere

help:
	@sed -n 's/^## //p' Makefile

## build   the program for this machine's CPU: target/release/sfera; its manual page and completions beside it
# A statically linked program starts in two thirds of the time; where the C library has no static form, it is linked dynamically.
build:
	cargo rustc --release --bin sfera -- -C target-feature=+crt-static || cargo build --release
	target/release/sfera --generate man > target/release/sfera.1
	target/release/sfera --generate bash > target/release/sfera.bash
	target/release/sfera --generate zsh > target/release/_sfera
	target/release/sfera --generate fish > target/release/sfera.fish

## run     the example, at 1920 x 1080, to example.ppm
run: build
	target/release/sfera scenes/example.txt example.ppm 1920 1080

## test    every test, built for this CPU; those that depend on the build also built for any CPU of its kind; compares the pictures of both
HASHES := tmp/image-hashes.txt
BUILD_TESTS := --lib --test bit_identity --test exact --test reader --test stability
test:
	rm -f target/$(HASHES) target/baseline/$(HASHES)
	cargo test --target-dir target
	RUSTFLAGS="-C target-cpu=generic" cargo test --target-dir target/baseline $(BUILD_TESTS)
	cmp target/$(HASHES) target/baseline/$(HASHES)

## checked   every test with optimisation, overflow checks and debug assertions at once
checked:
	CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS=true CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS=true \
	    cargo test --release --target-dir target/checked

## fuzz    any bytes as a scene, any floats as a picture: a minute each, or: make fuzz SECONDS=600
# New inputs go to target/fuzz, failing ones to tests/fuzz/artifacts.
SECONDS := 60
FUZZ := RUSTFLAGS="-C target-cpu=native" cargo fuzz run --fuzz-dir tests/fuzz \
    --target-dir target/fuzz-build --sanitizer none
fuzz:
	@cargo fuzz --version || { echo "cargo-fuzz is missing: it is installed now" && cargo install cargo-fuzz --locked; }
	mkdir -p target/fuzz/reader target/fuzz/renderer
	$(FUZZ) reader target/fuzz/reader tests/fuzz/corpus/reader scenes -- \
	    -dict=tests/fuzz/words.dict -max_len=1000 -max_total_time=$(SECONDS)
	$(FUZZ) renderer target/fuzz/renderer tests/fuzz/corpus/renderer -- \
	    -max_len=400 -max_total_time=$(SECONDS)
	@echo "make fuzz: nothing found"

## mutants   the code changed in one place at a time: which changes no test notices; days, or: make mutants FILES=src/exact/boxes.rs
# Of all, a share: MUTANTS="--shard 0/50 --sharding round-robin". Results go to target/mutants.out.
FILES := src/camera.rs src/exact/** src/ppm/** src/reference.rs src/render.rs src/scene.rs src/scene/**
mutants:
	@cargo mutants --version || { echo "cargo-mutants is missing: it is installed now" && cargo install cargo-mutants --locked; }
	@mkdir -p target
	CARGO_PROFILE_DEV_DEBUG=0 cargo mutants --output target --jobs 1 $(FILES:%=--file '%') $(MUTANTS)

## sanitize   the address sanitizer: tests of the library, of bit identity, of the program and of hostile scenes
# It needs a flag that stable compilers take in this way only.
sanitize:
	RUSTC_BOOTSTRAP=1 RUSTFLAGS="-Zsanitizer=address -C target-cpu=native" \
	    cargo test --target x86_64-unknown-linux-gnu --target-dir target/address \
	    --lib --test bit_identity --test cli --test hostile

## sanitize-threads   the thread sanitizer: tests of bit identity, and of the library where it has threads
# The standard library is built for it from its sources. Code of these modules runs on the
# thread that calls it, and their tests are much arithmetic; full HD takes too long.
ONE_THREAD := camera nearness reference scene::number \
    $(addprefix exact::,bounds boxes coverage decide depths outline packet paint radical sight)
sanitize-threads:
	rustup component add rust-src
	RUSTC_BOOTSTRAP=1 RUSTFLAGS="-Zsanitizer=thread -C target-cpu=native" \
	    cargo test -Zbuild-std --target x86_64-unknown-linux-gnu --target-dir target/thread \
	    --no-default-features --lib --test bit_identity -- \
	    --skip full_hd $(ONE_THREAD:%=--skip %::)

## proof   error bounds checked by Gappa, Debian's package gappa; scripts to target/proof, written from the formulas that run
# Those in target/proof/refused claim half of a bound. A warning means a step that was
# given to Gappa and that it could not check.
proof:
	@gappa --version || { echo "gappa is missing: apt-get install gappa"; exit 1; }
	rm -rf target/proof
	cargo test --lib -- --ignored bounds::gappa::write_the_scripts
	@for script in target/proof/*.g; do \
	    { gappa $$script 2>&1 || echo refused; } | grep -v "renaming identifier" > target/proof/output; \
	    ! test -s target/proof/output || { echo "$$script:"; cat target/proof/output; exit 1; }; \
	done
	@for script in target/proof/refused/*.g; do \
	    ! gappa $$script > target/proof/output 2>&1 || { echo "$$script is half of a bound and was accepted"; exit 1; }; \
	done
	@echo "make proof: $$(ls target/proof/*.g | wc -l) bounds proven, $$(ls target/proof/refused/*.g | wc -l) halves refused"

## deny    licences, sources, duplicates and known faults of everything sfera depends on
deny:
	@cargo deny --version || { echo "cargo-deny is missing: it is installed now" && cargo install cargo-deny --locked; }
	cargo deny check bans licenses sources
	@if cargo deny fetch db; then cargo deny check --disable-fetch advisories; \
	else echo "make deny: the database of advisories can't be reached, so advisories are NOT checked"; fi

## bench   criterion benches; every one checks its answers first
bench:
	cargo bench --bench methods --bench engine

## chart   the charts of the README, measured again; for scenes of your own: make chart SCENES="my.txt"
chart: splat
	cargo bench --bench chart -- $(or $(SCENES),all)

## growth  the chart of growth alone; its figures of Embree are those of the last `make peers`
growth:
	cargo bench --bench chart -- growth

## families   every family of hard scenes as files, to target/families
families:
	cargo bench --bench families -- target/families

## peers   sfera and other renderers on the same scenes; writes the table benches/peers/results.md
peers:
	python3 benches/peers/run.py $(PEERS)

## peers-install   the peers of `make peers`, from Debian's packages
peers-install:
	apt-get install -y gcc g++ libembree-dev libtbb-dev tachyon povray python3-venv libegl1 libgl1-mesa-dri
	python3 -m venv target/peers/python
	target/peers/python/bin/pip install vtk numpy

## splat   the fastest inexact rasteriser, in C, for 8 lanes and for 16, to target/peers; skipped where it can't be built
SPLAT := gcc -O3 -ffast-math -fno-finite-math-only -pthread
splat:
	@mkdir -p target/peers && rm -f target/peers/splat-8 target/peers/splat-16
	@! grep -qsw avx2 /proc/cpuinfo || $(SPLAT) -mavx2 -mfma -mbmi -mbmi2 -mpopcnt \
	    -o target/peers/splat-8 benches/peers/splat.c -lm || echo "skipped: splat with 8 lanes"
	@! grep -qsw avx512vbmi /proc/cpuinfo || $(SPLAT) -march=native \
	    -o target/peers/splat-16 benches/peers/splat.c -lm || echo "skipped: splat with 16 lanes"

## cluster-test   the recipes of tests/cluster on a Slurm of two nodes on this machine, for root on Debian; three minutes
cluster-test: build
	SFERA=target/release/sfera tests/cluster/run.sh

## everywhere   other machines and systems, emulated or only checked, for root on Debian; 8 GB, hours
everywhere:
	tests/everywhere/run.sh

## check   format, lints, docs, and that the public interface is what tests/api.txt lists
check: api
	cargo fmt --check
	cargo clippy --all-targets -- -D warnings
	@diff tests/api.txt target/api.txt || { echo "make check: the public interface has changed; if it should, cp target/api.txt tests/api.txt"; exit 1; }

## api     the public interface of the library, listed from its documentation, to target/api.txt
# Pages of what was removed would stay.
api:
	cargo clean --doc
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps
	python3 tests/api.py target/doc/sfera > target/api.txt
