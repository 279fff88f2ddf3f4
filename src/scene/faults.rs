//! Faults of a scene, collected so that one message lists all of them.

use std::collections::HashSet;

use crate::{Error, Result};

/// Most faults that are kept while a file is read. A message lists fewer.
const MOST_KEPT: usize = 1000;

/// Faults found so far. Two references to one faulty object give one fault.
#[derive(Debug, Default)]
pub(in crate::scene) struct Faults {
    list: Vec<Error>,
    seen: HashSet<String>,
    /// Whether any error was added, also one without a message of its own ([`told_before`]).
    failed: bool,
}

/// Error of an object that is used again after its faults were returned to its first user. It adds no line to the list.
pub(in crate::scene) fn told_before() -> Error {
    Error::Several(Vec::new())
}

impl Faults {
    /// Value of `result`; an error is added to the list.
    pub fn keep<T>(&mut self, result: Result<T>) -> Option<T> {
        result.map_err(|error| self.add(error)).ok()
    }

    /// Whether there are so many that more help nobody.
    pub fn is_full(&self) -> bool {
        self.list.len() >= MOST_KEPT
    }

    /// Adds an error.
    pub fn add(&mut self, error: Error) {
        self.failed = true;
        match error {
            Error::Several(errors) => errors.into_iter().for_each(|error| self.add(error)),
            error if self.seen.insert(error.to_string()) => self.list.push(error),
            _ => {}
        }
    }

    /// All faults as one error, in the order of files and lines.
    pub fn into_result(mut self) -> Result<()> {
        self.list.sort_by_cached_key(|error| match error {
            Error::Scene { file, line, .. } => (file.clone(), line.unwrap_or(0)),
            _ => (Default::default(), u32::MAX),
        });
        match self.list.len() {
            0 if !self.failed => Ok(()),
            1 => self.list.into_iter().try_for_each(Err),
            _ => Err(Error::Several(self.list)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_listed_once_and_in_order() {
        let fault = |line, message: &str| Error::scene("a.xml", Some(line), message);
        let mut faults = Faults::default();
        assert_eq!(faults.keep(Ok(1)), Some(1));
        assert_eq!(faults.keep::<u32>(Err(fault(7, "later"))), None);
        faults.add(Error::Several(vec![fault(3, "first"), fault(7, "later")]));
        let text = faults.into_result().unwrap_err().to_string();
        assert_eq!(text, "the scene has 2 faults:\n  a.xml:3: first\n  a.xml:7: later");
        let mut only = Faults::default();
        only.add(fault(3, "first"));
        assert_eq!(only.into_result().unwrap_err().to_string(), "a.xml:3: first");
        assert!(Faults::default().into_result().is_ok());
    }

    #[test]
    fn an_error_that_was_told_before_is_an_error_without_a_line() {
        let mut inner = Faults::default();
        inner.add(told_before());
        let again = inner.into_result().unwrap_err();
        let mut outer = Faults::default();
        outer.add(Error::scene("a.xml", Some(3), "first"));
        outer.add(again);
        assert_eq!(outer.into_result().unwrap_err().to_string(), "a.xml:3: first");
    }
}
