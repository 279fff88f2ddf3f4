#!/bin/sh
# Installs the system packages that Lodestar needs:
#   - the Vulkan loader, and Mesa's Vulkan drivers, including lavapipe, which renders on the CPU;
#   - the validation layers, which the tests turn on;
#   - SPIRV-Tools, for `lodestar inspect`;
#   - the shader compiler shaderc.
# If the distribution has a shaderc that links, it is put into the folder .shaderc, where cargo finds it
# (.cargo/config.toml). Otherwise cargo builds shaderc from source, which takes about ten minutes of processor time, and
# this script installs the tools for that build.
# The script can be run again: it installs only missing packages and leaves installed ones alone.
#
# usage: setup.sh            install missing packages
#        setup.sh --check    only list missing tools; exit 1 if any is missing
#        setup.sh --source-tools
#                            install also the tools that build shaderc from source, for a test that compares both builds
#        setup.sh --swiftshader [DIR]
#                            unpack SwiftShader, a second Vulkan driver for the CPU, into DIR (target/swiftshader) for
#                            tests, and print the path for VK_DRIVER_FILES. Nothing is installed. Works on Debian only,
#                            because SwiftShader comes from Debian's Chromium package.
#        setup.sh --mesa [DIR]
#                            unpack the Mesa of Debian's backports into DIR (target/mesa), beside the system's, and print the
#                            path for VK_DRIVER_FILES. Nothing is installed. Works where the system is a Debian release
#                            that has backports, such as Debian 12.
#        setup.sh --chromium install Chromium, in which a test opens the page of `--view`
#        setup.sh --mpi      install Open MPI and libclang, with which `cargo build --release --features mpi` builds
#        setup.sh --slurm    install Slurm's daemons, which tests/farm/run.sh starts (Debian only)
#        setup.sh --oidn [DIR]
#                            unpack Intel's Open Image Denoise, which `lodestar denoise` loads, into DIR (target/oidn, where the
#                            program finds it), and print the folder. The official build of version 2.5.1 comes in the Python
#                            package pyoidn: 90 MB to download, 100 MB to keep. Needs Python with pip.
#        setup.sh --book     install mdbook, which builds the book of docs/, into target/tools unless it is there, and print
#                            its path. It is compiled from source: about 90 s of processor time.
set -eu

MIN_RUST=1.89
# Folder where cargo looks for shaderc; see .cargo/config.toml.
SHADERC_FOLDER="$(cd "$(dirname "$0")" && pwd)/.shaderc"

say() { echo "setup: $*"; }
fail() { echo "setup: error: $*" >&2; exit 1; }

# --- Installed tools ---------------------------------------------------------------------------------------------------

has_command() { command -v "$1" >/dev/null 2>&1; }

# Succeeds if a file that matches NAME exists in the folder SUB of a folder that the Vulkan loader searches.
has_vulkan_file() { # SUB NAME
  for folder in /usr/share/vulkan /usr/local/share/vulkan /etc/vulkan /opt/homebrew/share/vulkan \
    /opt/homebrew/etc/vulkan /usr/local/etc/vulkan; do
    for file in "$folder/$1"/$2; do
      if [ -e "$file" ]; then return 0; fi
    done
  done
  return 1
}

has_loader() {
  case "$system" in
    macos) [ -e /opt/homebrew/lib/libvulkan.1.dylib ] || [ -e /usr/local/lib/libvulkan.1.dylib ] ;;
    # ldconfig is often missing from an ordinary user's PATH.
    *) PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep -q 'libvulkan\.so\.1' ;;
  esac
}

has_driver() {
  case "$system" in
    macos) has_vulkan_file icd.d 'MoltenVK_icd.json' ;;
    *) has_vulkan_file icd.d 'lvp_icd*.json' ;;
  esac
}

has_layers() { has_vulkan_file explicit_layer.d 'VkLayer_khronos_validation.json'; }
has_compiler() { has_command c++ || has_command g++ || has_command clang++; }

has_tool() { # TOOL
  case "$1" in
    loader) has_loader ;;
    driver) has_driver ;;
    layers) has_layers ;;
    compiler) has_compiler ;;
    spirv-tools) has_command spirv-dis && has_command spirv-opt && has_command spirv-val ;;
    *) has_command "$1" ;;
  esac
}

# --- Names of tools and packages ---------------------------------------------------------------------------------------

TOOLS="loader driver layers compiler spirv-tools"
# Tools that build shaderc from source.
SOURCE_TOOLS="cmake ninja python3 git"

