//! Words and numbers of a text mesh, line by line.

/// A place in a text.
pub(super) struct Words<'a> {
    text: &'a [u8],
    at: usize,
    line: u32,
}

impl<'a> Words<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0, line: 1 }
    }

    /// The current line, counted from 1.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// The next word of the current line; empty at its end.
    pub fn next(&mut self) -> &'a [u8] {
        let rest = &self.text[self.at..];
        let blanks = rest.iter().take_while(|&&byte| byte <= b' ' && byte != b'\n').count();
        let rest = &rest[blanks..];
        let length = rest.iter().take_while(|&&byte| byte > b' ').count();
        self.at += blanks + length;
        &rest[..length]
    }

    /// The next words of the current line as finite numbers.
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

    /// The next `count` bytes, whatever they are; `None` where there are fewer.
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

/// A finite number.
pub(super) fn parse_float(word: &[u8]) -> Result<f32, String> {
    let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()).filter(|x: &f32| x.is_finite());
    number.ok_or_else(|| format!("`{}` is not a finite number", String::from_utf8_lossy(word)))
}
