#!/bin/sh
# Compares speed and size of two builds of lodestar in one run.
#
#   benches/before_after.sh BEFORE AFTER [SCENES_DIR]
#
# It prints three tables:
#   - paths per second on the scenes cornell-box and kitchen, with default settings and as a plain path tracer
#     (--sampler bsdf --nee off): the medians of both builds, and median, least and greatest of the rounds' ratios;
#   - seconds until the first sample (`setup_seconds` of --stats: the scene is loaded and the kernels are compiled, which
#     the driver's cache shortens), the same way;
#   - bytes of the kernels' SPIR-V as `inspect --out` writes them, full and specialized to the default variant, and bytes
#     of the programs.
#
# SCENES_DIR holds a folder with a scene.xml for every scene; it defaults to LODESTAR_SCENES, or else to this
# repository's scenes, which lack the kitchen. A scene that is not there is skipped, and this is said.
#
# The builds take turns, BEFORE then AFTER, for five rounds with as many samples each time, so that a machine that slows
# down slows both. Each first renders once without being measured, which fills the driver's cache of kernels.
# ROUNDS and SPP change the number of rounds (5) and of samples per pixel (16); LODESTAR_DEVICE chooses the device.
#
# It needs sh, awk and the usual tools. The exit status is 1 if a build fails to render.
set -eu
export LC_ALL=C

[ $# -eq 2 ] || [ $# -eq 3 ] || { sed -n '2,4p' "$0" | sed 's/^# *//' >&2; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
before=$1 after=$2 scenes=${3:-${LODESTAR_SCENES:-$root/scenes}}
rounds=${ROUNDS:-5} spp=${SPP:-16}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM

# Prints a number of a --stats file, whatever its layout: of its object `totals`, or of the outermost one.
total() { # FILE NAME
  tr -d ' \t\r\n' <"$1" | sed 's/.*"totals":{\([^}]*\)}.*/\1/' | tr ',' '\n' | sed -n "s/^\"$2\"://p"
}
outer() { # FILE NAME
  tr -d ' \t\r\n' <"$1" | tr ',{}' '\n\n\n' | sed -n "s/^\"$2\"://p" | head -n 1
}

# Renders once and prints paths per second and seconds of setup.
measure() { # BINARY SCENE WIDTH HEIGHT OPTION...
  binary=$1 scene=$2 width=$3 height=$4
  shift 4
  rm -f "$work/stats.json" "$work/picture.exr"
  if ! "$binary" render "$scene" --width "$width" --height "$height" --spp "$spp" "$@" --quiet \
    --stats "$work/stats.json" -o "$work/picture.exr" >"$work/log" 2>&1 </dev/null; then
    echo "before_after.sh: $binary does not render $scene $*:" >&2
    cat "$work/log" >&2
    return 1
  fi
  paths=$(total "$work/stats.json" paths) seconds=$(total "$work/stats.json" seconds)
  setup=$(outer "$work/stats.json" setup_seconds)
  if [ -z "$paths" ] || [ -z "$seconds" ] || [ -z "$setup" ]; then
    echo "before_after.sh: the --stats of $binary lack paths, seconds or setup_seconds" >&2
    return 1
  fi
  awk -v paths="$paths" -v seconds="$seconds" -v setup="$setup" 'BEGIN { print paths / seconds, setup }'
}

# Prints the medians of columns BEFORE and AFTER, and median, least and greatest of their ratios.
compare() { # FILE BEFORE AFTER FORMAT
  awk -v a="$2" -v b="$3" -v format="$4" '
    function sort(v, n,    i, j, x) {
      for (i = 2; i <= n; i++) { x = v[i]; for (j = i - 1; j > 0 && v[j] > x; j--) v[j + 1] = v[j]; v[j + 1] = x }
    }
    function median(v, n) { sort(v, n); return (v[int((n + 1) / 2)] + v[int(n / 2) + 1]) / 2 }
    { n++; x[n] = $a; y[n] = $b; ratio[n] = $b / $a }
    END {
      m = median(ratio, n)
      printf format " " format "  %6.3f  %.3f to %.3f\n", median(x, n), median(y, n), m, ratio[1], ratio[n]
    }' "$1"
}

# Lets both builds take turns on one scene with one choice of options, and adds a row to both tables.
row() { # LABEL SCENE WIDTH HEIGHT OPTION...
  label=$1 scene=$scenes/$2/scene.xml
  shift 2
  if [ ! -f "$scene" ]; then
    echo "skipped: $scene is not there" >&2
    return 0
  fi
  measure "$before" "$scene" "$@" >/dev/null
  measure "$after" "$scene" "$@" >/dev/null
  : >"$work/rounds"
  round=0
  while [ "$round" -lt "$rounds" ]; do
    one=$(measure "$before" "$scene" "$@")
    two=$(measure "$after" "$scene" "$@")
    echo "$one $two" >>"$work/rounds"
    round=$((round + 1))
  done
  printf '%-24s %s\n' "$label" "$(compare "$work/rounds" 1 3 '%10.0f')" >>"$work/speed"
  printf '%-24s %s\n' "$label" "$(compare "$work/rounds" 2 4 '%10.3f')" >>"$work/setup"
}

# Prints a line NAME BYTES for every kernel of a build.
kernel_sizes() { # BINARY FOLDER
  mkdir -p "$2"
  "$1" inspect --out "$2" >"$work/log" 2>&1 </dev/null || { cat "$work/log" >&2; return 1; }
  (
    cd "$2"
    for file in *.spv specialized/*.spv; do
      if [ -f "$file" ]; then echo "$file $(wc -c <"$file")"; fi
    done
  )
  echo "program $(wc -c <"$1")"
}

heading() { # TITLE
  printf '\n%-24s %10s %10s   ratio  %s\n' "$1" before after "${2:-}"
}

: >"$work/speed"
: >"$work/setup"
row cornell-box cornell-box 256 256
row "cornell-box bsdf" cornell-box 256 256 --sampler bsdf --nee off
row kitchen kitchen 256 144
row "kitchen bsdf" kitchen 256 144 --sampler bsdf --nee off
echo "median of $rounds rounds, $spp samples per pixel"
heading "paths/s" "least to greatest"
cat "$work/speed"
heading "s to the first sample" "least to greatest"
cat "$work/setup"

kernel_sizes "$before" "$work/before" >"$work/sizes.before"
kernel_sizes "$after" "$work/after" >"$work/sizes.after"
heading "bytes"
awk '
  function line(name, a, b) {
    printf "%-24s %10s %10s  %s\n", name, a == "" ? "-" : a, b == "" ? "-" : b, a == "" || b == "" ? "" : sprintf("%6.3f", b / a)
  }
  NR == FNR { a[$1] = $2; order[++n] = $1; next }
  { if (!($1 in a)) order[++n] = $1; b[$1] = $2 }
  END {
    for (i = 1; i <= n; i++) {
      name = order[i]
      if (name == "program") continue
      kind = name ~ /^specialized\// ? "all specialized kernels" : "all kernels"
      sum_a[kind] += a[name]; sum_b[kind] += b[name]
      short = name; sub(/^specialized\//, "s/", short); sub(/\.spv$/, "", short)
      line(short, a[name], b[name])
    }
    print "(s/ is specialized)"
    line("all kernels", sum_a["all kernels"], sum_b["all kernels"])
    line("all specialized kernels", sum_a["all specialized kernels"], sum_b["all specialized kernels"])
    line("program", a["program"], b["program"])
  }' "$work/sizes.before" "$work/sizes.after"
