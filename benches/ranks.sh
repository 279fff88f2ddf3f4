#!/usr/bin/env bash
# Measures what it costs that two devices share a picture.
#
#   benches/ranks.sh BINARY SCENE.xml [OPTION...]
#
# Two logical devices of Mesa's driver for CPUs have one thread each (LP_NUM_THREADS=1, --device D,D). One device has two threads. Both
# render the same picture, by turns, for ROUNDS (5) rounds after a first one that is not counted. The table has medians over the rounds:
#   - seconds of rendering of both, and the efficiency: the median, least and greatest ratio of the rounds;
#   - seconds that two devices spend on the exchange of sums and on gathering the film, and their shares of the render.
# With RANKS=mpi, two ranks under mpirun have one thread each, in place of two devices of one process. BINARY then needs the feature `mpi`.
# SPP (32), WIDTH (256), HEIGHT (144) change the renders. DEVICE (0) is the index of the driver in `lodestar devices`.
# It needs two idle cores, bash and python3.
set -euo pipefail
export LC_ALL=C

[ $# -ge 2 ] || { sed -n '4p' "$0" | sed 's/^# *//' >&2; exit 2; }
binary=$1 scene=$2
shift 2
device=${DEVICE:-0} rounds=${ROUNDS:-5}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

launcher=() two=$device,$device
if [ "${RANKS:-}" = mpi ]; then
  launcher=(mpirun --oversubscribe --bind-to none -n 2) two=$device
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi

render() { # STATS THREADS DEVICES OPTION...
  local stats=$1 threads=$2 devices=$3 launch=()
  shift 3
  if [ "$threads" = 1 ]; then launch=("${launcher[@]}"); fi
  LP_NUM_THREADS=$threads ${launch[@]+"${launch[@]}"} "$binary" render "$scene" --device "$devices" --spp "${SPP:-32}" --width "${WIDTH:-256}" --height "${HEIGHT:-144}" \
    "$@" --quiet --stats "$stats" -o "$work/picture.exr" >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; return 1; }
}

for ((round = 0; round <= rounds; ++round)); do
  render "$work/$round.two" 1 "$two" "$@"
  render "$work/$round.one" 2 "$device" "$@"
done
python3 - "$work" "$rounds" <<'TABLE'
import json, statistics, sys

work, rounds = sys.argv[1], int(sys.argv[2])
read = lambda name: [json.load(open(f"{work}/{round}.{name}"))["totals"] for round in range(1, rounds + 1)]
two, one = read("two"), read("one")
median = lambda values: statistics.median(list(values))
print(f"seconds: {median(t['seconds'] for t in two):.3f} with two devices or ranks, {median(t['seconds'] for t in one):.3f} with one")
ratios = [o["seconds"] / t["seconds"] for o, t in zip(one, two)]
print(f"efficiency: {median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})")
for name in ["exchange", "gather"]:
    seconds = [t["sharing"][f"{name}_seconds"] for t in two]
    shares = [s / t["seconds"] for s, t in zip(seconds, two)]
    print(f"{name}: {median(seconds):.4f} s, {100 * median(shares):.2f} % of the render")
TABLE
