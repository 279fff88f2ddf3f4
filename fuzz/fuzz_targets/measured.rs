//! Files of measured materials: whatever they hold, they are read or refused in one sentence, and what is read has tables of the size that
//! was told before.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lodestar::encode::measured::words;
use lodestar::scene::measured::Measured;

fuzz_target!(|input: &[u8]| match Measured::read(input) {
    Ok(measured) => {
        let words = words(&measured);
        assert_eq!(words.len() as u64, measured.word_count());
    }
    Err(message) => assert_eq!(message.lines().count(), 1, "{message}"),
});
