#!/usr/bin/env bash
# Measures what it costs that several ranks share a picture over MPI, compares it with the cost model of docs/many-devices.md, and
# prints what the model predicts for machines that are not here.
#
#   benches/ranks_mpi.sh BINARY SCENE.xml [OPTION...]
#   benches/ranks_mpi.sh --predict                     only the predictions, for the guide of a default grid
#
# BINARY has the feature `mpi`. Renders with 1, 2 and 4 ranks of one thread each (LP_NUM_THREADS=1) take turns, for ROUNDS (3) rounds
# after a first one that is not counted. Each exchange of sums takes DELAYS (0 2000 20000) microseconds longer, as on a slow network
# (LODESTAR_EXCHANGE=delay@N, which src/fleet/trial.rs reads). The first table has medians over the rounds:
#   - seconds of rendering, and those that the model says: the seconds without a delay, and the delay of every exchange;
#   - seconds of one exchange, of gathering the film, and of the first rank's waiting for the others.
# SPP (64), WIDTH (256), HEIGHT (144) change the renders. It needs bash, python3, mpirun, and as many idle cores as ranks: where there
# are fewer, ranks wait for each other's turns on a core.
set -euo pipefail
export LC_ALL=C OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

predict() { # BYTES: of one exchange
  python3 - "$1" <<'TABLE'
import math, sys

size = int(sys.argv[1])
# Seconds of one message, bytes per second of the network, bytes per second between a device and its host.
machines = [
    ("8 GPUs in one machine", 8, 2e-6, 10e9, 10e9),
    ("64 nodes, 100 Gbit/s", 64, 5e-6, 12.5e9, 10e9),
    ("64 nodes, 10 Gbit/s", 64, 30e-6, 1.25e9, 10e9),
]
# A step has two meetings with two messages for each of them, and one addition: each rank hands on nearly all bytes twice.
def exchange(ranks, latency, network, bus):
    meetings = 2 * 2 * (latency + ranks * 1e-6)
    addition = 2 * math.log2(ranks) * latency + 2 * (ranks - 1) / ranks * size / network
    return meetings + addition + 2 * size / bus

print(f"predicted, for {size / 2**20:.2f} MiB in an exchange:")
print("| ranks | one exchange | efficiency with steps of 0.1 s on all ranks | of 1 s | step for an efficiency of 0.9 |")
print("|---|---|---|---|---|")
for name, ranks, latency, network, bus in machines:
    cost = exchange(ranks, latency, network, bus)
    efficiency = [step / (step + cost) for step in (0.1, 1.0)]
    print(f"| {name} | {1000 * cost:.1f} ms | {efficiency[0]:.2f} | {efficiency[1]:.3f} | {1000 * 9 * cost:.0f} ms |")
TABLE
}

if [ "${1:-}" = --predict ]; then
  # 12 bytes for each bin, and a bit for each normalizer.
  predict "${BYTES:-4194304}"
  exit 0
fi
[ $# -ge 2 ] || { sed -n '5,6p' "$0" | sed 's/^# *//' >&2; exit 2; }
binary=$1 scene=$2
shift 2
rounds=${ROUNDS:-3} delays=${DELAYS:-0 2000 20000}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for ((round = 0; round <= rounds; ++round)); do
  for ranks in 1 2 4; do
    for delay in $delays; do
      # One rank exchanges nothing.
      if [ "$ranks" = 1 ] && [ "$delay" != "${delays%% *}" ]; then continue; fi
      LP_NUM_THREADS=1 LODESTAR_EXCHANGE=delay@$delay mpirun --oversubscribe -n "$ranks" "$binary" render "$scene" --spp "${SPP:-64}" \
        --width "${WIDTH:-256}" --height "${HEIGHT:-144}" "$@" --quiet --stats "$work/$round.$ranks.$delay" -o "$work/picture.exr" \
        >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; exit 1; }
    done
  done
done
python3 - "$work" "$rounds" "$delays" >"$work/table" <<'TABLE'
import json, os, statistics, sys

work, rounds, delays = sys.argv[1], int(sys.argv[2]), [int(delay) for delay in sys.argv[3].split()]
print("| ranks | delay of an exchange | seconds | by the model | one exchange | waiting for others | gathering |")
print("|---|---|---|---|---|---|---|")
for ranks in (1, 2, 4):
    without = None
    for delay in delays:
        names = [f"{work}/{round}.{ranks}.{delay}" for round in range(1, rounds + 1)]
        if not os.path.exists(names[0]):
            continue
        totals = [json.load(open(name))["totals"] for name in names]
        median = lambda value: statistics.median([value(total) for total in totals])
        seconds = median(lambda total: total["seconds"])
        if ranks == 1:
            print(f"| 1 | | {seconds:.2f} s | | | | |")
            continue
        sharing = lambda name: median(lambda total: total["sharing"][name])
        exchanges = sharing("exchanges")
        without = seconds - exchanges * delay * 1e-6 if without is None else without
        model = without + exchanges * delay * 1e-6
        print(f"| {ranks} | {delay / 1000:g} ms | {seconds:.2f} s | {model:.2f} s | {1000 * sharing('exchange_seconds') / exchanges:.1f} ms |"
              f" {sharing('waiting_seconds'):.2f} s | {1000 * sharing('gather_seconds'):.0f} ms |")
        size, steps = int(sharing("exchange_bytes")), int(exchanges)
print(f"{steps} exchanges of {size / 2**20:.2f} MiB")
print(size)
TABLE
sed '$d' "$work/table"
echo
predict "$(tail -n 1 "$work/table")"
