//! Tiers of the tests. `cargo test --release` runs the quick tier, which tests every claim in small. `LODESTAR_FULL=1`
//! adds the long tier, and `tests/long.sh` runs one part of it.

use std::env;

/// Whether this run includes the long tier.
pub fn is_full() -> bool {
    env::var_os("LODESTAR_FULL").is_some()
}

/// Whether to skip a test that belongs to the long tier. A skipped test prints where the quick tier tests its claim in
/// small.
pub fn is_skipped(in_small: &str) -> bool {
    let skipped = !is_full();
    if skipped {
        println!("skipped: LODESTAR_FULL is not set; in small: {in_small}");
    }
    skipped
}

/// All of `cases` in the long tier, the first `count` of them in the quick tier.
pub fn some_of<T>(cases: &[T], count: usize) -> &[T] {
    if is_full() { cases } else { &cases[..count.min(cases.len())] }
}

/// Whether this run has the case at `index`: it has all cases, or with `LODESTAR_PART=K/N` every N-th from the K-th on.
pub fn has_case(index: usize) -> bool {
    env::var("LODESTAR_PART").map_or(true, |part| is_in_part(&part, index))
}

/// Whether the part K/N has the case at `index`.
pub fn is_in_part(part: &str, index: usize) -> bool {
    let numbers = part.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    let valid = numbers.filter(|&(k, n): &(usize, usize)| (1..=n).contains(&k));
    let (k, n) = valid.expect("LODESTAR_PART must be K/N, such as 2/6, with K from 1 to N");
    index % n == k - 1
}
