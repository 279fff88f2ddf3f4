#!/usr/bin/env bash
# Measures what attacks on the page do to a render: all of benches/page_attack.py at once, for as long as the render lasts.
#
#   benches/page_under_attack.sh BINARY [SECONDS]
#
# It finds how many samples of scenes/cornell-box take SECONDS (600) with --view, then renders so many three ways in turns: alone,
# with --view, and with --view under attack. Where there is a page, the owner asks for it and for the state with the token every two
# seconds. It prints a table, and fails if bits differ, if the attacks take more than 16 MiB, if the owner is not answered, or if the program
# does not end. The ratio of the times is printed and does not fail, because it means something on a quiet machine only; 1.03 is
# the goal. The attackers have the lowest priority, so that their own work is not counted.
#
# ROUNDS (1) changes the number of rounds, WIDTH (512) the width of the picture. It needs bash, awk, curl, Python 3 and the usual tools.
set -eu
export LC_ALL=C

[ $# -eq 1 ] || [ $# -eq 2 ] || { sed -n '4p' "$0" | sed 's/^# *//' >&2; exit 2; }
root=$(cd "$(dirname "$0")/.." && pwd)
binary=$(realpath "$1") seconds=${2:-600}
rounds=${ROUNDS:-1} width=${WIDTH:-512} most_memory=16
scene=$root/scenes/cornell-box/scene.xml
work=$(mktemp -d)
children=()
trap 'for child in "${children[@]}"; do kill "$child" 2>/dev/null || true; done; rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
unset LODESTAR_VIEW_TOKEN

fail() { echo "FAILED: $*" >&2; failed=1; }
failed=0

# Renders and leaves the picture's channels, the seconds between the first and the last step and the largest memory in MiB.
measure() { # WAY SPP
  local way=$1 log=$work/log view=--view program attacker= url answered=0 asked=0
  : >"$log"
  [ "$way" != alone ] || view=
  # An empty $view is no argument.
  # shellcheck disable=SC2086
  "$binary" render "$scene" --width "$width" --height "$width" --spp "$2" --log json $view -o "$work/$way.exr" 2>"$log" </dev/null &
  program=$!
  children=("$program")
  if [ "$way" != alone ]; then
    url=
    while [ -z "$url" ]; do
      url=$(sed -n 's|.*"address":"\(http://[^"]*\)".*|\1|p' "$log" | head -n 1)
      kill -0 "$program" || { cat "$log" >&2; exit 1; }
      sleep 0.05
    done
    if [ "$way" = attacked ]; then
      nice -n 19 python3 "$root/benches/page_attack.py" "$(sed 's|http://\([^/]*\)/.*|\1|' <<<"$url")" >"$work/attacks" 2>"$work/attacker" &
      attacker=$!
      children+=("$attacker")
    fi
  fi
  : >"$work/memory" >"$work/shares"
  while kill -0 "$program" 2>/dev/null; do
    awk '/^VmHWM/ { print $2 / 1024 }' "/proc/$program/status" >>"$work/memory" 2>/dev/null || true
    # Processor time of the page's threads, and of all threads.
    awk '{ t = $14 + $15; all += t; if ($2 ~ /^\(view/) page += t } END { if (all) printf "%.3f\n", 100 * page / all }' \
      <(cat /proc/"$program"/task/*/stat 2>/dev/null | sed 's/ worker)/)/; s/ denoiser)/)/; s/^\([0-9]*\) (\([^ )]*\)[^)]*)/\1 (\2)/') >>"$work/shares" || true
    if [ "$way" != alone ] && ! grep -q '"event":"end"' "$log"; then
      asked=$((asked + 1))
      if curl -s -m 10 -o "$work/page" "${url%%#*}" &&
        curl -s -m 10 -N -H "X-Lodestar-Token: ${url#*#}" "${url%%#*}events" 2>/dev/null | head -c 6 | grep -q 'data: '; then
        answered=$((answered + 1))
      fi
    fi
    sleep 2
  done
  wait "$program" || fail "$way: the program has failed: $(tail -n 1 "$log")"
  if [ -n "$attacker" ]; then
    kill "$attacker" 2>/dev/null || true
    wait "$attacker" || true
    echo "owner: answered $answered times of $asked" >"$work/owner"
  fi
  # The last question may meet the end of the render.
  [ "$answered" -ge $((asked - 1)) ] || fail "$way: the owner was answered $answered times of $asked"
  children=()
  awk '/"event":"step"/ { match($0, /"time":[0-9.]+/); t = substr($0, RSTART + 7, RLENGTH - 7); if (!n++) first = t; last = t }
    END { printf "%.3f ", last - first }' "$log" >>"$work/$way.times"
  echo "$(tail -n 1 "$work/memory") $(tail -n 1 "$work/shares")" >>"$work/$way.times"
}

# Whether two pictures have the same chunks. Their headers differ, for example in the seconds.
same_bits() { # PICTURE PICTURE
  python3 - "$@" <<'PYTHON'
import struct, sys


def chunks(path):
    data = open(path, "rb").read()
    at = 8
    # Attributes: name, type, size, value. An empty name ends them, and the table of the chunks' places follows.
    while data[at]:
        for _ in range(2):
            at = data.index(0, at) + 1
        at += 4 + struct.unpack_from("<I", data, at)[0]
    return data[struct.unpack_from("<Q", data, at + 1)[0] :]


first, second = map(chunks, sys.argv[1:])
sys.exit(not (first and first == second))
PYTHON
}

# Median of a column.
median() { awk -v c="$2" '{ print $c }' "$work/$1.times" | sort -n | awk '{ a[NR] = $1 } END { print a[int((NR + 1) / 2)] }'; }

measure view 256
spp=$(awk -v s="$seconds" '{ n = int(256 * s / ($1 > 0 ? $1 : 1)); print n < 64 ? 64 : n }' "$work/view.times")
rm "$work/view.times"
for _ in $(seq "$rounds"); do
  for way in alone view attacked; do
    measure "$way" "$spp"
  done
  for way in view attacked; do
    same_bits "$work/$way.exr" "$work/alone.exr" || fail "$way: the pictures' bits differ"
  done
done

echo "$spp samples of cornell-box, $width x $width pixels, $rounds rounds on $(nproc) cores"
printf '%-10s %10s %8s %12s %18s\n' way seconds ratio 'memory MiB' "page's share, %"
for way in alone view attacked; do
  awk -v way="$way" -v s="$(median "$way" 1)" -v of="$(median view 1)" -v m="$(median "$way" 2)" \
    -v p="$(median "$way" 3)" 'BEGIN { printf "%-10s %10.2f %8.4f %12.1f %18.3f\n", way, s, s / (of > 0 ? of : 1), m, p }'
done
cat "$work/owner"
echo "connections of the attacks: $(cat "$work/attacks")"
more=$(awk -v a="$(median attacked 2)" -v b="$(median view 2)" 'BEGIN { printf "%.1f", a - b }')
echo "more memory under attack: $more MiB (at most $most_memory)"
awk -v m="$more" -v most="$most_memory" 'BEGIN { exit !(m <= most) }' || fail "the attacks took $more MiB"
[ "$failed" = 0 ] && echo "passed: same bits, memory, answers, end"
exit "$failed"
