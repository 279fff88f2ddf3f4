#!/usr/bin/env bash
# Submits a picture to Slurm: an array with one task for each part, and a job that merges the parts.
#
#   farm/slurm.sh SCENE PICTURE.exr PARTS [OPTION OF SBATCH...]
#
# All nodes need this folder, the scene and the picture's folder at the same paths. Options of sbatch, such as `--gres=gpu:1` and
# `--time=2:00:00`, count for the array. A part that Slurm puts back into the queue goes on from its checkpoint.
# farm/part.sh lists the variables; Slurm hands them to the tasks.
set -euo pipefail

[[ $# -ge 3 ]] || { sed -n '4p' "$0" | sed 's/^# *//' >&2; exit 2; }
farm=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scene=$(realpath "$1") picture=$(realpath "$2") parts=$3
shift 3
command() { printf '%q ' "$@"; }

array=$(sbatch --parsable --export=ALL --requeue --job-name=lodestar-parts --array="0-$((parts - 1))" "$@" \
  --wrap="exec $(command "$farm/part.sh" "$scene" "$picture")\$SLURM_ARRAY_TASK_ID")
merge=$(sbatch --parsable --export=ALL --job-name=lodestar-merge --dependency="afterok:${array%%;*}" --kill-on-invalid-dep=yes \
  --wrap="exec $(command "$farm/merge.sh" "$picture" "$parts")")
echo "parts: job ${array%%;*}, merge: job ${merge%%;*}"
