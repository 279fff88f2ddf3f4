#!/usr/bin/env bash
# Compares options by pairs of independent renders, so that no reference's noise is in the errors. The machine's load does not
# change a figure.
#
#   benches/pairs.sh BINARY SCENE.xml 'OPTIONS' 'OPTIONS'... [-- OPTION...]
#
# Each argument in quotes is a row. Options after `--` go to all rows. A row prints, relative to the first row: the RMSE at equal
# samples, the counted rays, and the RMSE at equal rays, which is the first figure times the root of the second.
# SPP (64), WIDTH (64), HEIGHT (36) and PAIRS (2) change the renders. The seeds are 1, 2, 3 and so on.
# Half the mean squared difference of a pair is the variance of one picture. A bias does not show. A mean absolute difference
# would not do: two pictures that miss the same rare light differ little. Take several pairs: a row's
# figure depends on few bright pixels.
set -euo pipefail
export LC_ALL=C

[ $# -ge 3 ] || { sed -n '5p' "$0" | sed 's/^# *//' >&2; exit 2; }
binary=$1 scene=$2
shift 2
rows=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do rows+=("$1"); shift; done
[ $# -eq 0 ] || shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Prints the counted rays of a render.
rays() { # SEED PICTURE OPTION...
  local seed=$1 picture=$2
  shift 2
  "$binary" render "$scene" --width "${WIDTH:-64}" --height "${HEIGHT:-36}" --spp "${SPP:-64}" --rfilter box --seed "$seed" \
    "$@" --quiet --stats "$work/stats.json" -o "$picture" >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; return 1; }
  python3 -c 'import json, sys; t = json.load(open(sys.argv[1]))["totals"]; print(t["rays"] + t["shadow_rays"])' \
    "$work/stats.json"
}

# Mean squared difference of two pictures.
difference() { # A B
  "$binary" compare --json "$1" "$2" |
    python3 -c 'import json, sys; print(json.load(sys.stdin)["mse"])'
}

first=
printf 'RMSE   rays   RMSE at equal rays\n'
for row in "${rows[@]}"; do
  read -ra options <<<"$row"
  for ((pair = 0; pair < ${PAIRS:-2}; ++pair)); do
    one=$(rays $((2 * pair + 1)) "$work/a.exr" "${options[@]}" "$@")
    other=$(rays $((2 * pair + 2)) "$work/b.exr" "${options[@]}" "$@")
    echo "$(difference "$work/a.exr" "$work/b.exr") $((one + other))"
  done >"$work/pairs"
  sums=$(awk '{ mse += $1; rays += $2 } END { print mse, rays }' "$work/pairs")
  : "${first:=$sums}"
  awk -v name="$row" -v own="$sums" -v first="$first" 'BEGIN {
    split(own, a, " "); split(first, b, " ")
    error = sqrt(a[1] / b[1]); rays = a[2] / b[2]
    printf "%.3f  %.3f  %.3f  %s\n", error, rays, error * sqrt(rays), name
  }'
done