describe() { # TOOL
  case "$1" in
    loader) echo "the Vulkan loader" ;;
    driver) if [ "$system" = macos ]; then echo "MoltenVK"; else echo "Mesa's Vulkan drivers"; fi ;;
    layers) echo "the Vulkan validation layers" ;;
    compiler) echo "a C++ compiler" ;;
    spirv-tools) echo "SPIRV-Tools" ;;
    *) echo "$1" ;;
  esac
}

package_of() { # TOOL
  case "$system:$1" in
    debian:loader) echo libvulkan1 ;;
    debian:driver) echo mesa-vulkan-drivers ;;
    debian:layers) echo vulkan-validationlayers ;;
    debian:compiler) echo g++ ;;
    debian:ninja) echo ninja-build ;;
    fedora:loader) echo vulkan-loader ;;
    fedora:driver) echo mesa-vulkan-drivers ;;
    fedora:layers) echo vulkan-validation-layers ;;
    fedora:compiler) echo gcc-c++ ;;
    fedora:ninja) echo ninja-build ;;
    arch:loader) echo vulkan-icd-loader ;;
    arch:driver) echo vulkan-swrast ;;
    arch:layers) echo vulkan-validation-layers ;;
    arch:compiler) echo gcc ;;
    arch:python3) echo python ;;
    macos:loader) echo vulkan-loader ;;
    macos:driver) echo molten-vk ;;
    macos:layers) echo vulkan-validationlayers ;;
    macos:compiler) echo xcode ;;
    *) echo "$1" ;;
  esac
}

detect_system() {
  if [ "$(uname -s)" = Darwin ]; then echo macos
  elif has_command apt-get; then echo debian
  elif has_command dnf; then echo fedora
  elif has_command pacman; then echo arch
  else echo unknown
  fi
}

# --- Installing --------------------------------------------------------------------------------------------------------

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"
  elif has_command sudo; then sudo "$@"
  else fail "installing packages needs root, and sudo is missing; run as root: $*"
  fi
}

install_packages() { # PACKAGE...
  case "$system" in
    debian)
      as_root apt-get update
      as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@"
      ;;
    fedora) as_root dnf install -y "$@" ;;
    arch) as_root pacman -S --needed --noconfirm "$@" ;;
    macos)
      has_command brew || fail "Homebrew is missing; install it from brew.sh, then run this script again"
      brew install "$@"
      ;;
    *) fail "no known package manager on this system; install by hand: $missing_names" ;;
  esac
}

check_rust() {
  for tool in cargo rustc; do
    if ! has_command "$tool"; then
      say "missing: $tool $MIN_RUST or newer; install Rust with rustup: see rust-lang.org/tools/install"
      return 1
    fi
  done
  version=$(rustc --version | cut -d ' ' -f 2)
  major=${version%%.*}
  rest=${version#*.}
  if [ "$major" -eq "${MIN_RUST%%.*}" ] && [ "${rest%%.*}" -lt "${MIN_RUST#*.}" ]; then
    say "too old: rustc $version; Lodestar needs $MIN_RUST or newer; run: rustup update stable"
    return 1
  fi
}

find_missing() {
  missing=""
  missing_names=""
  for tool in $TOOLS; do
    if ! has_tool "$tool"; then
      missing="$missing $tool"
      missing_names="${missing_names:+$missing_names, }$(describe "$tool")"
    fi
  done
}

install_missing() { # installs the packages of $missing
  packages=""
  for tool in $missing; do
    if [ "$system:$tool" = macos:compiler ]; then
      fail "a C++ compiler is missing; run: xcode-select --install"
    fi
    packages="$packages $(package_of "$tool")"
  done
  say "installing:$packages"
  # Word splitting is intended: each package becomes one argument.
  # shellcheck disable=SC2086
  install_packages $packages
  find_missing
  if [ -n "$missing" ]; then fail "still missing after the installation: $missing_names; install by hand"; fi
}

# --- shaderc ------------------------------------------------------------------------------------------------------------

# Prints the packages that contain shaderc and its parts.
shaderc_packages() {
  case "$system" in
    debian) echo "libshaderc-dev glslang-dev" ;;
    fedora) echo libshaderc-devel ;;
    arch | macos) echo shaderc ;;
  esac
}

