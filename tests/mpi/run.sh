#!/usr/bin/env bash
# Renders with several ranks under a real mpirun and compares everything that a render leaves, to the bit.
#
#   tests/mpi/run.sh [BINARY]
#
# BINARY is a lodestar with the feature `mpi`. Without it, this script builds one. `./setup.sh --mpi` installs what it needs: where
# mpirun is absent, the script is skipped with a sentence.
#
# Checkpoints hold the film and the guide, and a hash of each. The script compares these hashes:
#   - of 1 to 4 ranks, over 21 configurations. LODESTAR_FULL=1 takes all numbers of ranks, else each configuration takes one;
#   - of renders in which a rank is killed at a random moment, and that another number of ranks resumes: 20 times with
#     LODESTAR_FULL=1, else never. SEED (1) chooses the moments;
#   - of renders that a signal or --time has ended, and that another number of ranks resumes.
# Where Slurm's daemons are installed, `srun` starts two ranks, too.
# It also plants faults. A rank's sums are lost, or added twice: the hashes must differ. A rank has another scene, or loses its device:
# one sentence must name the rank.
set -euo pipefail
export LC_ALL=C OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
command -v mpirun >/dev/null || { echo "MPI: skipped, because there is no program mpirun"; exit 0; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ $# -ge 1 ]; then
  lodestar=$(realpath "$1")
else
  (cd "$root" && cargo build --release --quiet --features mpi)
  cp "$root/target/release/lodestar" "$work/lodestar"
  lodestar=$work/lodestar
fi
scene=$root/scenes/cornell-box/scene.xml
RANDOM=${SEED:-1}

# Ranks that start together. One rank is a plain process. A launcher waits 5 seconds for ranks that it ends.
ranks() { # COUNT COMMAND...
  local count=$1
  shift
  if [ "$count" = 1 ]; then
    "$@"
  else
    mpirun --oversubscribe --mca odls_base_sigkill_timeout 5 -n "$count" "$@"
  fi
}

# Number of samples and hashes of all parts of a checkpoint.
left() { # CHECKPOINT
  python3 - "$1" <<'READ'
import json, struct, sys

data = open(sys.argv[1], "rb").read()
header = json.loads(data[32:32 + struct.unpack("<Q", data[8:16])[0]])
print(header["samples_done"], *(f"{part['name']}={part['hash']}" for part in header["parts"]))
READ
}

fail() { echo "$*" >&2; exit 1; }

# What a whole render leaves.
render() { # RANKS OPTION...
  local count=$1
  shift
  rm -f "$work/whole.ckpt"
  ranks "$count" "$lodestar" render "$scene" --width 36 --height 28 --quiet --checkpoint "$work/whole.ckpt" -o "$work/whole.exr" "$@" \
    >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; fail "$count ranks, $*: the render failed"; }
  left "$work/whole.ckpt"
}

configurations() {
  cat <<'END'
--sampler bsdf
--sampler bsdf --nee off
--sampler rejection-mix
--sampler rejection-mix --nee off
--sampler rejection-mix --mix acceptance --nee off
--sampler rejection --nee off
--sampler sphere-inversion
--sampler hemisphere-inversion
--sampler product
--sampler product --nee off --execution wavefront
--sampler product --execution megakernel
--sampler quadtree
--sampler quadtree --nee off
--learner expected-sarsa
--learner monte-carlo
--noise 0.2 --spp 48
--sample-offset 64
--grid auto --fallback 4
--steps even --spp-per-step 4 --samples-per-dispatch 2
--deal-by-speed
END
}

count=0
while IFS= read -r line; do
  read -ra options <<<"--spp 20 $line"
  if [[ $line == *--spp\ * ]]; then read -ra options <<<"$line"; fi
  one=$(render 1 "${options[@]}")
  numbers=$((2 + count % 3))
  if [ "${LODESTAR_FULL:-}" = 1 ]; then numbers="2 3 4"; fi
  for number in $numbers; do
    [ "$(render "$number" "${options[@]}")" = "$one" ] || fail "$line: $number ranks differ from one"
  done
  count=$((count + 1))
