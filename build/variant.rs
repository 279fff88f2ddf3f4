//! Writes the specialization constants as one struct.

use std::fmt::Write as _;

use super::declarations::SpecializationConstant;

/// `Variant`, with a field for each constant, its default, and its entries for a pipeline.
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
    /// The defaults that GLSL gives.
    pub const DEFAULT: Self = Self {{
{defaults}    }};

    /// (id, bits) of every constant.
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
