#!/usr/bin/env bash
# Builds the program for Windows, and tests it under Wine beside the program for Linux: the command line, and the bits of pictures.
#
# usage: tests/windows.sh [LINUX_BINARY]   (default: target/release/lodestar)
#
# It needs Debian's packages rustc-web, rust-web-src, gcc-mingw-w64-x86-64, wine, xvfb and curl. Where one is missing it says so in a sentence and
# ends with 0; it installs nothing. Both programs render with lavapipe, which Wine's Vulkan reaches through an X server.
#
# This is Wine on Linux. No real Windows and no GPU there have been tried.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

linux=${1:-target/release/lodestar}
for tool in x86_64-w64-mingw32-gcc wine Xvfb curl; do
  command -v "$tool" >/dev/null || { echo "skipped: $tool is missing; the head of tests/windows.sh names the packages"; exit 0; }
done
rustc=/usr/bin/rustc
source=$($rustc --print sysroot 2>/dev/null || true)/lib/rustlib/src/rust/library
[[ -d $source ]] || { echo "skipped: rustc-web and rust-web-src are missing, which build Rust's library for Windows"; exit 0; }
[[ -x $linux ]] || { echo "tests/windows.sh: $linux is missing; run cargo build --release" >&2; exit 1; }

# Ten configurations of tests/same_bits.sh: samplers, emitter sampling off, both executions, a pattern, merged parts, resume, PNG files.
BITS='product|bsdf|rejection-mix|product-no-nee|blue-noise|megakernel-slices|wavefront|merge|resume|png'

folder=$PWD/target/windows
mkdir -p "$folder"
# Debian's compiler is a stable one, which RUSTC_BOOTSTRAP lets build the library.
RUSTC=$rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR=$folder CARGO_PROFILE_RELEASE_DEBUG=0 \
  CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=x86_64-w64-mingw32-gcc \
  cargo build --release -Zbuild-std --target x86_64-pc-windows-gnu --bin lodestar
program=$folder/x86_64-pc-windows-gnu/release/lodestar.exe

# Wine 8 lacks a library of Windows 10 from which Rust takes random bytes. This one stands beside the program, for Wine only.
cat >"$folder/bcryptprimitives.c" <<'END'
#include <stddef.h>
__declspec(dllimport) unsigned char __stdcall SystemFunction036(void *, unsigned long);
__declspec(dllexport) int __stdcall ProcessPrng(unsigned char *bytes, size_t count) { return SystemFunction036(bytes, (unsigned long)count); }
END
x86_64-w64-mingw32-gcc -shared -o "$(dirname "$program")/bcryptprimitives.dll" "$folder/bcryptprimitives.c" -ladvapi32

# A display of our own, whose number the X server writes.
exec 3> >(cat >"$folder/display")
Xvfb -displayfd 3 -screen 0 640x480x24 -nolisten tcp >"$folder/xvfb.log" 2>&1 &
server=$!
trap 'WINEPREFIX=$folder/prefix wineserver -k 2>/dev/null; kill $server 2>/dev/null' EXIT
exec 3>&-
for _ in $(seq 50); do [[ -s $folder/display ]] && break; sleep 0.2; done
[[ -s $folder/display ]] || { cat "$folder/xvfb.log" >&2; exit 1; }

# Wine shows the root of Linux as drive Z. It takes arguments for Unicode where the locale is UTF-8.
cat >"$folder/lodestar" <<END
#!/bin/sh
export WINEPREFIX='$folder/prefix' WINEDEBUG=-all DISPLAY=:$(tr -d ' \n' <"$folder/display") WINEDLLOVERRIDES='mscoree,mshtml=' LC_ALL=C.UTF-8
exec wine '$program' "\$@"
END
cat >"$folder/path" <<'END'
#!/bin/sh
printf 'Z:%s\n' "$(printf '%s' "$1" | tr / '\\')"
END
chmod +x "$folder/lodestar" "$folder/path"

"$folder/lodestar" devices
LODESTAR_TEST_PATH=$folder/path tests/commands.sh "$folder/lodestar"
tests/same_bits.sh --only "$BITS" "$linux" "$folder/lodestar"
