//! Writer of the struct that holds all specialization constants.

use std::fmt::Write as _;

use super::glsl::declarations::SpecializationConstant;

/// Code of the struct `Variant`: a field for each constant, the defaults, and the entries for a pipeline.
pub fn code(constants: &[SpecializationConstant]) -> String {
    let (mut fields, mut defaults, mut entries) = (String::new(), String::new(), String::new());
    for c in constants {
        let field = c.name.to_lowercase();
        let comment = if c.comment.is_empty() { format!("`{}` in GLSL.", c.name) } else { c.comment.clone() };
        let bits = match c.rust_type {
            "f32" => format!("self.{field}.to_bits()"),
            "bool" => format!("u32::from(self.{field})"),
            _ => format!("self.{field}"),
        };
        let _ = writeln!(fields, "    /// {comment}\n    pub {field}: {},", c.rust_type);
        let _ = writeln!(defaults, "        {field}: {},", c.default);
        let _ = writeln!(entries, "            ({}, {bits}),", c.id);
    }
    format!(
        "/// Every specialization constant of the kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {{
{fields}}}

impl Variant {{
    /// Defaults as declared in GLSL.
    pub const DEFAULT: Self = Self {{
{defaults}    }};

    /// Pairs (id, bits) of all constants.
    pub fn entries(&self) -> Vec<(u32, u32)> {{
        vec![
{entries}        ]
    }}
}}

impl Default for Variant {{
    fn default() -> Self {{
        Self::DEFAULT
    }}
}}
"
    )
}
