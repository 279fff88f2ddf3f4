#!/usr/bin/env bash
# Prints compiler flags that keep the paths of this machine out of a program: folders of the sources, of cargo and of the compiler
# get short names. Use it as CARGO_ENCODED_RUSTFLAGS=$(packages/remap.sh).
#
#   packages/remap.sh                    prints the flags
#   packages/remap.sh --check FILE...    fails if a file contains one of the paths
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
folders=("$(rustc --print sysroot)=rust" "${CARGO_HOME:-$HOME/.cargo}=cargo" "$root=lodestar")
[[ -z ${CARGO_TARGET_DIR:-} ]] || folders+=("$(realpath -m "$CARGO_TARGET_DIR")=target")
# The folder in which cargo builds is named last, because the last name that fits counts.
[[ $PWD == "$root" ]] || folders+=("$PWD=lodestar")

if [[ ${1:-} == --check ]]; then
  shift
  for folder in "${folders[@]}"; do
    path=${folder%=*}/
    if count=$(cat "$@" | grep --text --only-matching --fixed-strings "$path" | wc -l) && ((count > 0)); then
      echo "remap.sh: $* contains the path $path $count times" >&2
      exit 1
    fi
  done
  exit 0
fi
separator=
for folder in "${folders[@]}"; do
  printf '%s--remap-path-prefix=%s' "$separator" "$folder"
  separator=$'\x1f'
done
