#!/usr/bin/env bash
# Renders one part of a picture.
#
#   farm/part.sh SCENE PICTURE.exr PART
#
# PART counts from 0. The part holds SPP samples per pixel: PART * SPP and the following ones. Its picture is
# PICTURE.parts/NUMBER.exr. A part that was interrupted goes on from its checkpoint, and one that is complete ends at once, so a
# farm may run a part again. A checkpoint that another scene, another SPP or other OPTIONS have left there is refused: remove the
# folder PICTURE.parts, or name another picture.
#
# Variables: SPP (256) samples per pixel of each part, a multiple of --spp-per-step; OPTIONS, options of `lodestar render` with
# blanks between them; GUIDE, a file of --guide-out or a checkpoint of another render, with whose guide the part begins; LODESTAR (lodestar),
# the program.
set -euo pipefail

[[ $# -eq 3 ]] || { sed -n '4p' "$0" | sed 's/^# *//' >&2; exit 2; }
scene=$1 parts=${2%.exr}.parts part=$3
spp=${SPP:-256} lodestar=${LODESTAR:-lodestar}
read -ra options <<<"${OPTIONS:-}"
[[ -z ${GUIDE:-} ]] || options+=(--guide "$GUIDE")

mkdir -p "$parts"
name=$parts/$(printf %06d "$part")
# With a checkpoint of this very part, the command goes on from there.
exec "$lodestar" render "$scene" "${options[@]}" --spp "$spp" --sample-offset $((part * spp)) --checkpoint "$name.ckpt" -o "$name.exr"
