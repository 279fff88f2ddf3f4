#!/usr/bin/env bash
# Renders a picture in parts with GNU parallel, then merges them.
#
#   farm/parallel.sh SCENE PICTURE.exr PARTS [OPTION OF PARALLEL...]
#
# Without options, one part renders at a time. `--jobs 2` renders two at a time. `--sshloginfile nodes.txt` renders on other
# machines, which need this folder, the scene and the picture's folder at the same absolute paths. farm/part.sh lists the variables.
set -euo pipefail

[[ $# -ge 3 ]] || { sed -n '4p' "$0" | sed 's/^# *//' >&2; exit 2; }
farm=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scene=$(realpath "$1") picture=$(realpath "$2") parts=$3
shift 3
export SPP=${SPP:-256} OPTIONS=${OPTIONS:-} GUIDE=${GUIDE:-} LODESTAR=${LODESTAR:-lodestar}

seq 0 $((parts - 1)) | parallel --jobs 1 --halt now,fail=1 --line-buffer \
  --env SPP --env OPTIONS --env GUIDE --env LODESTAR "$@" "$farm/part.sh" "$(printf %q "$scene")" "$(printf %q "$picture")" '{}'
"$farm/merge.sh" "$picture" "$parts"