done < <(configurations)
echo "$count configurations: any number of ranks leaves what one rank leaves"

# A launcher with one rank, and devices in one rank beside another rank.
expected=$(render 1 --spp 20)
rm -f "$work/whole.ckpt"
mpirun -n 1 "$lodestar" render "$scene" --width 36 --height 28 --quiet --spp 20 --checkpoint "$work/whole.ckpt" -o "$work/whole.exr"
[ "$(left "$work/whole.ckpt")" = "$expected" ] || fail "one rank under mpirun differs"
[ "$(render 2 --spp 20 --device 0,0)" = "$expected" ] || fail "two ranks of two devices differ"
echo "one rank under mpirun, and two ranks of two devices: the same"

# A guide that another render has learned reaches all ranks.
"$lodestar" render "$scene" --width 36 --height 28 --quiet --spp 16 --seed 1 --checkpoint "$work/guide.ckpt" -o "$work/guide.exr"
[ "$(render 3 --spp 12 --guide "$work/guide.ckpt")" = "$(render 1 --spp 12 --guide "$work/guide.ckpt")" ] ||
  fail "three ranks that begin with a guide differ from one"
echo "three ranks that begin with a guide of another render: the same"

# srun hands the ranks what they need to know of each other in the form that Open MPI reads.
srun_ranks() {
  srun --mpi=pmix --ntasks=2 --overcommit "$lodestar" render "$scene" --width 36 --height 28 --quiet --spp 20 --checkpoint "$work/srun.ckpt" \
    -o "$work/srun.exr" </dev/null
}
export -f srun_ranks
export lodestar scene work
if "$root/tests/farm/slurm.sh" bash -euo pipefail -c srun_ranks >"$work/log" 2>&1; then
  [ "$(left "$work/srun.ckpt")" = "$expected" ] || fail "two ranks that srun has started differ"
  echo "srun with two ranks: the same"
elif [ $? = 77 ]; then
  echo "srun: skipped, because $(cat "$work/log")"
else
  cat "$work/log" >&2
  fail "srun with two ranks failed"
fi

for fault in lose@1 double@1 lose@0; do
  found=$(LODESTAR_EXCHANGE=$fault render 2 --spp 20)
  [ "$found" != "$expected" ] || fail "planted fault $fault: nothing differs"
done
echo "planted faults: sums that are lost or added twice are found"

# Long renders, whose checkpoint is written after every step.
long=(--width 36 --height 28 --quiet --spp 500 --spp-per-step 16 --checkpoint-every 0.001 -o "$work/long.exr")
begin() { # RANKS OPTION...
  local count=$1
  shift
  rm -f "$work/long.ckpt"
  ranks "$count" "$lodestar" render "$scene" "${long[@]}" --checkpoint "$work/long.ckpt" "$@" >"$work/log" 2>&1 </dev/null
}
whole() { # RANKS: goes on to the end, and prints what is left
  if [ -e "$work/long.ckpt" ]; then
    ranks "$1" "$lodestar" resume "$work/long.ckpt" --spp 500 --quiet >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; fail "resume failed"; }
  else
    begin "$1" || { cat "$work/log" >&2; fail "the render failed"; }
  fi
  left "$work/long.ckpt"
}

begin 1
expected=$(left "$work/long.ckpt")

begin 3 --time 1 || { cat "$work/log" >&2; fail "--time failed"; }
[ "$(whole 2)" = "$expected" ] || fail "a render that --time has ended differs after it is resumed"
echo "--time with 3 ranks, then 2 ranks: the same"

rm -f "$work/long.ckpt"
begin 3 &
launcher=$!
while [ ! -e "$work/long.ckpt" ]; do sleep 0.2; done
pkill -INT -P "$launcher" mpirun || true
wait "$launcher" || true
[ -e "$work/long.exr" ] || fail "a render that a signal has ended leaves no picture"
[ "$(whole 1)" = "$expected" ] || fail "a render that a signal has ended differs after it is resumed"
echo "a signal to mpirun with 3 ranks, then a plain process: the same"

