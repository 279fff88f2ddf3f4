#!/usr/bin/env bash
# Builds the packages of a release from the published crate: a tarball and a .deb for x86_64 Linux with glibc 2.31 or newer.
#
# usage: packages/build.sh [--compare] [OUT]    writes into OUT (target/packages):
#          lodestar-render-VERSION.crate
#          lodestar-VERSION-x86_64-linux.tar.gz
#          lodestar_VERSION-1_amd64.deb
#          lodestar_render-VERSION-*.whl
#        --compare  first compare the crate's kernels with freshly compiled ones
#
# It needs cargo-zigbuild and zig (`pip install cargo-zigbuild ziglang`) and cargo-deb (`cargo install cargo-deb`), and zstd.
# packages/try.sh installs the results in clean roots and renders there.
set -euo pipefail

GLIBC=2.31
TARGET=x86_64-unknown-linux-gnu

compare=0
if [[ ${1:-} == --compare ]]; then
  compare=1
  shift
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mkdir -p "${1:-$root/target/packages}"
out=$(cd "${1:-$root/target/packages}" && pwd)

fail() { echo "build.sh: error: $*" >&2; exit 1; }
say() { echo "build.sh: $*"; }

for tool in cargo-zigbuild cargo-deb; do
  command -v "$tool" >/dev/null || fail "$tool is missing; the head of this script says how to install it"
done

# Removes what an earlier run made.
rm -rf "$out"/source "$out"/lodestar[-_]*
"$root/packages/crate.sh" "$out"
mkdir "$out/source"
# Cargo takes files for unchanged if their times are old, and all files in a crate have one old time.
tar --extract --touch --gzip --file "$(echo "$out"/lodestar-render-*.crate)" --directory "$out/source" --strip-components=1
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' "$out/source/Cargo.toml" | head -1)

export CARGO_TARGET_DIR=$out/build
cd "$out/source"
if cargo tree --locked --edges normal,build | grep -q shaderc; then fail "the published crate needs shaderc"; fi
if ((compare)); then
  # The kernels of the checkout and those of the crate are compiled by the same shaderc.
  say "comparing the crate's kernels with freshly compiled ones"
  SHADERC_LIB_DIR=${SHADERC_LIB_DIR:-$root/.shaderc} cargo test --release --quiet --features shaderc --test shipped
fi
say "building the program from the crate"
CARGO_ENCODED_RUSTFLAGS=$("$root/packages/remap.sh")
export CARGO_ENCODED_RUSTFLAGS
CARGO_PROFILE_RELEASE_DEBUG=0 CARGO_PROFILE_RELEASE_STRIP=symbols \
  cargo zigbuild --release --quiet --locked --target "$TARGET.$GLIBC" --bin lodestar
program=$CARGO_TARGET_DIR/$TARGET/release/lodestar
"$root/packages/remap.sh" --check "$program" || fail "the program tells where it was built"
say "building the wheel"
(cd "$root" && CARGO_ENCODED_RUSTFLAGS=$("$root/packages/remap.sh") pip wheel --quiet --no-deps ./python -w "$out")
wheel=$(echo "$out"/lodestar_render-*.whl)
unzip -p "$wheel" '*.so' >"$out/wheel.so"
(cd "$root" && packages/remap.sh --check "$out/wheel.so") || fail "the wheel tells where it was built"
rm "$out/wheel.so"
unzip -l "$wheel" | grep -q licenses/LICENSES-OF-DEPENDENCIES.txt || fail "the wheel lacks the licenses of what it links"
unset CARGO_TARGET_DIR CARGO_ENCODED_RUSTFLAGS

needed=$(objdump --dynamic-syms "$program" | grep -o 'GLIBC_[0-9.]*' | sort --version-sort --unique | tail -1)
highest=$(printf '%s\n' "$needed" "GLIBC_$GLIBC" | sort --version-sort | tail -1)
[[ $highest == "GLIBC_$GLIBC" ]] || fail "the program needs $needed, more than $GLIBC"
say "the program needs $needed"

# The files of both packages, as below /usr.
dist=$out/source/dist
share=$dist/share
mkdir -p "$dist/bin" "$share/man/man1" "$share/bash-completion/completions" "$share/zsh/vendor-completions" \
  "$share/fish/vendor_completions.d" "$share/doc/lodestar" "$share/lodestar/scenes"
cp "$program" "$dist/bin"
(cd "$root" && LODESTAR_WRITE_MANUAL=$share/man/man1 cargo test --release --quiet --lib manual)
"$program" completions bash >"$share/bash-completion/completions/lodestar"
"$program" completions zsh >"$share/zsh/vendor-completions/_lodestar"
"$program" completions fish >"$share/fish/vendor_completions.d/lodestar.fish"
cp README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$share/doc/lodestar"
"$root/packages/licenses.py" Cargo.toml "$TARGET" >"$share/doc/lodestar/LICENSES-OF-DEPENDENCIES.txt"
cp -r scenes/cornell-box "$share/lodestar/scenes"

name=lodestar-$version-x86_64-linux
tar --create --gzip --file "$out/$name.tar.gz" --directory "$dist" --transform "s|^\.|$name|" --sort=name --owner=0 --group=0 \
  --numeric-owner --mtime=@"${SOURCE_DATE_EPOCH:-$(git -C "$root" log -1 --format=%ct)}" .
cargo deb --quiet --no-build --no-strip --target "$TARGET" --output "$out/lodestar_$version-1_amd64.deb"

rm -rf "$out/source" "$out/stage"
ls -l "$out"/lodestar[-_]*
