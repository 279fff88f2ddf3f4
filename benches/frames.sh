#!/usr/bin/env bash
# Compares frames whose guide is kept with frames that begin anew and with unguided ones, at equal samples. The machine's load does not
# change a figure.
#
#   benches/frames.sh BINARY SCENE.xml [OPTION...]
#
# The camera of the scene moves SHIFT (0.03 0 0) along the axes of the world from frame to frame; the scene has one sensor with one matrix. SPP (8),
# FRAMES (8), WIDTH (96), HEIGHT (54) and REFERENCE_SPP (512) change the renders. Further options go to all of them.
# Prints, for each frame but the first: the relative RMSE without the largest 0.1 % of the terms with the guide kept, over that of a guide that
# begins anew, and over that of `--sampler bsdf`; then their means. The reference has other seeds.
set -euo pipefail
export LC_ALL=C

[ $# -ge 2 ] || { sed -n '5p' "$0" | sed 's/^# *//' >&2; exit 2; }
binary=$(realpath "$1") scene=$(realpath "$2")
shift 2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
ln -s "$(dirname "$scene")"/* "$work"
rm "$work/$(basename "$scene")"
read -r x y z <<<"${SHIFT:-0.03 0 0}"
moves=(-D "shift_x=\$frame*$x" -D "shift_y=\$frame*$y" -D "shift_z=\$frame*$z")
python3 - "$scene" "$work/moving.xml" <<'PYTHON'
import re, sys
text = open(sys.argv[1]).read()
sensor = re.search(r"<sensor.*?</sensor>", text, re.DOTALL)
moved = re.sub(r"(<matrix[^>]*/>)", r'\1<translate x="$shift_x" y="$shift_y" z="$shift_z"/>', sensor[0], count=1)
open(sys.argv[2], "w").write(text.replace(sensor[0], moved))
PYTHON

last=${FRAMES:-8}
# Renders all frames into the folder NAME.
frames() { # NAME SPP SEED OPTION...
  local name=$1 spp=$2 seed=$3
  shift 3
  mkdir "$work/$name"
  "$binary" render "$work/moving.xml" "${moves[@]}" --frames "1-$last" --width "${WIDTH:-96}" --height "${HEIGHT:-54}" --rfilter box --spp "$spp" \
    --seed "$seed" "$@" --quiet -o "$work/$name/#.exr" >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; return 1; }
}
frames reference "${REFERENCE_SPP:-512}" 1000 "$@"
frames kept "${SPP:-8}" 0 "$@"
frames anew "${SPP:-8}" 0 --fresh-guide "$@"
frames bsdf "${SPP:-8}" 0 --sampler bsdf "$@"

error() { # NAME FRAME
  "$binary" compare --json "$work/$1/$2.exr" "$work/reference/$2.exr" | python3 -c 'import json, sys; print(json.load(sys.stdin)["relmse_trim"] ** 0.5)'
}
printf 'frame   kept over anew   kept over bsdf\n'
for ((frame = 2; frame <= last; ++frame)); do
  echo "$frame $(error kept "$frame") $(error anew "$frame") $(error bsdf "$frame")"
done | awk '{ printf "%5d   %14.3f   %14.3f\n", $1, $2 / $3, $2 / $4; anew += $2 / $3; bsdf += $2 / $4 }
  END { printf " mean   %14.3f   %14.3f\n", anew / NR, bsdf / NR }'