kills=0 killed=0 resumed=0 named=0 tries=0
if [ "${LODESTAR_FULL:-}" = 1 ]; then kills=20; fi
while [ "$killed" -lt "$kills" ] && [ "$tries" -lt $((3 * kills)) ]; do
  tries=$((tries + 1))
  before=$((2 + RANDOM % 3)) after=$((1 + RANDOM % 4)) rank=$((RANDOM % before))
  # The last render's checkpoint must be gone before this one is looked for.
  rm -f "$work/long.ckpt"
  begin "$before" &
  launcher=$!
  # A quarter of the moments may come before the first step, the others after a checkpoint.
  while [ $((tries % 4)) != 0 ] && [ ! -e "$work/long.ckpt" ] && kill -0 "$launcher" 2>/dev/null; do sleep 0.1; done
  sleep "$((RANDOM % 2)).$((RANDOM % 10))"
  mapfile -t processes < <(pgrep -P "$(pgrep -P "$launcher" mpirun || echo 1)" -x "$(basename "$lodestar" | cut -c-15)" || true)
  if [ "${#processes[@]}" -le "$rank" ] || ! kill -KILL "${processes[$rank]}" 2>/dev/null; then
    wait "$launcher" || true
    continue
  fi
  if wait "$launcher"; then fail "a rank was killed, but mpirun reports success"; fi
  killed=$((killed + 1))
  # The first rank names the others where it can still speak: it was not killed, and had begun. It does not know a rank's machine before the
  # rank has told of itself.
  if grep -q '^lodestar: error: ' "$work/log"; then
    grep -qE '^lodestar: error: rank [0-9]+( on .*)? does not answer any more' "$work/log" || { cat "$work/log" >&2; fail "the lost rank is not named"; }
    named=$((named + 1))
  fi
  if [ -e "$work/long.ckpt" ]; then resumed=$((resumed + 1)); fi
  [ "$(whole "$after")" = "$expected" ] || fail "$before ranks, of which one was killed, then $after ranks: something differs"
done
[ "$killed" -eq "$kills" ] || fail "only $killed ranks could be killed in $tries renders"
[ "$kills" = 0 ] || echo "$killed renders with a killed rank, of which $resumed had a checkpoint to resume and $named named the rank: the same"

# One sentence names the rank that cannot render, or that fails.
small=(--width 36 --height 28 --quiet --spp 400 --spp-per-step 16)
sentence() { # PATTERN: the log has one error of ours, which matches
  grep -qE "$1" "$work/log" && [ "$(grep -c '^lodestar: error: ' "$work/log")" = 1 ] || { cat "$work/log" >&2; fail "no single sentence like: $1"; }
}
if mpirun --oversubscribe -n 1 "$lodestar" render "$scene" "${small[@]}" -o "$work/a.exr" \
  : -n 1 "$lodestar" render "$root/scenes/furnace/scene.xml" "${small[@]}" -o "$work/b.exr" >"$work/log" 2>&1 </dev/null; then
  fail "two ranks with different scenes: nothing is refused"
fi
sentence '^lodestar: error: rank 1 on .* has another scene_hash than rank 0'
if mpirun --oversubscribe -n 1 "$lodestar" render "$scene" "${small[@]}" -o "$work/a.exr" \
  : -n 1 "$lodestar" render "$work/absent.xml" "${small[@]}" -o "$work/b.exr" >"$work/log" 2>&1 </dev/null; then
  fail "a rank without a scene: nothing is refused"
fi
sentence '^lodestar: error: rank 1.*absent.xml'
rm -f "$work/long.ckpt"
if mpirun --oversubscribe -n 1 "$lodestar" render "$scene" "${long[@]}" --checkpoint "$work/long.ckpt" \
  : -n 1 env LODESTAR_FAULT=lost@400 "$lodestar" render "$scene" "${long[@]}" --checkpoint "$work/long.ckpt" >"$work/log" 2>&1 </dev/null; then
  fail "a rank has lost its device: nothing is reported"
fi
sentence '^lodestar: error: rank 1 on .*the device was lost.*the last good step is number'
[ "$(whole 3)" = "$expected" ] || fail "a render whose rank has lost its device differs after it is resumed"
echo "ranks that cannot render or that fail are named in one sentence, and the render can be resumed"
