#!/usr/bin/env bash
# Runs parts of the long tier of the tests: what takes too long for every change.
#
# usage: tests/long.sh PART...   run these parts
#        tests/long.sh today     run the part of this day (UTC), as CI does
#        tests/long.sh all       run all parts of the list
#        tests/long.sh list      print the parts and their next days
#
# The parts `references` and `features` stand for all parts of their kind. The part `ranks` installs MPI and runs tests/mpi/run.sh in
# full, and `random-scenes` installs Mitsuba; the list, `all` and `today` leave both out.
#
# Days take the parts in turn, so all of them come round in as many days as there are parts.
#
# The parts `references-*` need LODESTAR_SCENES and LODESTAR_REFERENCES (see tests/references/main.rs).
set -euo pipefail
cd "$(dirname "$0")/.."
export LODESTAR_FULL=1

# Parts in the order of their days. Parts of one kind do not follow each other, so that a week has many kinds.
PARTS=(references-1 features-1 render-1 features-2 samplers kills features-3 python
  features-4 render-2 claims features-5 agreement unoptimized features-6 faults
  features-7 references-2 pictures features-8 render-3 closed features-9 shaderc
  forged features-10 torture page features-11 fuzz features-12)

# Modules of tests/render in two parts. The third part has all others.
RENDER_1=(analytic:: blue_noise:: cells:: choices:: determinism:: differences::)
RENDER_2=(drivers:: execution:: guide_set:: learning:: nee::)
# Modules that are parts of their own.
AGREEMENT=ztest:: CLOSED=closed::

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

# Renders random scenes with this build and with Mitsuba, in a Python of its own. LODESTAR_SCENE_SEED (1) chooses others.
test_random_scenes() {
  local venv=target/mitsuba-venv
  cargo build --release --quiet
  [ -x $venv/bin/mitsuba ] || { python3 -m venv $venv && $venv/bin/pip install --quiet 'mitsuba==3.9.*' numpy; }
  # The twin shows that a light of 5 % more is found.
  $venv/bin/python tests/random_scenes/run.py target/release/lodestar --count 3 --twin
  $venv/bin/python tests/random_scenes/run.py target/release/lodestar --count 100 --seed "${LODESTAR_SCENE_SEED:-1}"
}

# Runs the tests of tests/render whose names contain none of the words.
render_without() { # WORD...
  local skips=()
  for word in "$@"; do skips+=(--skip "$word"); done
  suite render -- "${skips[@]}"
}

# Runs one of several shares of a suite's cases.
share() { # K N SUITE
  LODESTAR_PART=$1/$2 suite "$3"
}

run() { # PART
  case "$1" in
    references) suite references ;;
    references-[12]) share "${1#*-}" 2 references ;;
    # Small scenes in four ways each. The tables of deviations are written to target/.
    features) LODESTAR_FEATURES_TABLE="$PWD/target/features.md" suite features ;;
    features-[1-9] | features-1[0-2]) LODESTAR_FEATURES_TABLE="$PWD/target/$1.md" share "${1#*-}" 12 features ;;
    render-1) suite render -- "${RENDER_1[@]}" ;;
    render-2) suite render -- "${RENDER_2[@]}" ;;
    render-3) render_without "${RENDER_1[@]}" "${RENDER_2[@]}" "$AGREEMENT" "$CLOSED" ;;
    # Guided pictures beside unguided ones, by z-tests.
    agreement) suite render -- "$AGREEMENT" ;;
    # 10^8 rays that no closed mesh lets out.
    closed) suite render -- "$CLOSED" ;;
    samplers) suite samplers && suite gpu ;;
    # What the guides' functions compute and draw.
    claims) suite proofs -- claims --skip claims::pictures --skip claims::targets --skip claims::furnace ;;
    # What whole renders learn and show, and changes that must not matter.
    pictures)
      suite proofs -- claims::pictures claims::targets claims::furnace tampering::no_harmless_change
      LODESTAR_SAMPLES=1e7 suite proofs -- --nocapture billion
      ;;
    # 200 kills.
    kills) suite cli -- kills ;;
    # 120 device faults.
    faults) suite cli -- faults ;;
    # Every operation on files fails or is the last one.
    torture) suite cli -- torture ;;
    # Checkpoints of strangers.
    forged) suite cli -- forged ;;
    # Ten minutes of each target of fuzz/.
    fuzz) tests/fuzz.sh ;;
    # 100 random scenes beside Mitsuba. It needs Mitsuba, so `all` and the days leave it out.
    random-scenes) test_random_scenes ;;
    # 300,000 requests of strangers to the page's server.
    page) suite view -- hostile && suite page_memory ;;
    # A build without optimization.
    unoptimized) test_unoptimized ;;
    # A build with another shaderc.
    shaderc) test_shaderc_from_source ;;
    # Processes that render one picture, 20 of them killed. It needs MPI, so `all` and the days leave it out.
    ranks) ./setup.sh --mpi && tests/mpi/run.sh ;;
    # The wheel, installed away from the repository.
    python) python/test.sh ;;
    *) echo "tests/long.sh: no part \`$1\`; the parts are: ${PARTS[*]}" >&2; exit 2 ;;
  esac
}

# Number of the day since 1970 (UTC).
day=$(($(date -u +%s) / 86400))

case "${1:-}" in
  "") sed -n 's/^# \{0,1\}//; 3,12p' "$0" >&2; exit 2 ;;
  list)
    for at in "${!PARTS[@]}"; do
      part=${PARTS[$(((day + at) % ${#PARTS[@]}))]}
      printf '%-15s%s\n' "$part" "$(date -u -d "@$(((day + at) * 86400))" +%F)"
    done
    exit
    ;;
  all) set -- "${PARTS[@]}" ;;
  today) set -- "${PARTS[$((day % ${#PARTS[@]}))]}" ;;
esac

for part in "$@"; do
  start=$SECONDS
  echo "=== long: $part"
  run "$part"
  echo "=== long: $part: $((SECONDS - start)) s"
done
