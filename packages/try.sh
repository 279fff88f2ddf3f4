#!/usr/bin/env bash
# Installs the tarball and the .deb of packages/build.sh in clean Debian roots, and renders a picture in each.
#
# usage: packages/try.sh [OUT [SUITE]]    OUT: the folder of packages/build.sh (target/packages); SUITE: bookworm
#
# Pictures go to OUT/tried-deb.png and OUT/tried-tarball.png. The roots go to a temporary folder and are removed again.
# It needs root, debootstrap, and Debian's package mirror.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=$(cd "${1:-$root/target/packages}" && pwd)
suite=${2:-bookworm}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

fail() { echo "try.sh: error: $*" >&2; exit 1; }
say() { echo "try.sh: $*"; }

[[ $(id -u) -eq 0 ]] || fail "a clean root needs chroot, which needs root"
command -v debootstrap >/dev/null || fail "debootstrap is missing; install the package debootstrap"
tarball=$(echo "$out"/lodestar-*-x86_64-linux.tar.gz)
deb=$(echo "$out"/lodestar_*_amd64.deb)
[[ -f $tarball && -f $deb ]] || fail "$out lacks a tarball or a .deb; run packages/build.sh"

inside() { # ROOT COMMAND...
  local at=$1
  shift
  env --ignore-environment PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive LC_ALL=C chroot "$at" "$@"
}

install() { # ROOT PACKAGE...
  local at=$1
  shift
  inside "$at" apt-get -qq install -y --no-install-recommends "$@" >"$folder/apt.log" 2>&1 || {
    cat "$folder/apt.log" >&2
    fail "apt-get cannot install $*"
  }
}

say "a root of $suite"
debootstrap --variant=minbase "$suite" "$folder/plain" >"$folder/debootstrap.log" 2>&1 || {
  tail "$folder/debootstrap.log" >&2
  fail "debootstrap failed"
}
inside "$folder/plain" apt-get -qq update
cp -a "$folder/plain" "$folder/deb"
mv "$folder/plain" "$folder/tarball"

render() { # ROOT SCENE PICTURE COMMAND
  inside "$1" "$4" devices
  inside "$1" "$4" render "$2" --spp 64 --seed 1 --quiet -o /tmp/picture.exr -o /tmp/picture.png
  cp "$1/tmp/picture.png" "$3"
}

say "the .deb"
cp "$deb" "$folder/deb/tmp/lodestar.deb"
install "$folder/deb" /tmp/lodestar.deb mesa-vulkan-drivers
inside "$folder/deb" dpkg --status lodestar
inside "$folder/deb" dpkg --listfiles lodestar | sort
render "$folder/deb" /usr/share/lodestar/scenes/cornell-box/scene.xml "$out/tried-deb.png" lodestar

say "the tarball"
install "$folder/tarball" libvulkan1 mesa-vulkan-drivers
tar --extract --gzip --file "$tarball" --directory "$folder/tarball/opt"
home=/opt/$(basename "$tarball" .tar.gz)
render "$folder/tarball" "$home/share/lodestar/scenes/cornell-box/scene.xml" "$out/tried-tarball.png" "$home/bin/lodestar"

cmp "$out/tried-deb.png" "$out/tried-tarball.png" || fail "the two packages render different pictures"
say "both packages render the same picture: $out/tried-deb.png"
