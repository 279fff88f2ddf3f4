#!/bin/sh
# Writes the pictures of the documents to docs/pictures: the shared scenes rendered well, the same scenes by three methods at
# equal time, and a plot of the error over time.
#
# usage: LODESTAR_SCENES=DIR LODESTAR_REFERENCES=DIR benches/pictures.sh [OUT]
#
# Environment variables:
#   SECONDS_WELL   seconds for each picture that is rendered well (50; the three pictures of door-ajar take 2.7 times as long)
#   SECONDS_EACH   seconds for each method and scene at equal time (10)
#   METHODS        methods at equal time, those of benches/equal_time.rs
#   SCENES         shared scenes, by name (all)
# With the defaults it takes about 25 minutes on two cores that do nothing else. If Python has Mitsuba, Mitsuba takes part.
set -eu

cd "$(dirname "$0")/.."
: "${LODESTAR_SCENES:?names no folder with the shared scenes}"
: "${LODESTAR_REFERENCES:?names no folder with the reference pictures}"
out=${1:-docs/pictures}
mkdir -p "$out"
out=$(cd "$out" && pwd)
export LODESTAR_OUT="$out"

# Word splitting is intended: each scene becomes one argument.
# shellcheck disable=SC2086
LODESTAR_SECONDS=${SECONDS_WELL:-50} cargo bench --bench pictures -- ${SCENES:+door-ajar} ${SCENES:-}
# shellcheck disable=SC2086
LODESTAR_SECONDS=${SECONDS_EACH:-10} \
  LODESTAR_METHODS=${METHODS:-bsdf, emitters sampled;product, emitters sampled;Mitsuba path} \
  cargo bench --bench equal_time -- ${SCENES:-}

# The figures behind the plot, with the build that made them.
{
  echo "# commit $(git rev-parse --short HEAD), $(date -u +%Y-%m-%d)"
  cat "$out/errors.csv"
} >"$out/error-over-time.csv"
rm "$out/errors.csv"
echo "$(find "$out" -name '*.jpg' | wc -l) pictures, $(du -cb "$out"/*.jpg | tail -1 | cut -f 1) bytes, in $out"
