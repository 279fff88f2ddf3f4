# Commands that contributors type: `just` lists them, `just test` runs one. It needs https://just.systems; each line can be typed without it, too.

_list:
    @just --list --unsorted

# Install what is missing on this system
setup:
    ./setup.sh

# Build the program: target/release/lodestar
build:
    cargo build --release

# Run the quick tier of the tests
test:
    cargo test --release

# Run the tests of a file whose names contain a word: just test-one render determinism
test-one file word="":
    cargo test --release --test {{ file }} -- {{ word }}

# Check the format, warnings and documents, which takes less time than the tests
lint:
    cargo fmt --check
    cargo clippy --release --all-targets -- -D warnings
    cargo test --release --test hygiene

# Plant known faults in the kernels: the proofs must find each of them
faults:
    LODESTAR_FULL=1 cargo test --release --test proofs tampering

# Compare the speed of two builds: just bench BEFORE AFTER
bench before after:
    benches/before_after.sh {{ before }} {{ after }}

# Show that two builds render the same bits: just bits BEFORE AFTER
bits before after:
    tests/same_bits.sh {{ before }} {{ after }}

# Render the pictures of the gallery
pictures:
    benches/pictures.sh

# Build the book in target/book
docs:
    docs/build.sh

# Build the crate, the tarball, the .deb and the wheel in target/packages
package:
    packages/build.sh --compare

# Build and test the program for Windows, under Wine
windows:
    tests/windows.sh

# Run all that CI runs
ci:
    .ci/run
