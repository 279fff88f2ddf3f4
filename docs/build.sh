#!/bin/sh
# Builds the book of docs/ as HTML in target/book, and prints the path of its first page. mdbook is installed into
# target/tools if it is missing. The tests in tests/hygiene check the links.
#
# usage: docs/build.sh
set -eu

cd "$(dirname "$0")/.."
mdbook=$(./setup.sh --book)
"$mdbook" build
echo "$(pwd)/target/book/index.html"
