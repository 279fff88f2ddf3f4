#!/usr/bin/env bash
# Builds a fuzz target with counters of coverage and runs it. It needs no nightly Rust and no cargo-fuzz.
#
#   fuzz/run.sh TARGET [SECONDS] [OPTION...]    http; 600 seconds; options of libFuzzer
#
# New inputs go to fuzz/corpus/TARGET, which git ignores. An input that fails is written to the current folder, and
# `fuzz/run.sh TARGET 0 FILE` tries it again.
set -euo pipefail
cd "$(dirname "$0")"
target=${1:?usage: fuzz/run.sh TARGET [SECONDS] [OPTION...]} seconds=${2:-600}
shift $(($# < 2 ? $# : 2))

# The flags of cargo-fuzz without the address sanitizer, which needs nightly Rust. Safe Rust checks its bounds itself.
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
 -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing"
# The versions of the dependencies are those of the program.
cp ../Cargo.lock Cargo.lock
host=$(rustc -vV | sed -n 's/^host: //p')
cargo build --release --target "$host" --bin "$target"
mkdir -p "corpus/$target"
program=target/$host/release/$target
[ "$seconds" != 0 ] || exec "$program" "$@"
exec "$program" -max_total_time="$seconds" -max_len=4096 -timeout=70 "$@" "corpus/$target" "seeds/$target"
