#!/usr/bin/env bash
# Merges the parts of a picture that farm/part.sh has rendered.
#
#   farm/merge.sh PICTURE.exr PARTS
#
# It fails if one of the PARTS parts is missing. LODESTAR (lodestar) is the program.
set -euo pipefail

[[ $# -eq 2 ]] || { sed -n '4p' "$0" | sed 's/^# *//' >&2; exit 2; }
picture=$1 parts=()
for ((part = 0; part < $2; part++)); do
  parts+=("${picture%.exr}.parts/$(printf %06d "$part").exr")
done
if [[ ${#parts[@]} -eq 1 ]]; then
  # The picture appears as a whole.
  cp "${parts[0]}" "$picture.$$.part"
  exec mv "$picture.$$.part" "$picture"
fi
exec "${LODESTAR:-lodestar}" merge "${parts[@]}" -o "$picture"
