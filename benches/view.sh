#!/usr/bin/env bash
# Measures what viewers cost a render.
#
#   benches/view.sh BINARY [SCENE.xml]
#
# It renders SCENE (scenes/cornell-box) three ways that take turns: without --view, with --view but no page, and with --view and
# a client that receives the events and fetches a layer and a pixel with the guide's map of every new shot, as an open page
# does. It prints the median seconds between the first and the last step and the median processor seconds, each with median,
# least and greatest of the rounds' ratios to the render without --view. Processor seconds count the server's threads. On a device that is a processor they
# tell the cost also while other programs run.
#
# ROUNDS and SPP change the number of rounds (9) and of samples per pixel (96); WIDTH changes the width (512).
# It needs bash, awk, curl and the usual tools.
set -eu
export LC_ALL=C

[ $# -eq 1 ] || [ $# -eq 2 ] || { sed -n '4p' "$0" | sed 's/^# *//' >&2; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
binary=$1 scene=${2:-$root/scenes/cornell-box/scene.xml}
rounds=${ROUNDS:-9} spp=${SPP:-96} width=${WIDTH:-512}
work=$(mktemp -d)
client=
trap '[ -z "$client" ] || kill "$client" 2>/dev/null; rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM

# Asks for what an open page asks for: the events, and a layer and a pixel of every new shot.
look() { # LOG
  url=
  while [ -z "$url" ]; do
    url=$(sed -n 's|.*"address":"\(http://[^"]*\)".*|\1|p' "$1" | head -n 1)
    sleep 0.05
  done
  header="X-Lodestar-Token: ${url#*#}" url=${url%%/#*}
  last=0
  curl -sN -H "$header" "$url/events" 2>/dev/null | sed -un 's/.*"shot":\([0-9]*\),.*/\1/p' | while read -r shot; do
    if [ "$shot" != "$last" ]; then
      last=$shot
      curl -s -H "$header" -o "$work/layer" "$url/layer?name=radiance" && curl -s -H "$header" -o "$work/pixel" "$url/pixel?x=20&y=20" || break
      echo "$shot" >"$work/shots"
    fi
  done
}

# Renders once and prints the seconds between the first and the last step, and the processor seconds.
measure() { # WAY
  log=$work/log view=--view
  : >"$log"
  [ "$1" != plain ] || view=
  if [ "$1" = page ]; then
    look "$log" &
    client=$!
  fi
  TIMEFORMAT='%U %S'
  # An empty $view is no argument.
  # shellcheck disable=SC2086
  { time "$binary" render "$scene" --width "$width" --spp "$spp" --log json $view -o "$work/picture.exr" 2>"$log" </dev/null
  } 2>"$work/cpu"
  if [ -n "$client" ]; then
    wait "$client" || true
    client=
  fi
  awk '/"event":"step"/ { match($0, /"time":[0-9.]+/); t = substr($0, RSTART + 7, RLENGTH - 7); if (!n++) first = t; last = t }
    END { printf "%.6f ", last - first }' "$log"
  awk '{ print $1 + $2 }' "$work/cpu"
}

measure plain >"$work/warm"
for round in $(seq "$rounds"); do
  for way in plain view page; do
    measure "$way" >>"$work/$way"
  done
done
echo "shots that the client has fetched in the last round: $(cat "$work/shots")"
for column in 1 2; do
  [ "$column" = 1 ] && echo "seconds between the first and the last step" || echo "processor seconds"
  for way in plain view page; do
    paste -d ' ' "$work/plain" "$work/$way" | awk -v way="$way" -v column="$column" '
      function sort(a, n,  i, j, t) {
        for (i = 2; i <= n; i++) for (j = i; j > 1 && a[j] < a[j - 1]; j--) { t = a[j]; a[j] = a[j - 1]; a[j - 1] = t }
      }
      { seconds[NR] = $(column + 2); ratio[NR] = $(column + 2) / $column }
      END {
        sort(seconds, NR); sort(ratio, NR); m = int((NR + 1) / 2)
        printf "  %-6s %8.3f s   ratio %.4f (%.4f to %.4f)\n", way, seconds[m], ratio[m], ratio[1], ratio[NR]
      }'
  done
done
