#!/usr/bin/env bash
# Measures all that matters on a GPU in one command of at most nine minutes, for machines that are lent for ten.
#
#   benches/gpu.sh BINARY OUT_DIR [SCENE...]
#
# LODESTAR_SCENES names the folder of the scenes, and LODESTAR_REFERENCES that of the references. Without scenes it takes all
# that have a reference. The work is done in the order of its worth. Each line of a result is written to OUT_DIR as soon as it
# is there, so a command that is ended early has lost nothing that was measured:
#
#   speed.tsv       samples per second of a pixel and million rays per second of all methods, at the size that a scene asks for.
#                   The methods take turns on each scene. Emitters are sampled (+) or not (-). Mitsuba's `path` is one of them,
#                   where MITSUBA names a Python that has it; its variant is cuda_ad_rgb, or MITSUBA_VARIANT
#   errors.tsv      the same at the references' sizes, with errors: the mean absolute error of the displayed picture, and relMSE
#   executions.tsv  the default as one kernel and as waves
#   registers.txt   what the driver's compiler says of the kernels: registers, memory of stacks
#   tests.txt       output of TESTS, which is a command that runs tests, such as an executable of target/release/deps. The
#                   validation layers are on where they are installed
#   log.txt         messages, and when each part ended
#
# BUDGET (540) is the number of seconds after which no further run begins; the last part gets what is left. SECONDS_EACH (1.5) is
# the length of a render. SIZE=reference renders everything at the references' sizes, for slow devices.
# LODESTAR_DEVICE chooses the device. It needs bash, python3 and the usual tools.
set -euo pipefail
export LC_ALL=C

