#!/usr/bin/env bash
# Counts the instructions of the kernels of several builds of lodestar on lavapipe. The count does not depend on what else the
# machine does, so it tells differences of a percent where seconds do not. It says nothing of waiting for memory.
#
#   benches/instructions.sh SCENE.xml BINARY... [-- OPTION...]
#
# It renders SCENE with 1 and with 65 samples per pixel, and prints the difference in millions of instructions, with the ratio
# to the first binary. Options after `--` go to `lodestar render`. WIDTH and HEIGHT change the size (48 x 48).
# It needs bash, the usual tools and valgrind. A binary takes about a minute.
set -euo pipefail
export LC_ALL=C

[ $# -ge 2 ] || { sed -n '5p' "$0" | sed 's/^# *//' >&2; exit 2; }
scene=$1 width=${WIDTH:-48} height=${HEIGHT:-48}
shift
binaries=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do binaries+=("$1"); shift; done
[ $# -eq 0 ] || shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Prints the instructions of one render. The driver's cache has the kernels already.
instructions() { # BINARY SAMPLES OPTION...
  local binary=$1 samples=$2
  shift 2
  rm -f "$work/picture.exr"
  valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null --smc-check=all-non-file \
    "$binary" render "$scene" --width "$width" --height "$height" --spp "$samples" "$@" --quiet \
    -o "$work/picture.exr" >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; return 1; }
  sed -n 's/.*I *refs: *//p' "$work/log" | tr -d ,
}

first=
for binary in "${binaries[@]}"; do
  instructions "$binary" 1 "$@" >"$work/warm"
  one=$(instructions "$binary" 1 "$@")
  many=$(instructions "$binary" 65 "$@")
  : "${first:=$((many - one))}"
  awk -v name="$binary" -v count=$((many - one)) -v first="$first" \
    'BEGIN { printf "%10.0f M  %.3f  %s\n", count / 1e6, count / first, name }'
done
