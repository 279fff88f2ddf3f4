#!/bin/sh
# Writes the pictures of the documents to docs/pictures: the shared scenes rendered well, the same scenes by three methods at
# equal time, and a plot of the error over time. Writes docs/gallery.md, the page that shows them.
#
# usage: LODESTAR_SCENES=DIR LODESTAR_REFERENCES=DIR benches/pictures.sh [DOCS]
#
# Environment variables:
#   SECONDS_WELL   seconds for each picture that is rendered well (50; the three pictures of door-ajar take 2.7 times as long)
#   SECONDS_EACH   seconds for each method and scene at equal time (10)
#   SCENES         shared scenes, by name (all)
# With the defaults it takes about 25 minutes on two cores that do nothing else. If Python has Mitsuba, Mitsuba takes part. If
# Mitsuba fails with an error of LLVM, name a newer library in DRJIT_LIBLLVM_PATH.
set -eu

cd "$(dirname "$0")/.."
: "${LODESTAR_SCENES:?names no folder with the shared scenes}"
: "${LODESTAR_REFERENCES:?names no folder with the reference pictures}"
docs=${1:-docs}
scenes=${SCENES:-kitchen living-room living-room-2 living-room-3 bathroom bathroom2 staircase staircase2 cornell-box \
  cornell-box-hard veach-ajar veach-ajar-2}
seconds_each=${SECONDS_EACH:-10}
mkdir -p "$docs/pictures"
pictures=$(cd "$docs/pictures" && pwd)
export LODESTAR_OUT="$pictures"
build="commit $(git rev-parse --short HEAD), $(date -u +%Y-%m-%d)"

# Title, author and licence of a scene, as a caption. All are from Benedikt Bitterli's rendering resources.
credit() { # SCENE
  by='[CC BY 3.0](https://creativecommons.org/licenses/by/3.0/)'
  free='[CC0](https://creativecommons.org/publicdomain/zero/1.0/)'
  swap=https://www.blendswap.com/blends/view
  case "$1" in
    kitchen) echo "[Country Kitchen]($swap/42851) by Jay-Artist ($by)" ;;
    living-room) echo "[The Grey & White Room]($swap/75795) by Wig42 ($by)" ;;
    living-room-2) echo "[The White Room]($swap/41683) by Jay-Artist ($by)" ;;
    living-room-3) echo "[The Modern Living Room]($swap/75692) by Wig42 ($by)" ;;
    bathroom) echo "[Contemporary Bathroom]($swap/75302) by Mareck ($free)" ;;
    bathroom2) echo "[Salle de bain]($swap/73937) by nacimus ($by)" ;;
    staircase) echo "[The Wooden Staircase]($swap/77668) by Wig42 ($by)" ;;
    staircase2) echo "[Modern Hall]($swap/51997) by NewSee2l035 ($by)" ;;
    cornell-box) echo "Cornell Box by Benedikt Bitterli ($free)" ;;
    cornell-box-hard) echo "Cornell Box by Benedikt Bitterli ($free), with the lamp behind a shade" ;;
    veach-ajar) echo "Veach, Ajar by Benedikt Bitterli ($free)" ;;
    veach-ajar-2) echo "Veach, Ajar by Benedikt Bitterli ($free), with the door nearly shut" ;;
    *) echo "$1" ;;
  esac
}

# One row of pictures at equal time, of the methods that have one.
row_at_equal_time() { # SCENE
  for method in bsdf-emitters-sampled product-emitters-sampled mitsuba-path; do
    if [ -e "$pictures/$1-$method.jpg" ]; then printf '| ![%s, %s](pictures/%s-%s.jpg) ' "$1" "$method" "$1" "$method"; fi
  done
  echo "|"
}

page() {
  cat <<END
# Gallery

For everybody who wants to see pictures before figures. After this page you can make them again.

One command writes this page with its pictures and its plot: see [The command](#the-command). The scenes are those of the paper, from
Benedikt Bitterli's [rendering resources](https://benedikt-bitterli.me/resources/). These pictures are of $build.

## The scenes

Rendered with the default settings, 400 pixels along the longer side.

| | |
|---|---|
END
  for scene in $scenes; do echo "| ![$scene](pictures/$scene.jpg) | $(credit "$scene") |"; done
  cat <<END

## The same time

Each picture of a row got $seconds_each s, with emitter sampling: plain path tracing (\`--sampler bsdf\`), Lodestar's default
(\`product\`), and Mitsuba 3's \`path\` where Mitsuba took part. A step or a pass that has begun in time is finished. Mitsuba's
passes are long, so it took more time than it got: the [figures](pictures/error-over-time.csv) have the seconds that each method took.
The sizes are those of the references.

| plain path tracing | the default |$mitsuba_title
|---|---|$mitsuba_line
END
  for scene in $scenes; do row_at_equal_time "$scene"; done
  cat <<END

## Error over time

![error over time](pictures/error-over-time.svg)

The [figures behind the plot](pictures/error-over-time.csv) begin with the build and the device. A step or a pass that has begun in time
is finished, so a point can lie to the right of the time that was asked for. [Error at equal time](lab-notes/equal-time.md) has the
tables of longer runs.

## A door ajar

\`scenes/door-ajar\` of this project: about one path in 250 finds the lamp in the other room. Without emitter sampling: a plain path
tracer, the paper's sampler (\`--sampler rejection-mix --max-tries 31\`) after the same time, and the latter after seven times the time.

| plain path tracing | guided | guided, seven times the time |
|---|---|---|
| ![much noise](pictures/door-ajar-bsdf.jpg) | ![less noise](pictures/door-ajar-guided.jpg) | ![little noise](pictures/door-ajar-converged.jpg) |

## The command

\`\`\`sh
LODESTAR_SCENES=SCENES LODESTAR_REFERENCES=REFERENCES benches/pictures.sh
\`\`\`

It takes about 25 minutes on two cores that do nothing else. The folders are those of
[Reproducing the paper](reproduce.md#input-files). The script says how to shorten it. Mitsuba takes part if Python has it.
END
}

# Word splitting is intended: each scene becomes one argument.
# shellcheck disable=SC2086
LODESTAR_SECONDS=${SECONDS_WELL:-50} cargo bench --bench pictures -- door-ajar $scenes
# shellcheck disable=SC2086
LODESTAR_SECONDS=$seconds_each LODESTAR_METHODS='bsdf, emitters sampled;product, emitters sampled;Mitsuba path' \
  cargo bench --bench equal_time -- $scenes

{
  echo "# $build"
  cat "$pictures/errors.csv"
} >"$pictures/error-over-time.csv"
rm "$pictures/errors.csv"
mitsuba_title=
mitsuba_line=
if [ -n "$(find "$pictures" -name '*-mitsuba-path.jpg')" ]; then
  mitsuba_title=' Mitsuba 3 |'
  mitsuba_line='---|'
fi
page >"$docs/gallery.md"
echo "$(find "$pictures" -name '*.jpg' | wc -l) pictures in $pictures, shown by $docs/gallery.md"