[ $# -ge 2 ] || { sed -n '4p' "$0" | sed 's/^# *//' >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
binary=$1 out=$2
shift 2
scenes=${LODESTAR_SCENES:?names no folder with scenes} references=${LODESTAR_REFERENCES:-}
[ $# -gt 0 ] || for mean in "$references"/*.mean.exr; do set -- "$@" "$(basename "$mean" .mean.exr)"; done
seconds=${SECONDS_EACH:-1.5}
budget=${BUDGET:-540} begin=$(date +%s)
mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Paths that all methods follow alike.
paths=(--max-depth 16 --rr-depth 8 --rfilter box)

say() { echo "$(($(date +%s) - begin)) s: $*" | tee -a "$out/log.txt"; }
left() { echo $((budget - $(date +%s) + begin)); }
ended() { if [ "$(left)" -gt 15 ]; then say "measured: $*"; else say "not all measured, for want of time: $*"; fi; }

# Prints the width and the height of a picture.
size_of() { # PICTURE
  python3 - "$1" <<'END'
import struct, sys
head = open(sys.argv[1], "rb").read(4096)
at = head.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
x0, y0, x1, y1 = struct.unpack_from("<4i", head, at)
print(x1 - x0 + 1, y1 - y0 + 1)
END
}

# Prints errors of a picture against the reference of a scene: mean absolute error of the displayed picture, relMSE. Prints `- -`
# where there is no reference of this size.
errors() { # SCENE PICTURE
  "$binary" compare --json "$2" "$references/$1.mean.exr" 2>/dev/null |
    python3 -c 'import json, sys; e = json.load(sys.stdin); print(e["mae_ldr"], e["relmse"])' 2>/dev/null || echo - -
}

# Size at which a table renders a scene, as width and height; nothing where the scene decides.
size_of_table() { # TABLE SCENE
  [ "$1" != errors ] && [ "${SIZE:-}" != reference ] || size_of "$references/$2.mean.exr"
}

# Renders a scene and appends a line to a table: scene, method, samples per second of a pixel, Mrays/s, errors.
measure() { # TABLE SCENE METHOD OPTION...
  local table=$1 scene=$2 method=$3 size rates pixels
  shift 3
  [ "$(left)" -gt 15 ] || return 0
  read -ra size <<<"$(size_of_table "$table" "$scene" | sed 's/\(.*\) \(.*\)/--width \1 --height \2/')"
  if ! timeout "$(left)" "$binary" render "$scenes/$scene/scene.xml" "${size[@]}" "${paths[@]}" --time "$seconds" --spp 1000000 "$@" \
    --overwrite --quiet --stats "$work/stats.json" -o "$work/picture.exr" >"$work/log" 2>&1 </dev/null; then
    say "$scene, $method failed: $(tail -n 1 "$work/log")"
    return 0
  fi
  pixels=$(($(size_of "$work/picture.exr" | tr ' ' '*')))
  rates=$(python3 -c 'import json, sys
t = json.load(open(sys.argv[1]))["totals"]
print(t["paths"] / int(sys.argv[2]) / t["seconds"], (t["rays"] + t["shadow_rays"]) / t["seconds"] / 1e6)' \
    "$work/stats.json" "$pixels")
  echo "$scene $method $rates $(errors "$scene" "$work/picture.exr")" | tr ' ' '\t' >>"$out/$table.tsv"
}

# Appends the line of Mitsuba's `path` to a table. The size is that of the picture rendered last.
measure_mitsuba() { # TABLE SCENE
  local width height result
  [ -n "${MITSUBA:-}" ] && [ -e "$work/picture.exr" ] && [ "$(left)" -gt 30 ] || return 0
  read -r width height <<<"$(size_of "$work/picture.exr")"
  if ! result=$(MITSUBA_VARIANT=${MITSUBA_VARIANT:-cuda_ad_rgb} timeout "$(left)" "$MITSUBA" "$here/mitsuba_render.py" \
    "$scenes/$2/scene.xml" "$width" "$height" "$seconds" 1 "$work/mitsuba.exr" 2>"$work/log"); then
    say "$2, mitsuba failed: $(tail -n 1 "$work/log")"
    return 0
  fi
  echo "$2 mitsuba $(awk '{ print $1 / $2 }' <<<"$result") - $(errors "$2" "$work/mitsuba.exr")" | tr ' ' '\t' >>"$out/$1.tsv"
}

"$binary" devices >"$out/log.txt" 2>&1 || true
say "begins with $*"
header=$'scene\tmethod\tsamples/s\tMrays/s\tmae_ldr\trelmse'
for table in speed errors executions; do echo "$header" >"$out/$table.tsv"; done
for scene; do
  measure speed "$scene" product+ --nee on
  measure_mitsuba speed "$scene"
  measure speed "$scene" bsdf- --sampler bsdf --nee off
done
ended "speed of the default, of bsdf, and of Mitsuba"
for scene; do
  measure errors "$scene" product+ --nee on
  measure_mitsuba errors "$scene"
  measure errors "$scene" bsdf+ --sampler bsdf --nee on
done
ended "errors"
for scene; do
  measure executions "$scene" megakernel --execution megakernel
  measure executions "$scene" wavefront --execution wavefront
done
ended "megakernel and waves"
if [ "$(left)" -gt 30 ]; then
  for options in "" "--sampler bsdf"; do
    # shellcheck disable=SC2086  # an option and its value are two arguments
    timeout "$(left)" "$binary" inspect --back-end storage --scene "$scenes/$1/scene.xml" $options \
      --device "${LODESTAR_DEVICE:-0}" --lines 0 >>"$out/registers.txt" 2>&1 </dev/null || say "inspect $options failed"
  done
fi
ended "registers"
for scene; do
  measure speed "$scene" product- --nee off
  measure speed "$scene" bsdf+ --sampler bsdf --nee on
  measure errors "$scene" quadtree- --sampler quadtree --nee off
  measure errors "$scene" quadtree+ --sampler quadtree --nee on
done
ended "other methods"
if [ -n "${TESTS:-}" ] && [ "$(left)" -gt 10 ]; then
  timeout "$(left)" bash -c "$TESTS" >"$out/tests.txt" 2>&1 </dev/null || say "tests failed or had no time: see tests.txt"
fi
say "ends"
