//! Words and numbers of a text mesh, line by line.

use crate::quoted;

/// Position within a text.
#[derive(Clone)]
pub(super) struct Words<'a> {
    text: &'a [u8],
    at: usize,
    line: u32,
}

impl<'a> Words<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0, line: 1 }
    }

    /// Current line, counted from 1.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// Reads the next word of the current line; empty at its end.
    pub fn next(&mut self) -> &'a [u8] {
        let rest = &self.text[self.at..];
        let blanks = rest.iter().take_while(|&&byte| byte <= b' ' && byte != b'\n').count();
        let rest = &rest[blanks..];
        let length = rest.iter().take_while(|&&byte| byte > b' ').count();
        self.at += blanks + length;
        &rest[..length]
    }

    /// Next word of the current line, which is not read yet; empty at its end.
    pub fn peek(&self) -> &'a [u8] {
        self.clone().next()
    }

    /// Reads the next words of the current line as finite numbers.
    pub fn floats<const N: usize>(&mut self) -> Result<[f32; N], String> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let word = self.next();
            if word.is_empty() {
                return Err(format!("this line should have {N} numbers"));
            }
            *number = parse_float(word)?;
        }
        Ok(numbers)
    }

    /// Reads the next `count` bytes, whatever they are; `None` where there are fewer.
    pub fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let bytes = self.text.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(bytes)
    }

    /// Goes to the next line; false where there is none.
    pub fn next_line(&mut self) -> bool {
        let rest = &self.text[self.at..];
        match rest.iter().position(|&byte| byte == b'\n') {
            Some(end) => {
                self.at += end + 1;
                self.line = self.line.saturating_add(1);
                true
            }
            None => {
                self.at = self.text.len();
                false
            }
        }
    }
}

/// Parses a finite number, correctly rounded.
pub(super) fn parse_float(word: &[u8]) -> Result<f32, String> {
    let parse = || std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    let number = short_decimal(word).or_else(parse).filter(|number| number.is_finite());
    number.ok_or_else(|| format!("{} is not a finite number", quoted::bytes(word)))
}

/// Most digits of a decimal whose mantissa and power of ten are both exact as a double.
const EXACT_DIGITS: usize = 15;
const POWERS: [f64; EXACT_DIGITS + 1] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// Parses a decimal of few digits without exponent, the usual form in meshes: a single division rounds it correctly
/// (Clinger 1990). `None` for other forms, and for numbers midway between two singles.
fn short_decimal(word: &[u8]) -> Option<f32> {
    let (is_negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        _ => (false, word),
    };
    let (mut mantissa, mut places, mut point) = (0_u64, 0, false);
    if digits.len() > EXACT_DIGITS || digits.is_empty() || digits == b"." {
        return None;
    }
    for &byte in digits {
        match byte {
            b'0'..=b'9' => {
                mantissa = 10 * mantissa + u64::from(byte - b'0');
                places += usize::from(point);
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    let number = mantissa as f64 / POWERS[places];
    // Midway between two singles, the rounding of the double could decide the result.
    let is_midway = number.to_bits() & 0x1fff_ffff == 0x1000_0000;
    (!is_midway).then_some(if is_negative { -number } else { number } as f32)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{parse_float, short_decimal};

    proptest! {
        #[test]
        fn numbers_are_those_of_the_standard_library(text in "[-+]?[0-9]{0,9}[.]?[0-9]{0,9}(e[-+]?[0-9]{1,2})?") {
            let expected = text.parse::<f32>().ok().filter(|number| number.is_finite());
            prop_assert_eq!(parse_float(text.as_bytes()).ok().map(f32::to_bits), expected.map(f32::to_bits));
        }
    }

    #[test]
    fn ties_are_left_to_others() {
        // 16777217 is midway between 16777216 and 16777218 and rounds to even. A double cannot tell a number slightly
        // above from it.
        assert_eq!(short_decimal(b"16777217"), None);
        assert_eq!(parse_float(b"16777217.00000001"), Ok(16_777_218.0));
        assert_eq!(parse_float(b"-0").map(f32::to_bits), Ok((-0.0_f32).to_bits()));
        assert_eq!(short_decimal(b"-2.486615"), Some(-2.486615));
        assert!(parse_float(b".").is_err() && parse_float(b"-").is_err() && parse_float(b"inf").is_err());
    }
}
