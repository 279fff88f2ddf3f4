#!/usr/bin/env bash
# Runs the templates of farm/ on a small scene and compares their pictures with one render of all samples.
#
#   tests/farm/run.sh [BINARY]
#
# BINARY is target/release/lodestar by default. GNU parallel (the package `parallel`) and `openjd` (openjd-cli of PyPI) run for real,
# and so do the commands of Kubernetes' manifests, without Kubernetes. Slurm's job array runs on a real Slurm of one node (slurm.sh), and
# beside it with a stand-in for sbatch. A tool that is absent is skipped with a sentence. The last check plants a fault: a part is left out, and this must be found.
set -euo pipefail
export LC_ALL=C

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
LODESTAR=$(realpath "${1:-$root/target/release/lodestar}")
export LODESTAR SPP=16 OPTIONS="--sampler bsdf --width 40 --height 24"
scene=$root/scenes/cornell-box/scene.xml parts=3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
read -ra options <<<"$OPTIONS"

# Whether two pictures have equal radiance, to the bit.
same() { # A B
  "$LODESTAR" compare --json "$1" "$2" | tr -d ' \n' | grep -qE '"mae":0(\.0)?,'
}

check() { # NAME PICTURE
  same "$2" "$work/whole.exr" || { echo "$1: the picture differs from one render of all samples" >&2; exit 1; }
  echo "$1: the bits of one render"
}

"$LODESTAR" render "$scene" "${options[@]}" --spp $((parts * SPP)) --sample-offset 0 --quiet -o "$work/whole.exr"

for script in "$root"/farm/*.sh; do
  bash -n "$script"
done
echo "bash: all scripts can be read"

if command -v parallel >"$work/log"; then
  mkdir "$work/a folder"
  "$root/farm/parallel.sh" "$scene" "$work/a folder/parallel.exr" "$parts" --jobs 2 >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
  check "GNU parallel" "$work/a folder/parallel.exr"
  # Parts that are complete end at once and stay as they are.
  "$root/farm/parallel.sh" "$scene" "$work/a folder/parallel.exr" "$parts" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
  check "GNU parallel, a second time" "$work/a folder/parallel.exr"
else
  echo "GNU parallel: skipped, because there is no program parallel"
fi

if command -v openjd >"$work/log"; then
  openjd check "$root/farm/openjd.yaml" >"$work/log"
  openjd run "$root/farm/openjd.yaml" --step Merge --run-dependencies -p Farm="$root/farm" -p Scene="$scene" \
    -p Picture="$work/openjd.exr" -p LastPart=$((parts - 1)) -p SamplesPerPart=$SPP -p Options="$OPTIONS" -p Lodestar="$LODESTAR" \
    >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
  check "Open Job Description" "$work/openjd.exr"
else
  echo "Open Job Description: skipped, because there is no program openjd"
fi

# A stand-in for sbatch prints a job's number and runs the command of each task.
mkdir "$work/bin"
cat >"$work/bin/sbatch" <<'STAND_IN'
#!/usr/bin/env bash
set -euo pipefail
tasks=0 jobs=$(dirname "$0")/jobs
for option in "$@"; do
  case $option in
    --array=0-*) tasks=${option#--array=0-} ;;
    --wrap=*) wrapped=${option#--wrap=} ;;
    --dependency=afterok:*) [[ ${option##*:} == 1 ]] ;;
  esac
done
echo >>"$jobs"
for ((task = 0; task <= tasks; task++)); do
  SLURM_ARRAY_TASK_ID=$task sh -c "$wrapped" >>"$jobs.log" 2>&1
done
wc -l <"$jobs"
STAND_IN
chmod +x "$work/bin/sbatch"
PATH="$work/bin:$PATH" "$root/farm/slurm.sh" "$scene" "$work/slurm.exr" "$parts" --gres=gpu:1 >"$work/log" || { cat "$work/bin/jobs.log" >&2; exit 1; }
check "Slurm's commands, without Slurm" "$work/slurm.exr"
# Slurm itself, with one node. The array takes its tasks one after the other where the machine has few processors.
slurm() {
  cd "$work" && "$root/farm/slurm.sh" "$scene" "$work/cluster.exr" "$parts" && while squeue --noheader | grep -q .; do sleep 1; done
}
export -f slurm
export root scene work parts
if "$root/tests/farm/slurm.sh" bash -euo pipefail -c slurm >"$work/log" 2>&1; then
  check "Slurm's job array and merge" "$work/cluster.exr"
elif [ $? = 77 ]; then
  echo "Slurm: skipped, because $(cat "$work/log")"
else
  cat "$work/log" "$work"/slurm-*.out >&2
  exit 1
fi

# The command of a manifest, in which /templates is the folder farm.
argument() { # MANIFEST
  sed -n "s/^ *args: \['\(.*\)'\]$/\1/p" "$1" | sed "s|/templates/|$root/farm/|"
}
for ((part = 0; part < parts; part++)); do
  SCENE=$scene PICTURE=$work/pods.exr JOB_COMPLETION_INDEX=$part bash -c "$(argument "$root/farm/kubernetes.yaml")" >"$work/log" 2>&1 \
    || { cat "$work/log" >&2; exit 1; }
done
PICTURE=$work/pods.exr PARTS=$parts bash -c "$(argument "$root/farm/kubernetes-merge.yaml")" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
check "Kubernetes' commands, without Kubernetes" "$work/pods.exr"

"$root/farm/merge.sh" "$work/pods.exr" $((parts - 1)) >"$work/log" 2>&1
! same "$work/pods.exr" "$work/whole.exr" || { echo "a part was left out, but nothing differs" >&2; exit 1; }
echo "planted fault: a part that is left out is found"

# A part that another command has left is refused, and stays as it is.
refused() { # WHAT SCENE PICTURE PART
  local before
  before=$(sha256sum "${3%.exr}.parts"/*)
  if "$root/farm/part.sh" "$2" "$3" "$4" >"$work/log" 2>&1 || ! grep -q "another render" "$work/log"; then
    echo "a part of $1 is not refused: $(cat "$work/log")" >&2
    exit 1
  fi
  [[ $(sha256sum "${3%.exr}.parts"/*) == "$before" ]] || { echo "a part of $1 has changed a file" >&2; exit 1; }
}
refused "another scene" "$root/scenes/furnace/scene.xml" "$work/pods.exr" 1
SPP=24 refused "another SPP" "$scene" "$work/pods.exr" 1
OPTIONS="$OPTIONS --seed 9" refused "another seed" "$scene" "$work/pods.exr" 1
OPTIONS="$OPTIONS --max-depth 3" refused "another depth" "$scene" "$work/pods.exr" 0
echo "parts of other commands: refused"

# Guided parts begin with one guide. Its samples are not theirs.
"$LODESTAR" render "$scene" --width 40 --height 24 --spp 16 --seed 1 --checkpoint "$work/guide.ckpt" --quiet -o "$work/guide.exr"
for part in 0 1; do
  GUIDE=$work/guide.ckpt OPTIONS="--width 40 --height 24 --quiet" "$root/farm/part.sh" "$scene" "$work/guided.exr" "$part"
done
"$root/farm/merge.sh" "$work/guided.exr" 2 >"$work/log" 2>&1
"$root/farm/merge.sh" "$work/guided.exr" 1
cmp "$work/guided.exr" "$work/guided.parts/000000.exr"
echo "guided parts: merged"
