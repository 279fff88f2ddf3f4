//! Reader of compressed bytes, with every bound checked.

/// Fault of compressed data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(super) enum Fault {
    #[error("they end too early")]
    Short,
    #[error("they go on beyond their last element")]
    Long,
    #[error("their first byte names another mode or version")]
    Head,
    #[error("they have a code that does not exist")]
    Code,
}

/// Bytes that have not been read yet.
pub(super) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    pub fn is_at_end(&self) -> bool {
        self.rest.is_empty()
    }

    /// The next bytes.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(Fault::Short)?;
        self.rest = rest;
        Ok(taken)
    }

    /// The next byte.
    pub fn byte(&mut self) -> Result<u8, Fault> {
        Ok(self.take(1)?[0])
    }

    /// The next number of up to 32 bits: seven bits a byte, the lowest first (LEB128).
    pub fn number(&mut self) -> Result<u32, Fault> {
        let mut number = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(Fault::Code)
    }
}

/// The signed number that an unsigned one stands for: 0, -1, 1, -2, and so on.
pub(super) fn signed(number: u32) -> u32 {
    number >> 1 ^ (number & 1).wrapping_neg()
}

#[test]
fn numbers_have_seven_bits_a_byte() {
    let mut reader = Reader::new(&[0x7f, 0x81, 0x04, 0xff, 0xa0, 0x05, 0x80]);
    assert_eq!([reader.number(), reader.number(), reader.number()], [Ok(0x7f), Ok(0x201), Ok(0x1_507f)]);
    assert_eq!(reader.number(), Err(Fault::Short));
    assert_eq!(Reader::new(&[0xff; 8]).number(), Err(Fault::Code));
    assert_eq!([0, 1, 2, 3].map(|number| signed(number) as i32), [0, -1, 1, -2]);
}
