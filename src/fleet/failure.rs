//! Failures and results as ranks send them to each other.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// An error in a form that can be sent. Errors after which a session does something special keep their kind.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Failure {
    LoopCut(String),
    DeviceLost { call: String, note: String },
    OutOfDeviceMemory { call: String, note: String },
    Wrong(String),
    Other(String),
}

impl Failure {
    pub fn of(error: &Error) -> Self {
        match error {
            Error::LoopCut(message) => Self::LoopCut(message.clone()),
            Error::DeviceLost { call, note } => Self::DeviceLost { call: call.clone(), note: note.clone() },
            Error::OutOfDeviceMemory { call, note } => {
                Self::OutOfDeviceMemory { call: call.clone(), note: note.clone() }
            }
            Error::Render(message) => Self::Wrong(message.clone()),
            error => Self::Other(error.to_string()),
        }
    }

    /// The error, which names the rank where it came from.
    pub fn into_error(self, rank: &str) -> Error {
        let prefix = if rank.is_empty() { String::new() } else { format!("{rank}: ") };
        let named = |text: String| format!("{prefix}{text}");
        match self {
            Self::LoopCut(message) => Error::LoopCut(named(message)),
            Self::DeviceLost { call, note } => Error::DeviceLost { call: named(call), note },
            Self::OutOfDeviceMemory { call, note } => Error::OutOfDeviceMemory { call: named(call), note },
            Self::Wrong(message) => Error::Render(named(message)),
            Self::Other(message) => Error::Device(named(message)),
        }
    }
}

/// Last byte of a message with a result.
const RESULT: u8 = 0;
/// Last byte of a message with a failure.
const FAILURE: u8 = 1;

/// A result or a failure as a message.
pub(super) fn pack(result: Result<Vec<u8>, Failure>) -> Vec<u8> {
    // The mark is the last byte, so that a large result need not be moved.
    let (mut bytes, mark) = match result {
        Ok(bytes) => (bytes, RESULT),
        Err(failure) => (encode(&failure), FAILURE),
    };
    bytes.push(mark);
    bytes
}

/// The result or the failure of a message.
pub(super) fn unpack(mut bytes: Vec<u8>) -> Result<Vec<u8>, Failure> {
    match bytes.pop() {
        Some(RESULT) => Ok(bytes),
        _ => Err(decode(&bytes).unwrap_or_else(|error| Failure::Other(error.to_string()))),
    }
}

/// A value as bytes.
pub(super) fn encode<T: Serialize>(value: &T) -> Vec<u8> {
    // Values of these types can always be written into memory.
    postcard::to_stdvec(value).unwrap_or_default()
}

/// The value of bytes that another rank has encoded.
pub(super) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    postcard::from_bytes(bytes).map_err(|error| {
        Error::Render(format!("a message of another rank cannot be read ({error}); all ranks need the same program"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_and_failures_arrive_as_they_were_sent() {
        assert_eq!(unpack(pack(Ok(vec![1, 2, 3]))), Ok(vec![1, 2, 3]));
        let lost = Error::DeviceLost { call: "trace".into(), note: String::new() };
        for error in [lost, Error::LoopCut("a".into()), Error::Render("b".into()), Error::Settings("c".into())] {
            let arrived = unpack(pack(Err(Failure::of(&error)))).unwrap_err().into_error("rank 3 on a machine");
            assert_eq!(arrived.to_string(), format!("rank 3 on a machine: {error}"));
        }
    }

    #[test]
    fn bytes_that_are_no_message_are_a_failure() {
        assert!(unpack(Vec::new()).is_err() && unpack(vec![250, FAILURE]).is_err());
    }
}
