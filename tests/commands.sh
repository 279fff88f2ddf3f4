#!/usr/bin/env bash
# Tests the command line where systems differ: paths, files that are replaced, checkpoints, the page of --view.
#
# usage: tests/commands.sh BINARY
#
# It runs on Linux, on macOS, and on Windows in Git Bash. tests/windows.sh runs it under Wine. It needs bash, and curl for the page.
# LODESTAR_TEST_PATH names a command that turns an absolute path into one of the tested system; by default `cygpath -w` where there is one.
# The cache of kernels is not tested, because lavapipe leaves nothing to keep.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
[[ $# -eq 1 && -x $1 ]] || { echo "usage: tests/commands.sh BINARY" >&2; exit 2; }
binary=$(cd "$(dirname "$1")" && pwd)/$(basename "$1")
scene=$PWD/scenes/cornell-box
work=$(mktemp -d "$PWD/target/commands.XXXXXX")
trap 'rm -rf "$work"' EXIT
faults=0

native() { # PATH
  if [[ -n ${LODESTAR_TEST_PATH:-} ]]; then "$LODESTAR_TEST_PATH" "$1"; elif command -v cygpath >/dev/null; then cygpath -w "$1"; else printf '%s\n' "$1"; fi
}

# Runs one test, which fails if one of its commands does. Bash ignores `set -e` in the condition of an `if`.
check() { # NAME FUNCTION
  local status
  set +e
  (set -e; "$2") >"$work/log" 2>&1
  status=$?
  set -e
  if [[ $status -eq 0 ]]; then
    echo "ok    $1"
  else
    faults=$((faults + 1))
    echo "FAULT $1"
    tail -5 "$work/log" | sed 's/^/      /'
  fi
}

render() { "$binary" render --width 32 --height 32 --spp 4 --quiet "$@"; }
is_picture() { [[ -s $1 && $(head -c 4 "$1" | od -An -tx1 | tr -d ' \n') =~ ^(89504e47|762f3101)$ ]]; }
# Runs a command that must end with this exit code.
ends_with() { # CODE COMMAND...
  local code=0
  "${@:2}" || code=$?
  [[ $code -eq $1 ]]
}

says_its_version() { "$binary" --version | grep -Eq '^lodestar [0-9]+\.[0-9]+'; }
tells_about_a_scene() { "$binary" info scenes/cornell-box/scene.xml | grep -qi triangles; }
lists_devices() { "$binary" devices | grep -q .; }
takes_relative_paths() { render scenes/cornell-box/scene.xml -o "${work#"$PWD"/}/relative.png" && is_picture "$work/relative.png"; }
takes_absolute_paths() { render "$(native "$scene/scene.xml")" -o "$(native "$work/absolute.exr")" && is_picture "$work/absolute.exr"; }

takes_spaces_and_unicode() {
  local folder="$work/ein Ordner, 部屋 é"
  mkdir "$folder"
  cp -r "$scene/." "$folder"
  render "$(native "$folder/scene.xml")" -o "$(native "$folder/Bild 絵.png")"
  is_picture "$folder/Bild 絵.png"
}

takes_long_paths() {
  local folder=$work/long n
  for n in 1 2 3 4 5 6; do folder=$folder/0123456789012345678901234567890123456789012345678; done
  mkdir -p "$folder"
  render "$(native "$scene/scene.xml")" -o "$(native "$folder/picture.png")"
  is_picture "$folder/picture.png"
}

replaces_files() {
  local old
  render "$(native "$scene/scene.xml")" -o "$(native "$work/again.png")"
  old=$(cksum <"$work/again.png")
  # A reader that has the file open keeps the old one.
  exec 5<"$work/again.png"
  render "$(native "$scene/scene.xml")" --seed 2 -o "$(native "$work/again.png")"
  [[ $(cksum <&5) == "$old" && $(cksum <"$work/again.png") != "$old" ]]
  [[ -z $(find "$work" -name '*.part') ]]
}

resumes() {
  local checkpoint
  checkpoint=$(native "$work/night.ckpt")
  render "$(native "$scene/scene.xml")" --checkpoint "$checkpoint" -o "$(native "$work/first.exr")"
  "$binary" resume "$checkpoint" --spp 12 --quiet -o "$(native "$work/whole.exr")"
  is_picture "$work/whole.exr" && ! cmp -s "$work/first.exr" "$work/whole.exr"
}

shows_the_page() {
  local url='' n
  "$binary" render scenes/cornell-box/scene.xml --width 32 --height 32 --time 15 --quiet --view 127.0.0.1:0 \
    -o "$(native "$work/view.png")" >"$work/view.log" 2>&1 &
  for n in $(seq 100); do
    url=$(grep -o 'http://127.0.0.1:[0-9]*' "$work/view.log" | head -1 || true)
    [[ -z $url ]] || break
    sleep 0.3
  done
  curl --silent --show-error --fail --max-time 10 "$url/" | grep -qi '<html'
  wait $!
  is_picture "$work/view.png"
}

refuses_in_a_sentence() {
  ends_with 2 "$binary" render
  ends_with 1 "$binary" render "$(native "$work/none.xml")" 2>"$work/refusal"
  grep -q none.xml "$work/refusal"
  ends_with 1 render "$(native "$scene/scene.xml")" -o "$(native "$work/none/a.png")" 2>"$work/refusal"
  grep -q mkdir "$work/refusal"
}

check "--version" says_its_version
check "info" tells_about_a_scene
check "devices" lists_devices
check "relative paths" takes_relative_paths
check "absolute paths" takes_absolute_paths
check "spaces and Unicode in paths" takes_spaces_and_unicode
check "paths of more than 260 characters" takes_long_paths
check "a file that is open is replaced" replaces_files
check "checkpoint and resume" resumes
check "the page of --view" shows_the_page
check "refusals and exit codes" refuses_in_a_sentence
[[ $faults -eq 0 ]] || { echo "$faults faults"; exit 1; }
