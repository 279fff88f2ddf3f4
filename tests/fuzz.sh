#!/usr/bin/env bash
# Fuzzes the targets of fuzz/ with coverage guidance (libFuzzer), on the stable compiler.
#
#   tests/fuzz.sh [TARGET...]     all targets by default
#
# Each runs for LODESTAR_FUZZ_SECONDS (600). What is found is kept in fuzz/artifacts, and inputs with new coverage go to
# target/fuzz-corpus. Where the fuzzer cannot be built, it is skipped with a sentence.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

targets=("$@")
if ((${#targets[@]} == 0)); then
  for file in fuzz/fuzz_targets/*.rs; do targets+=("$(basename "$file" .rs)"); done
fi
host=$(rustc -vV | sed -n 's/^host: //p')
# The flags of cargo-fuzz, without a sanitizer: the code is safe Rust, and a panic ends the fuzzer.
flags=(--cfg fuzzing -Ccodegen-units=1 -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4
  -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table
  -Cllvm-args=-sanitizer-coverage-trace-compares)
export CARGO_TARGET_DIR=$PWD/target/fuzz
if ! command -v c++ >/dev/null || ! cargo fetch --quiet --manifest-path fuzz/Cargo.toml; then
  echo "skipped: the fuzzer cannot be built here; it needs a C++ compiler, and the crate libfuzzer-sys"
  exit 0
fi
# With --target, build scripts are built without these flags.
RUSTFLAGS="${flags[*]}" cargo build --release --quiet --manifest-path fuzz/Cargo.toml --target "$host"
mkdir -p fuzz/artifacts
# A program of Rust ignores SIGPIPE, as a server must. libFuzzer's own main does not.
trap '' PIPE
for target in "${targets[@]}"; do
  corpus=target/fuzz-corpus/$target dictionary=() seeds=()
  mkdir -p "$corpus"
  [[ ! -d fuzz/corpus/$target ]] || seeds=("fuzz/corpus/$target")
  [[ ! -f fuzz/$target.dict ]] || dictionary=(-dict="fuzz/$target.dict")
  echo "fuzzing $target for ${LODESTAR_FUZZ_SECONDS:-600} s"
  "$CARGO_TARGET_DIR/$host/release/$target" "$corpus" "${seeds[@]}" "${dictionary[@]}" \
    -max_total_time="${LODESTAR_FUZZ_SECONDS:-600}" -timeout=20 -rss_limit_mb=2048 -max_len=65536 -artifact_prefix="fuzz/artifacts/$target-" -print_final_stats=1 2>&1 | tail -25
done
