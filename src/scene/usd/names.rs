//! Names that the parser cannot read.

use crate::quoted;

/// Refuses a path, or the name of a prim or of a property, that closes a brace before it opens one. The parser does not end on it.
pub(super) fn check_name(name: &[u8]) -> Result<(), String> {
    match name.iter().find(|&&byte| byte == b'{' || byte == b'}') {
        Some(b'}') => Err(format!("its name {} closes a brace that is not open", quoted::bytes(name))),
        _ => Ok(()),
    }
}