# Prints the path of the system's shaderc library. Fails if there is none.
system_shaderc() {
  for file in /usr/lib/*-linux-gnu/libshaderc_combined.a /usr/lib64/libshaderc_shared.so /usr/lib/libshaderc_shared.so \
    /opt/homebrew/lib/libshaderc_combined.a /usr/local/lib/libshaderc_combined.a; do
    if [ -e "$file" ]; then
      echo "$file"
      return 0
    fi
  done
  return 1
}

# Whether all packages with the parts of shaderc are there. Debian's library needs glslang's beside it.
has_shaderc_packages() {
  system_shaderc >/dev/null || return 1
  [ "$system" != debian ] || [ -n "$(find /usr/lib/*-linux-gnu -maxdepth 1 -name libglslang.a 2>/dev/null)" ]
}

# Combines Debian's libshaderc_combined.a with the libraries that it lacks. The combined archive links.
combine_debian_shaderc() { # LIBRARY TARGET
  folder=$(dirname "$1")
  {
    echo "create $2"
    for part in shaderc_combined glslang SPIRV MachineIndependent GenericCodeGen OSDependent OGLCompiler \
      SPIRV-Tools-opt SPIRV-Tools glslang-default-resource-limits; do
      if [ -e "$folder/lib$part.a" ]; then echo "addlib $folder/lib$part.a"; fi
    done
    echo save
    echo end
  } | ar -M
}

links_shaderc() { # FOLDER
  trial=$(mktemp -d)
  echo 'extern "C" void *shaderc_compiler_initialize(void); int main() { return shaderc_compiler_initialize() == nullptr; }' \
    >"$trial/trial.cpp"
  status=0
  c++ "$trial/trial.cpp" -o "$trial/trial" "$1"/libshaderc_* -pthread >/dev/null 2>&1 && "$trial/trial" || status=1
  rm -rf "$trial"
  return "$status"
}

has_shaderc() { [ -n "$(find -L "$SHADERC_FOLDER/" -name 'libshaderc_*' 2>/dev/null)" ] && links_shaderc "$SHADERC_FOLDER"; }

# Puts a shaderc that links into $SHADERC_FOLDER. Fails if the system has none.
provide_shaderc() {
  if has_shaderc; then return 0; fi
  packages=$(shaderc_packages)
  if [ -n "$packages" ] && ! has_shaderc_packages; then
    say "installing: $packages"
    # Word splitting is intended: each package becomes one argument. A system without these packages builds shaderc from source.
    # shellcheck disable=SC2086
    (install_packages $packages) || true
  fi
  library=$(system_shaderc) || return 1
  rm -rf "$SHADERC_FOLDER"
  trial_folder=$(mktemp -d)
  case "$library" in
    /usr/lib/*-linux-gnu/*) combine_debian_shaderc "$library" "$trial_folder/libshaderc_combined.a" || true ;;
    *) ln -s "$library" "$trial_folder/$(basename "$library")" ;;
  esac
  if links_shaderc "$trial_folder"; then
    mkdir -p "$SHADERC_FOLDER"
    mv "$trial_folder"/libshaderc_* "$SHADERC_FOLDER/"
    rmdir "$trial_folder"
    say "cargo uses shaderc from $library"
  else
    rm -rf "$trial_folder"
    return 1
  fi
}

# --- A second driver for tests ------------------------------------------------------------------------------------------

# Unpacks SwiftShader from Debian's package chromium-common: 30 MB to download, 5 MB to keep.
unpack_swiftshader() { # DIR
  package=chromium-common
  [ "$system" = debian ] || fail "SwiftShader comes from Debian's package $package, which this system does not have"
  apt-cache show "$package" >/dev/null 2>&1 || as_root apt-get update >&2
  download=$(mktemp -d)
  trap 'rm -rf "$download"' EXIT
  (cd "$download" && apt-get download "$package" >&2) || fail "cannot download $package, which contains SwiftShader"
  dpkg-deb -x "$download/$package"_*.deb "$download/unpacked"
  driver=$(find "$download/unpacked" -name libvk_swiftshader.so)
  manifest=$(find "$download/unpacked" -name vk_swiftshader_icd.json)
  [ -n "$driver" ] && [ -n "$manifest" ] || fail "this system's $package does not contain SwiftShader"
  mkdir -p "$1"
  cp "$driver" "$manifest" "$1"
}

provide_swiftshader() { # DIR
  manifest_path="$1/vk_swiftshader_icd.json"
  if [ ! -e "$manifest_path" ] || [ ! -e "$1/libvk_swiftshader.so" ]; then unpack_swiftshader "$1"; fi
  (cd "$1" && echo "$(pwd)/vk_swiftshader_icd.json")
}

# --- A newer Mesa --------------------------------------------------------------------------------------------------------

# Runs apt on the list of backports alone. Lists and caches are in FOLDER, so the system's own are not touched.
apt_of_backports() { # FOLDER COMMAND ARGUMENT...
  folder=$1
  shift
  apt-get -q -o Dir::Etc::SourceList="$folder/sources.list" -o Dir::Etc::SourceParts=- -o Dir::State::Lists="$folder/lists" \
    -o Dir::Cache="$folder/cache" -o APT::Sandbox::User=root "$@" >&2
}

# Unpacks lavapipe from the package mesa-vulkan-drivers of Debian's backports: 12 MB to download. The system must have the
# libraries that this package names, above all the LLVM of the system's own package.
unpack_mesa() { # DIR
  package=mesa-vulkan-drivers
  release=$( (. /etc/os-release && [ "$ID" = debian ] && echo "$VERSION_CODENAME") 2>/dev/null) ||
    fail "a newer Mesa comes from Debian's backports, which this system does not have"
  download=$(mktemp -d)
  trap 'rm -rf "$download"' EXIT
  mkdir -p "$download/lists/partial" "$download/cache/archives/partial"
  echo "deb http://deb.debian.org/debian $release-backports main" >"$download/sources.list"
  apt_of_backports "$download" update || fail "cannot read the list of $release-backports, which contains the newer Mesa"
  (cd "$download" && apt_of_backports "$download" download "$package") ||
    fail "$release-backports has no package $package, so there is no newer Mesa for this system"
  dpkg-deb -x "$download/$package"_*.deb "$download/unpacked"
  driver=$(find "$download/unpacked" -name libvulkan_lvp.so)
  [ -n "$driver" ] || fail "$package of $release-backports does not contain lavapipe"
  lacking=$(ldd "$driver" | sed -n 's/^[[:space:]]*\(.*\) => not found$/\1/p' | tr '\n' ' ')
  [ -z "$lacking" ] || fail "the newer Mesa needs libraries that this system lacks: $lacking"
  mkdir -p "$1"
  cp "$driver" "$1"
}

# The manifest names the driver by its whole path, so it is written anew each time: the folder may have been moved.
provide_mesa() { # DIR
  if [ ! -e "$1/libvulkan_lvp.so" ]; then unpack_mesa "$1"; fi
  (
    cd "$1"
    printf '{"file_format_version": "1.0.0", "ICD": {"library_path": "%s", "api_version": "1.4.0"}}\n' \
      "$(pwd)/libvulkan_lvp.so" >lvp_icd.json
    echo "$(pwd)/lvp_icd.json"
  )
}

# --- A browser for tests ------------------------------------------------------------------------------------------------

provide_chromium() {
  for name in chromium chromium-browser google-chrome; do
    if has_command "$name"; then return 0; fi
  done
  install_packages chromium
}

# --- Several machines ----------------------------------------------------------------------------------------------------

# The crate that calls MPI reads MPI's headers with libclang.
provide_mpi() {
  if has_command mpicc && has_command mpirun && has_command clang; then return 0; fi
  case "$system" in
    debian) install_packages libopenmpi-dev openmpi-bin libclang-dev clang ;;
    fedora) install_packages openmpi-devel clang-devel clang ;;
    arch) install_packages openmpi clang ;;
    macos) install_packages open-mpi llvm ;;
    *) fail "MPI for this system is not known; install Open MPI with its headers, and libclang" ;;
  esac
}

provide_slurm() {
  if has_command slurmctld && has_command slurmd && has_command munged; then return 0; fi
  [ "$system" = debian ] || fail "this script installs Slurm on Debian only; install slurmctld, slurmd and munge"
  install_packages slurmctld slurmd slurm-client munge
}

# --- The denoiser --------------------------------------------------------------------------------------------------------

OIDN_PACKAGE=pyoidn==2.5.1.0
# SHA-256 of its wheels for Linux (x86_64) and macOS (x86_64, arm64). pip refuses a file with another hash.
OIDN_HASHES="32ad13368f8de1ef63001942ad05b02a00cd732d1206d97f352d3a3f606d823e
  c9d366e448c7a99ef54b936806ef2e6ae1e1383b0a3ba08f5509a39553fa03c2 ed803c20333d37873678d69abf1e3546e89dbaf4639408b7c92173e11b6355cb"

# Unpacks the libraries of the Python package. A wheel has copies where a library's folder has links, so each copy is replaced by
# a link.
unpack_oidn() { # DIR
  has_command python3 && python3 -m pip --version >/dev/null 2>&1 ||
    fail "Python with pip is missing; install it (Debian: python3-pip), or unpack a release of Open Image Denoise 2 and set LODESTAR_OIDN"
  download=$(mktemp -d)
  trap 'rm -rf "$download"' EXIT
  # shellcheck disable=SC2086 # Hashes are words.
  echo "$OIDN_PACKAGE" $(printf -- '--hash=sha256:%s ' $OIDN_HASHES) >"$download/requirements.txt"
  python3 -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: --dest "$download" --require-hashes \
    -r "$download/requirements.txt" >&2 ||
    fail "cannot download $OIDN_PACKAGE, which contains Open Image Denoise; unpack a release of it and set LODESTAR_OIDN"
  python3 -m zipfile -e "$download"/*.whl "$download/unpacked"
  libraries="$download/unpacked/pyoidn/oidn/lib"
  [ -n "$(find "$libraries" -name 'libOpenImageDenoise.*' 2>/dev/null)" ] || fail "$OIDN_PACKAGE does not contain Open Image Denoise"
  rm -rf "$libraries/cmake"
  for file in "$libraries"/lib*; do
    for copy in "$file".* "${file%.*}".*.dylib; do
      if [ -f "$copy" ] && [ ! -L "$copy" ] && [ "$copy" != "$file" ] && cmp -s "$file" "$copy"; then ln -sf "$(basename "$copy")" "$file"; fi
    done
  done
  # The libraries look for each other in a folder of this name.
  mkdir -p "$1/lib"
  cp -P "$libraries"/lib* "$1/lib"
}

provide_oidn() { # DIR
  if [ -z "$(find -L "$1/lib" -maxdepth 1 -name 'libOpenImageDenoise.*' 2>/dev/null)" ]; then unpack_oidn "$1"; fi
  (cd "$1" && pwd)
}

# --- The book -----------------------------------------------------------------------------------------------------------

MDBOOK_VERSION=0.5.4

# Prints the path of mdbook. Installs it into the folder TOOLS if it is missing. An optimized build would take twice as long,
# and this book is built in seconds either way.
provide_mdbook() { # TOOLS
  if command -v mdbook; then return 0; fi
  if [ ! -x "$1/bin/mdbook" ]; then
    check_rust >&2 || exit 1
    say "compiling mdbook $MDBOOK_VERSION into $1" >&2
    CARGO_PROFILE_DEV_DEBUG=0 cargo install mdbook --version "$MDBOOK_VERSION" --locked --debug --no-default-features \
      --features search --root "$1" --quiet >&2 || fail "cannot compile mdbook; install it by hand: see rust-lang.github.io/mdBook"
  fi
  (cd "$1/bin" && echo "$(pwd)/mdbook")
}

main() {
  system=$(detect_system)
  if [ "${1:-}" = --book ]; then
    provide_mdbook "$(dirname "$0")/target/tools"
    exit 0
  fi
  if [ "${1:-}" = --chromium ]; then
    provide_chromium
    exit 0
  fi
  if [ "${1:-}" = --mpi ]; then
    provide_mpi
    exit 0
  fi
  if [ "${1:-}" = --slurm ]; then
    provide_slurm
    exit 0
  fi
  if [ "${1:-}" = --swiftshader ]; then
    provide_swiftshader "${2:-$(dirname "$0")/target/swiftshader}"
    exit 0
  fi
  if [ "${1:-}" = --mesa ]; then
    provide_mesa "${2:-$(dirname "$0")/target/mesa}"
    exit 0
  fi
  if [ "${1:-}" = --oidn ]; then
    provide_oidn "${2:-$(dirname "$0")/target/oidn}"
    exit 0
  fi
  find_missing
  case "${1:-}" in
    --check)
      status=0
      check_rust || status=1
      if [ -n "$missing" ]; then
        say "missing: $missing_names"
        status=1
      fi
      if ! has_shaderc; then
        say "no shaderc in $SHADERC_FOLDER: cargo will build it from source"
        TOOLS=$SOURCE_TOOLS
        find_missing
        if [ -n "$missing" ]; then
          say "missing for that: $missing_names"
          status=1
        fi
      fi
      if [ "$status" -eq 0 ]; then say "all required tools are installed"; fi
      exit "$status"
      ;;
    --source-tools)
      TOOLS="$TOOLS $SOURCE_TOOLS"
      find_missing
      ;;
    "") ;;
    *) fail "unknown argument $1; usage: setup.sh [--check | --source-tools | --swiftshader [DIR] | --mesa [DIR] | --oidn [DIR] | --mpi | --slurm | --chromium | --book]" ;;
  esac
  if [ -n "$missing" ]; then
    say "missing: $missing_names"
    install_missing
  fi
  if ! provide_shaderc; then
    say "this system has no shaderc that links: cargo will build it from source"
    TOOLS=$SOURCE_TOOLS
    find_missing
    if [ -n "$missing" ]; then install_missing; fi
  fi
  check_rust || exit 1
  say "all required tools are installed"
}

main "$@"
