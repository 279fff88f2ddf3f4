#!/usr/bin/env bash
# Runs parts of the long tier of the tests: what takes too long for every change.
#
# usage: tests/long.sh PART...   run these parts
#        tests/long.sh today     run the parts of this day of the week (UTC), as CI does
#        tests/long.sh all       run all parts
#        tests/long.sh list      print the parts and their days
#
# The part `references` needs LODESTAR_SCENES and LODESTAR_REFERENCES (see tests/references/main.rs).
set -euo pipefail
cd "$(dirname "$0")/.."
export LODESTAR_FULL=1

# Parts, and the day of the week of each.
PARTS=(references render samplers claims pictures interruptions builds features python agreement)
DAYS=(Monday Tuesday Wednesday Thursday Friday Saturday Sunday Monday Sunday Saturday)

suite() { cargo test --release --test "$@"; }

# Tests the project's own code without optimization, with debug assertions and overflow checks. Dependencies stay
# optimized. The pictures must have the bits of an optimized build.
test_unoptimized() {
  local own=profile.release.package.lodestar-render
  suite render every_profile
  suite render --config "$own.opt-level=0" --config "$own.debug-assertions=true" \
    --config "$own.overflow-checks=true" every_profile
  # This build leaves an optimized program in target/.
  cargo build --release --quiet
}

# Builds a clone that compiles shaderc from source, as where the distribution has no shaderc that links. Its pictures must
# have the bits of this build.
test_shaderc_from_source() {
  local clone=target/shaderc-from-source
  ./setup.sh --source-tools
  rm -rf "$clone/source"
  git clone --quiet . "$clone/source"
  cargo build --release --quiet
  # The clone has no folder .shaderc, so shaderc's crate finds no library.
  (cd "$clone/source" && CARGO_TARGET_DIR=../target cargo build --release --quiet --bin lodestar)
  tests/same_bits.sh target/release/lodestar "$clone/target/release/lodestar"
}

run() { # PART
  case "$1" in
    references) suite references ;;
    # Small scenes in four ways each. The table of deviations is written to target/features.md.
    features) LODESTAR_FEATURES_TABLE="$PWD/target/features.md" suite features ;;
    render) suite render -- --skip ztest --skip closed ;;
    # Guided pictures beside unguided ones, by z-tests, and 10^8 rays that no closed mesh lets out.
    agreement) suite render -- ztest closed ;;
    samplers) suite samplers && suite gpu ;;
    # What the guides' functions compute and draw.
    claims) suite proofs -- claims --skip claims::pictures --skip claims::targets --skip claims::furnace ;;
    # What whole renders learn and show, and changes that must not matter.
    pictures)
      suite proofs -- claims::pictures claims::targets claims::furnace tampering::no_harmless_change
      LODESTAR_SAMPLES=1e7 suite proofs -- --nocapture billion
      ;;
    # 200 kills and 120 device faults.
    interruptions) suite cli -- kills faults ;;
    # An unoptimized build, and a build with another shaderc.
    builds) test_unoptimized && test_shaderc_from_source ;;
    # The wheel, installed away from the repository.
    python) python/test.sh ;;
    *) echo "tests/long.sh: no part \`$1\`; the parts are: ${PARTS[*]}" >&2; exit 2 ;;
  esac
}

case "${1:-}" in
  "") sed -n 's/^# \{0,1\}//; 3,7p' "$0" >&2; exit 2 ;;
  list)
    for at in "${!PARTS[@]}"; do printf '%-15s%s\n' "${PARTS[at]}" "${DAYS[at]}"; done
    exit
    ;;
  all) set -- "${PARTS[@]}" ;;
  today)
    set --
    for at in "${!PARTS[@]}"; do
      [ "${DAYS[at]}" != "$(LC_ALL=C date -u +%A)" ] || set -- "$@" "${PARTS[at]}"
    done
    ;;
esac

for part in "$@"; do
  start=$SECONDS
  echo "=== long: $part"
  run "$part"
  echo "=== long: $part: $((SECONDS - start)) s"
done
