#!/usr/bin/env bash
# Compares options by pairs of independent renders, so that no reference's noise is in the errors. The machine's load does not
# change a figure.
#
#   benches/pairs.sh BINARY SCENE.xml 'OPTIONS' 'OPTIONS'... [-- OPTION...]
#
# Each argument in quotes is a row. Options after `--` go to all rows. A row prints, relative to the first row: the RMSE at equal
# samples; the RMSE relative to the pixels of the pair's mean, without the largest 0.1 % of the terms; the counted rays; and both errors at
# equal rays, which are those at equal samples times the root of the rays. An outlier raises the mean of its pair, too, so the relative
# figure hardly shows it; the RMSE does.
# SPP (64), WIDTH (64), HEIGHT (36) and PAIRS (2) change the renders. The seeds are 1, 2, 3 and so on.
# Half the mean squared difference of a pair is the variance of one picture. A bias does not show. A mean absolute difference
# would not do: two pictures that miss the same rare light differ little. Take several pairs: a row's
# figure depends on few bright pixels.
#
# With REFERENCE_SPP=N, the errors are those of each picture against a picture of N samples by the default, rendered with another
# seed. They are relative to its pixels. A row then prints: the relative RMSE, the same without the largest 0.1 % of the pixels'
# terms, the counted rays, and the trimmed figure at equal rays. N of at least 64 times SPP hides the noise of that picture.
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
    "$@" --quiet --overwrite --stats "$work/stats.json" -o "$picture" >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; return 1; }
  python3 -c 'import json, sys; t = json.load(open(sys.argv[1]))["totals"]; print(t["rays"] + t["shadow_rays"])' \
    "$work/stats.json"
}

# Mean squared error of a picture against the mean of a pair, and the relative one, trimmed.
difference() { # A B
  rm -f "$work/mean.exr"
  "$binary" merge "$1" "$2" -o "$work/mean.exr" >"$work/log" 2>&1 || { cat "$work/log" >&2; return 1; }
  "$binary" compare --json "$1" "$work/mean.exr" |
    python3 -c 'import json, sys; errors = json.load(sys.stdin); print(errors["mse"], errors["relmse_trim"])'
}

# Relative mean squared errors of two pictures against the reference: all terms, and trimmed.
relative() { # A B
  "$binary" compare --json "$1" "$2" "$work/reference.exr" | python3 -c 'import json, sys
pictures = json.load(sys.stdin)
print(*(sum(picture[name] for picture in pictures) for name in ("relmse", "relmse_trim")))'
}

reference_spp=${REFERENCE_SPP:-0}
if [ "$reference_spp" -gt 0 ]; then
  SPP=$reference_spp rays 1000 "$work/reference.exr" "$@" >/dev/null
  printf 'relative RMSE   trimmed   rays   trimmed, at equal rays\n'
else
  printf 'RMSE   relative, trimmed   rays   RMSE at equal rays   relative, trimmed, at equal rays\n'
fi
first=
for row in "${rows[@]}"; do
  read -ra options <<<"$row"
  for ((pair = 0; pair < ${PAIRS:-2}; ++pair)); do
    one=$(rays $((2 * pair + 1)) "$work/a.exr" "${options[@]}" "$@")
    other=$(rays $((2 * pair + 2)) "$work/b.exr" "${options[@]}" "$@")
    if [ "$reference_spp" -gt 0 ]; then
      echo "$(relative "$work/a.exr" "$work/b.exr") $((one + other))"
    else
      echo "$(difference "$work/a.exr" "$work/b.exr") $((one + other))"
    fi
  done >"$work/pairs"
  sums=$(awk '{ mse += $1; trimmed += $2; rays += $3 } END { print mse, trimmed, rays }' "$work/pairs")
  : "${first:=$sums}"
  awk -v name="$row" -v own="$sums" -v first="$first" -v pairs="$((reference_spp == 0))" 'BEGIN {
    split(own, a, " "); split(first, b, " ")
    error = sqrt(a[1] / b[1]); trimmed = sqrt(a[2] / b[2]); rays = a[3] / b[3]
    printf "%.3f  %.3f  %.3f  ", error, trimmed, rays
    if (pairs) printf "%.3f  ", error * sqrt(rays)
    printf "%.3f  %s\n", trimmed * sqrt(rays), name
  }'
done
