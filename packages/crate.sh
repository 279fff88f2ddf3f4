#!/usr/bin/env bash
# Makes the crate that is published as lodestar-render. It contains the compiled kernels, so it builds without shaderc.
#
# usage: packages/crate.sh [OUT]    writes OUT/lodestar-render-VERSION.crate (OUT: target/packages)
#
# The crate is made from a copy of the checkout's tracked files, in OUT/stage. Two things differ there: the folder spirv
# has the kernels, compressed by zstd, and the feature shaderc is not a default. To publish, run `cargo publish` in OUT/stage.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mkdir -p "${1:-$root/target/packages}"
out=$(cd "${1:-$root/target/packages}" && pwd)
cd "$root"

fail() { echo "crate.sh: error: $*" >&2; exit 1; }

command -v zstd >/dev/null || fail "zstd is missing, which compresses the kernels"

# Prints the folder into which the build script wrote the compiled kernels.
kernel_folder() {
  cargo check --release --quiet --lib --message-format=json-render-diagnostics |
    sed -n '/"reason":"build-script-executed"/ { /lodestar-render/ s/.*"out_dir":"\([^"]*\)".*/\1/p }'
}

kernels=$(kernel_folder)
[[ -d $kernels ]] || fail "cargo did not say where the compiled kernels are"

rm -rf "$out/stage"
mkdir -p "$out/stage/spirv"
git ls-files -z --deduplicate | tar --create --null --files-from=- | tar --extract --directory "$out/stage"
# The kernels are compressed together, because the back ends of a kernel have most of their code in common.
(
  cd "$kernels"
  mapfile -t files < <(ls -- *.spv | grep -v '^test\.')
  stat --format='%n %s' -- "${files[@]}" >"$out/stage/spirv/kernels.txt"
  cat -- "${files[@]}" >"$out/stage/kernels"
)
zstd --quiet --ultra -22 --long=26 --rm "$out/stage/kernels" -o "$out/stage/spirv/kernels.zst"
cp "$kernels/fingerprint" "$out/stage/spirv"

manifest=$out/stage/Cargo.toml
sed -i.old 's/^default = \["cli", "shaderc"\]$/default = ["cli"]/' "$manifest"
grep -q '^default = \["cli"\]$' "$manifest" || fail 'Cargo.toml has no line: default = ["cli", "shaderc"]'
rm "$manifest.old"

# packages/build.sh builds the unpacked crate, so cargo need not.
cargo package --quiet --no-verify --allow-dirty --manifest-path "$manifest" --package lodestar-render --target-dir "$out/package"
mv "$out"/package/package/lodestar-render-*.crate "$out"
rm -rf "$out/package"
bytes=$(wc -c <"$(echo "$out"/lodestar-render-*.crate)")
[[ $bytes -le 10485760 ]] || fail "the crate has $bytes bytes, but crates.io accepts at most 10485760"
echo "crate.sh: $(echo "$out"/lodestar-render-*.crate), $bytes bytes"
